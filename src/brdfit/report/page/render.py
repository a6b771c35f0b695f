"""The page as one text: template, style sheet, script and data together, nothing from outside."""

from __future__ import annotations

import base64
import hashlib
import json
from functools import cache
from importlib import resources
from typing import Any

from brdfit.physics import Verdict
from brdfit.report.page.contents import Contents
from brdfit.report.page.pictures import MOST_DIFFERENT
from brdfit.versions import version_of

__all__ = ["page_of"]

# The verdict is told by a word and a sign, not by colour alone.
_MARKS = {
    Verdict.GOOD: "✓",
    Verdict.LOOK: "!",
    Verdict.WRONG: "✗",
    Verdict.UNKNOWN: "?",
}


def page_of(contents: Contents) -> str:
    """Return the whole HTML document.

    Everything in `contents` is escaped, but for the plots, which were written as XML. The
    page's own policy lets a browser run no script and apply no style but the two that are
    named by their hash, and load nothing: a text that slipped through could do no harm.
    """
    from markupsafe import Markup

    style, script = _static("report.css"), _static("report.js")
    page: str = _template().render(
        c=_with_markup(contents),
        marks=_MARKS,
        most_different=f"{MOST_DIFFERENT:g}",
        version=version_of(),
        style=Markup(style),
        style_hash=_policy_hash(style),
        script=Markup(script),
        script_hash=_policy_hash(script),
        slice_json=Markup(_script_json(contents.slices.data)),
    )
    return page


@cache
def _template() -> Any:
    from jinja2 import Environment, StrictUndefined

    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    text = resources.files("brdfit.report.page").joinpath("report.html.j2").read_text("utf-8")
    return environment.from_string(text)


def _with_markup(contents: Contents) -> dict[str, Any]:
    """Return the fields by name, plots marked as the XML that they are."""
    from dataclasses import fields, replace

    from markupsafe import Markup

    def marked(plots: tuple[tuple[str, str], ...]) -> tuple[tuple[str, str], ...]:
        return tuple((caption, Markup(plot)) for caption, plot in plots)

    trust = contents.trust
    if trust is not None:
        trust = replace(trust, bar=Markup(trust.bar), maps=marked(trust.maps))
    plain = replace(
        contents,
        slices=replace(contents.slices, plots=marked(contents.slices.plots)),
        trust=trust,
        health=tuple(replace(one, plot=Markup(one.plot)) for one in contents.health),
    )
    return {field.name: getattr(plain, field.name) for field in fields(plain)}


def _static(name: str) -> str:
    text = resources.files("brdfit.report").joinpath("static", name).read_text("utf-8")
    # within an element only its own end tag could end it
    assert "</script" not in text
    assert "</style" not in text
    return text


def _policy_hash(text: str) -> str:
    digest = hashlib.sha256(text.encode("utf-8")).digest()
    return "sha256-" + base64.b64encode(digest).decode("ascii")


def _script_json(data: dict[str, Any]) -> str:
    """Return JSON that can stand within a script element: no tag or comment can begin in it."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text

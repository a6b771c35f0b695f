"""Write the generated parts of docs/formats.md from the data sheets of the formats.

python tools/formats_doc.py            # rewrite the page
python tools/formats_doc.py --check    # exit 1 if it is out of date
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from brdfit.formats import list_formats
from brdfit.formats.columns import ALIASES
from brdfit.formats.declaration import COORDINATES
from brdfit.formats.sheet import FormatSheet

PAGE = Path(__file__).resolve().parents[1] / "docs" / "formats.md"


def support_table() -> str:
    rows = [
        "| format | files | read samples | read table | write samples | write table | options |",
        "|---|---|---|---|---|---|---|",
    ]
    rows += [_row(sheet) for sheet in sorted(list_formats(), key=lambda sheet: sheet.name)]
    return "\n".join(rows)


def details() -> str:
    return "\n\n".join(
        _detail(sheet) for sheet in sorted(list_formats(), key=lambda sheet: sheet.name)
    )


def coordinates_table() -> str:
    rows = ["| coordinates | columns of `directions`, in this order |", "|---|---|"]
    rows += [f"| `{name}` | {', '.join(columns)} |" for name, columns in COORDINATES.items()]
    return "\n".join(rows)


def aliases_table() -> str:
    rows = ["| column | names that are taken for it |", "|---|---|"]
    rows += [f"| `{name}` | {', '.join(aliases)} |" for name, aliases in ALIASES.items()]
    return "\n".join(rows)


GENERATED = {
    "support": support_table,
    "coordinates": coordinates_table,
    "aliases": aliases_table,
    "details": details,
}


def render(page: str) -> str:
    """Return the page with the text between each pair of marks made anew."""
    for name, make in GENERATED.items():
        begin, end = f"<!-- begin {name} -->", f"<!-- end {name} -->"
        if begin not in page or end not in page:
            raise SystemExit(f"{PAGE.name}: the marks {begin} and {end} are missing.")
        block = f"{begin}\n{make()}\n{end}"
        page = re.sub(
            re.escape(begin) + ".*?" + re.escape(end), lambda _, b=block: b, page, flags=re.DOTALL
        )
    return page


def _row(sheet: FormatSheet) -> str:
    can = (sheet.read_samples, sheet.read_table, sheet.write_samples, sheet.write_table)
    marks = " | ".join("yes" if entry is not None else "" for entry in can)
    options = ", ".join(f"`{option}`" for option in sheet.options)
    return f"| `{sheet.name}` | {', '.join(sheet.extensions)} | {marks} | {options} |"


def _detail(sheet: FormatSheet) -> str:
    lines = [
        f"### {sheet.name}: {sheet.title}",
        "",
        f"- Convention: {sheet.convention}.",
        f"- Described in: {sheet.specification}.",
    ]
    if sheet.write_samples is not None or sheet.write_table is not None:
        lines.append(f"- Written and read back: {_precision(sheet)}.")
    if sheet.loses:
        lines.append(f"- Writing loses: {sheet.loses}.")
    return "\n".join(lines)


def _precision(sheet: FormatSheet) -> str:
    if sheet.averages:
        return (
            f"not the table's own values (what stands in their place is under what writing loses); "
            f"of a smooth material half of the values are within {sheet.precision:.0%}"
        )
    if sheet.precision == 0.0:
        return "every bit"
    return (
        f"a value changes by at most {sheet.precision:.0e} of itself, at directions the file holds"
    )


def main(arguments: list[str]) -> int:
    page = PAGE.read_text(encoding="utf-8")
    made = render(page)
    if "--check" in arguments:
        if made != page:
            print(f"{PAGE.name} is out of date: run python tools/formats_doc.py", file=sys.stderr)
            return 1
        return 0
    PAGE.write_text(made, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

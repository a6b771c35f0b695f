"""Fit a target's material to a BRDF, and say how far it stays from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from brdfit.albedo import Evaluable
from brdfit.arrays import FloatArray
from brdfit.errors import UsageError
from brdfit.export import ggx_material, gltf_material, openpbr_material
from brdfit.export.form import AnalyticMaterial, Form
from brdfit.export.objective import Views
from brdfit.metrics import perceptual_error
from brdfit.models import Ggx
from brdfit.progress import Progress, silent
from brdfit.render import Sphere, studio

__all__ = ["DEFAULT_SETTINGS", "MODELS", "Analytic", "AnalyticSettings", "fit_analytic"]

MODELS: Mapping[str, tuple[Form, ...]] = MappingProxyType(
    {
        "ggx": ggx_material.FORMS,
        "gltf": gltf_material.FORMS,
        "openpbr": openpbr_material.FORMS,
    }
)
"""Name of a target's material -> its forms, the plainer first."""


@dataclass(frozen=True)
class AnalyticSettings:
    """How an analytic material is fitted."""

    size: int = 32
    """Pixels along an edge of the sphere that is fitted."""
    judged: int = 64
    """Pixels along an edge of the sphere that the error is stated on."""
    highlight_weight: float = 0.05
    """Weight of the values around the specular peak beside the picture."""
    worth: float = 0.1
    """A richer form is taken if it lowers the perceptual error by more than this."""
    forms: tuple[str, ...] = ()
    """Forms to try, by name; none = all."""
    steps: int = 60
    """Most evaluations of the slope in one fit."""


DEFAULT_SETTINGS = AnalyticSettings()


@dataclass(frozen=True)
class Analytic:
    """The material that came closest, and the errors of all forms that were tried."""

    model: str
    """Name of the target's material."""
    form: str
    """Which of its forms."""
    material: AnalyticMaterial
    perceptual_error: float
    """Mean CIEDE2000 on the studio sphere, against the reference."""
    tried: Mapping[str, float]
    """Form -> its perceptual error."""
    settings: AnalyticSettings


def fit_analytic(
    reference: Evaluable,
    model: str,
    settings: AnalyticSettings = DEFAULT_SETTINGS,
    progress: Progress = silent,
) -> Analytic:
    """Return the analytic material of the target `model` that looks most like `reference`.

    `reference` answers in R, G, B (linear sRGB); `model` is a key of `MODELS`. Every form is
    fitted, and the plainest taken whose error no richer one lowers by more than
    `settings.worth`. The same input gives the same result.
    """
    if model not in MODELS:
        raise UsageError(f"model: found {model!r} but there are {', '.join(MODELS)}.")
    straight = np.array([[0.0, 0.0, 1.0]])
    channels = reference.evaluate(straight, straight).shape[1]
    if channels != 3:
        raise UsageError(
            f"reference: found {channels} channels but an analytic material is R, G, B. Convert "
            f"the table with brdfit.report.rgb.rgb_table first."
        )
    forms = _forms(model, settings)
    views = Views.of(reference, settings.size, settings.highlight_weight)
    judge = _Judge(reference, settings.judged)
    guess = _refined(views, settings)
    found: list[tuple[float, Form, AnalyticMaterial]] = []
    for done, form in enumerate(forms):
        progress("fitting", done, len(forms))
        material = _best(form, views, guess, settings)
        found.append((judge(material), form, material))
    progress("fitting", len(forms), len(forms))
    chosen = found[0]
    for one in found[1:]:
        if one[0] < chosen[0] - settings.worth:
            chosen = one
    tried = MappingProxyType({form.name: error for error, form, _ in found})
    return Analytic(model, chosen[1].name, chosen[2], chosen[0], tried, settings)


def _forms(model: str, settings: AnalyticSettings) -> list[Form]:
    known = [form.name for form in MODELS[model]]
    unknown = [name for name in settings.forms if name not in known]
    if unknown:
        raise UsageError(f"forms: found {unknown[0]!r} but {model} has {', '.join(known)}.")
    return [form for form in MODELS[model] if not settings.forms or form.name in settings.forms]


class _Judge:
    """The perceptual error of a material against the reference."""

    def __init__(self, reference: Evaluable, size: int) -> None:
        self._sphere, self._lights = Sphere(size), studio()
        self._image = self._sphere.shade(reference, self._lights)

    def __call__(self, material: AnalyticMaterial) -> float:
        image = self._sphere.shade(material, self._lights)
        return perceptual_error(self._image, image, self._sphere.mask)


def _refined(views: Views, settings: AnalyticSettings) -> Ggx:
    (form,) = ggx_material.FORMS
    material, _ = _solve(form, form.starts(views.first_guess())[0], views, settings)
    assert isinstance(material, ggx_material.GgxMaterial)
    return material.model


def _best(form: Form, views: Views, guess: Ggx, settings: AnalyticSettings) -> AnalyticMaterial:
    solved = [_solve(form, start, views, settings) for start in form.starts(guess)]
    return min(solved, key=lambda pair: pair[1])[0]


def _solve(
    form: Form, start: Mapping[str, FloatArray], views: Views, settings: AnalyticSettings
) -> tuple[AnalyticMaterial, float]:
    from scipy.optimize import least_squares

    def residuals(u: FloatArray) -> FloatArray:
        return views.residuals(form.make(form.decode(u)))

    fit = least_squares(
        residuals,
        form.encode(start),
        bounds=form.bounds,
        loss="soft_l1",
        x_scale="jac",
        max_nfev=settings.steps,
        xtol=1e-6,
        ftol=1e-7,
    )
    return form.make(form.decode(fit.x)), float(fit.cost)

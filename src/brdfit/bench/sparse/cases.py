"""What is reconstructed, from which directions, and how a result is judged."""

from __future__ import annotations

import dataclasses
import warnings
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from brdfit.arrays import FloatArray
from brdfit.bench.ledger import Record, figure
from brdfit.bench.real_files import generator
from brdfit.bench.sparse.published import HELD_OUT, SAMPLES
from brdfit.errors import BrdfitError, BrdfitWarning, UsageError
from brdfit.geometry import cos_incident_outgoing, directions_from_half_diff
from brdfit.render import Sphere, studio
from brdfit.samples import Samples

if TYPE_CHECKING:
    from brdfit.populations import Population
    from brdfit.reconstruct.result import Method

__all__ = ["IMAGE_METRICS", "Scene", "SparseSettings", "draw_directions", "methods_of"]

IMAGE_METRICS = ("psnr", "perceptual_error", "ssim")
"""What is reported of a rendered sphere, in the order of the page."""


@dataclass(frozen=True)
class SparseSettings:
    """Everything that a figure depends on, beside the populations and the code."""

    seed: int = 1
    samples: tuple[int, ...] = SAMPLES
    repeats: int = 3
    """Draws of directions for each material; figures are means over them."""
    held_out: tuple[str, ...] = HELD_OUT
    image_size: int = 64
    """Pixels across the sphere."""

    def __post_init__(self) -> None:
        if self.repeats < 1:
            raise UsageError(f"--repeats: found {self.repeats} but at least one draw is needed.")

    def record(self) -> dict[str, Any]:
        """Return the settings as JSON-able values."""
        return dataclasses.asdict(self)


def draw_directions(count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Return `count` pairs (wi, wo), (count, 3), uniform over the Rusinkiewicz angles.

    theta_h and theta_d uniform in [0, pi/2], phi_d in [0, pi), what lies below the horizon
    drawn again. The first pairs of a longer draw are those of a shorter one.
    """
    found: list[FloatArray] = []
    while sum(len(part) for part in found) < count:
        angles = rng.random((4096, 3)) * np.array([np.pi / 2, np.pi / 2, np.pi])
        cos_i, cos_o = cos_incident_outgoing(*angles.T)
        found.append(angles[(cos_i > 0.0) & (cos_o > 0.0)])
    return directions_from_half_diff(*np.concatenate(found)[:count].T)


def methods_of(learnt: Population, names: list[str] | None = None) -> dict[str, Method]:
    """Return methods with their default settings, leaning on `learnt` where they lean on any.

    None is every method there is. Raises `UsageError` for a name that is not among them.
    """
    from brdfit.reconstruct import METHODS

    unknown = sorted(set(names or ()) - set(METHODS))
    if unknown:
        raise UsageError(f"--methods: found {unknown[0]!r} but known are {', '.join(METHODS)}.")
    found: dict[str, Method] = {}
    for name, kind in METHODS.items():
        if names is None or name in names:
            leans = "population" in {field.name for field in dataclasses.fields(kind)}
            found[name] = kind(population=learnt) if leans else kind()
    return found


@dataclass(frozen=True, eq=False)
class Scene:
    """What the workers share: the references, the sphere, and the methods."""

    settings: SparseSettings
    references: Population
    """Holds the materials that are reconstructed."""
    methods: dict[str, Method]

    @cached_property
    def _sphere(self) -> Sphere:
        return Sphere(self.settings.image_size)

    def reference(self, material: str, wi: FloatArray, wo: FloatArray) -> FloatArray:
        """Return f_r (n, channels) of a held-out material: its first member."""
        values = self.references.subset([material]).evaluate(wi, wo)
        return values[:, 0].astype(np.float64)

    def measure(self, material: str, repeat: int) -> Samples:
        """Return the longest set of samples of a material; shorter ones are its beginnings."""
        rng = generator(self.settings.seed, "sparse", material, str(repeat))
        wi, wo = draw_directions(max(self.settings.samples), rng)
        return Samples(wi=wi, wo=wo, value=self.reference(material, wi, wo))

    def records(self, name: str, material: str) -> list[Record]:
        """Return the records of one method on one material."""
        expected = self._sphere.shade(_Member(self, material), studio())
        found = []
        for repeat in range(self.settings.repeats):
            samples = self.measure(material, repeat)
            for count in self.settings.samples:
                record: Record = {
                    "key": f"{name}|{material}|n{count:05d}|r{repeat}",
                    "method": name,
                    "material": material,
                    "samples": count,
                    "repeat": repeat,
                }
                few = samples.subset(np.arange(count))
                found.append(record | self._judged(self.methods[name], few, expected))
        return found

    def _judged(self, method: Method, samples: Samples, expected: FloatArray) -> Record:
        from brdfit.metrics import METRICS

        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", BrdfitWarning)
                result = method.fit(samples)
        except BrdfitError as error:
            refused = f"{type(error).__name__}: {error}"
            return {"how": refused} | dict.fromkeys(IMAGE_METRICS)
        image, mask = self._sphere.shade(result, studio()), self._sphere.mask
        figures: Record = {}
        for metric in IMAGE_METRICS:
            score = METRICS[metric](expected, image, mask)
            assert isinstance(score, float)
            figures[metric] = figure(score)
        return {"how": result.outcome.value} | figures


@dataclass(frozen=True, eq=False)
class _Member:
    """A held-out material as something that can be shaded."""

    scene: Scene
    material: str

    def evaluate(self, wi: FloatArray, wo: FloatArray) -> FloatArray:
        return self.scene.reference(self.material, wi, wo)

"""The MERL materials decoded into small neural networks (Sztrajman et al. 2021).

Each member of the published archive is a network of `brdfit.models.network`.

Reference: A. Sztrajman, G. Rainer, T. Ritschel, T. Weyrich, "Neural BRDF Representation and
Importance Sampling", Computer Graphics Forum 40(6), 2021. Archive: MIT licence.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from brdfit.arrays import FloatArray, IntArray
from brdfit.errors import CorruptFile, PopulationError
from brdfit.files import sha256_of_bytes
from brdfit.formats.network_file import archived_networks, read_layers, require_h5py
from brdfit.models.network import Networks
from brdfit.populations.contract import member_values

__all__ = ["NBRDF_SHA256", "DecodedNetworks", "read_nbrdf"]

NBRDF_SHA256 = "d1678c0cc5059f315d3d3284f36f3082787474106d72e3cae41fbad76d8f271a"
"""SHA-256 of the archive that its authors published."""

CHANNELS = ("R", "G", "B")

# Raise it when a change of the evaluation changes values.
_VERSION = 1


@dataclass(frozen=True, eq=False)
class DecodedNetworks:
    """A `MemberSource` over m networks, evaluated together."""

    name: str
    """What the user called it."""
    members: tuple[str, ...]
    """Material names, sorted."""
    fingerprint: str
    """SHA-256 of the archive and the version of its evaluation."""
    networks: Networks
    """Their weights, in the order of `members`."""
    notes: tuple[str, ...] = ()
    """What is unusual about the archive."""

    @property
    def materials(self) -> tuple[str, ...]:
        """A network is a material."""
        return self.members

    @property
    def channels(self) -> tuple[str, ...]:
        """R, G, B."""
        return CHANNELS

    @property
    def bilateral(self) -> bool:
        """No: phi_d and pi - phi_d are different inputs of a network."""
        return False

    def evaluate(self, wi: FloatArray, wo: FloatArray, pick: IntArray) -> FloatArray:
        """Return f_r (n, len(pick), 3), float32, at direction pairs (n, 3); 0 below the horizon."""
        return member_values(self.networks.evaluate(wi, wo, pick))


def read_nbrdf(path: str | os.PathLike[str], name: str | None = None) -> DecodedNetworks:
    """Return the networks of the archive at `path`.

    Raises `PopulationError` where the file is no such archive, naming the entry at fault,
    and `MissingExtra` without h5py. An archive with another hash than the published one is
    used, and says so in `notes`.
    """
    path = Path(path)
    require_h5py()
    again = "Fetch it with: brdfit basis fetch nbrdf"
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PopulationError(f"{path.name}: cannot be read ({error}). {again}") from error
    try:
        entries = archived_networks(content, path.name)
        networks = Networks.of([read_layers(entries[member], member) for member in entries])
    except CorruptFile as error:
        raise PopulationError(f"{error} {again}") from error
    sha256 = sha256_of_bytes(content)
    return DecodedNetworks(
        name=name or path.name,
        members=tuple(entries),
        fingerprint=sha256_of_bytes(f"nbrdf {_VERSION} {sha256}".encode()),
        networks=networks,
        notes=_notes(path.name, sha256),
    )


def _notes(name: str, sha256: str) -> tuple[str, ...]:
    if sha256 == NBRDF_SHA256:
        return ()
    return (
        f"{name}: SHA-256 is {sha256[:16]}... but the published archive has "
        f"{NBRDF_SHA256[:16]}...; it was altered, or is another edition",
    )

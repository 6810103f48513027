"""Names of modes, by looking at their shapes along the axis."""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.rotors.model import Complexes, Floats, LateralModel
from autobalancer.rotordynamics.question import Places
from autobalancer.rotordynamics.whirl import Whirl, whirl, whole_direction

BENT = (
    0.1  # part of the mean square deflection that a straight line misses, 0.19 for half a wave; above it the axis bends
)
ONE_PLANE = 0.6  # share of the kinetic energy along x or y above which a mode belongs to this direction


def mode_names(model: LateralModel, vectors: Complexes, axis: Places) -> list[str]:
    """Such as ``cylindrical y``, ``conical forward``, ``bending 1 backward``, ``axial, z of frame``.

    ``vectors`` (modes, N) by ascending frequency, of unit kinetic norm. Cylindrical and conical modes leave the axis
    nearly straight: without and with a node. Bending modes of one direction are counted.
    """
    names: list[str] = []
    counted: dict[str, int] = {}
    for vector in vectors:
        share_x, share_y, other = _shares(model, vector)
        if other > 0.5:
            names.append(_other(model, vector))
            continue
        ellipses = ellipses_of(model, vector, axis)
        kind = _kind(ellipses, axis.positions)
        where = whole_direction(ellipses)
        if not model.isotropic:
            where = "x" if share_x > ONE_PLANE else "y" if share_y > ONE_PLANE else where
        if kind == "bending":
            counted[where] = counted.get(where, 0) + 1
            kind = f"bending {counted[where]}"
        names.append(f"{kind} {where}")
    return names


def ellipses_of(model: LateralModel, vectors: Complexes, places: Places) -> Whirl:
    """The ellipses of motions (..., N) at places: (..., places)."""
    n = model.pairs
    rows = places.deflection.T
    return whirl(vectors[..., :n] @ rows, vectors[..., n : 2 * n] @ rows)


def _shares(model: LateralModel, vector: Complexes) -> tuple[float, float, float]:
    """Shares of the kinetic energy along x, y and the other coordinates."""
    n = model.pairs
    energy = (vector.conj() * (model.mass @ vector)).real
    return float(energy[:n].sum()), float(energy[n : 2 * n].sum()), float(energy[2 * n :].sum())


def _other(model: LateralModel, vector: Complexes) -> str:
    energy = (vector.conj() * (model.mass @ vector)).real
    energy[: 2 * model.pairs] = 0.0
    most = model.coordinates[int(np.argmax(energy))]
    kind = "axial" if most.startswith("z ") else "torsional" if most.startswith("turning") else ""
    return f"{kind}, {most}" if kind else most


def _kind(ellipses: Whirl, positions: Floats) -> str:
    """From the greater circle along the axis, turned into one plane as well as it goes."""
    circles = (ellipses.forward, ellipses.backward)
    line = max(circles, key=lambda circle: float((np.abs(circle) ** 2).sum()))
    plane = (line * np.exp(-0.5j * np.angle((line**2).sum()))).real
    if positions.size == 1:
        return "cylindrical"
    straight = np.polyval(np.polyfit(positions, plane, 1), positions)
    if ((plane - straight) ** 2).sum() > BENT * (plane**2).sum():
        return "bending"
    return "cylindrical" if straight[0] * straight[-1] > 0.0 else "conical"

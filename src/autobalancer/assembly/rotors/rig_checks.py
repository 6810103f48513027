"""Is every body of a rig held?"""

from __future__ import annotations

import numpy as np

from autobalancer.assembly.rotors.model import Floats, Matrix
from autobalancer.assembly.rotors.rig_bodies import Rig
from autobalancer.assembly.rotors.rig_joints import Strut
from autobalancer.machine.part import ImpossiblePart

FREE = 1e-10  # share of the stiffest motion, all springs alike, below which a motion counts as free
MOTIONS = (
    "move along x",
    "move along y",
    "move along the axis",
    "tilt towards x",
    "tilt towards y",
    "turn about the axis",
)


def unresisted(rig: Rig, parts: list[Strut], mass: Matrix) -> list[int]:
    """Coordinates along z, or turning angles, if nothing resists any of them and nothing is moved by them."""
    found: list[int] = []
    for kind in (2, 5):
        columns = [merged.columns[kind] for merged in rig.merged if merged.columns[kind] >= 0]
        others = [i for i in range(rig.size) if i not in columns]
        felt = any(np.abs(strut.row[columns]).max(initial=0.0) > 0.0 for strut in parts)
        if not felt and np.abs(mass[np.ix_(columns, others)]).max(initial=0.0) <= 1e-12 * np.abs(mass).max():
            found += columns
    return found


def refuse_free_motion(rig: Rig, parts: list[Strut], kept: list[int]) -> None:
    """Raise :class:`ImpossiblePart` if a motion of bodies stretches no spring; it names bodies and motion.

    All springs count alike, so that the answer depends on how a rig is joined only, not on how stiff.
    """
    springs = [strut.row for strut in parts if strut.stiffness.any()]
    rows = np.array(springs).reshape(-1, rig.size)
    tilts = [column for merged in rig.merged for column in merged.columns[3:] if column >= 0]
    reach = np.abs(rows[:, tilts]).max(initial=0.0) or 1.0
    scale = np.ones(rig.size)
    scale[tilts] = 1.0 / reach  # angles count as the displacements they make
    held = (rows * scale)[:, kept]
    values, vectors = np.linalg.eigh(held.T @ held)
    free = vectors[:, values <= FREE * max(values[-1], 1e-300)]
    if free.size == 0:
        return
    share = np.zeros(rig.size)
    share[kept] = np.sum(free**2, axis=1)
    worst = int(np.argmax(np.round(share, 9)))
    kind = next(m.columns.index(worst) for m in rig.merged if worst in m.columns)
    bodies = [m.label for m in rig.merged if _along(m.columns[kind], share) > 1e-6]
    text = f"{' and '.join(map(repr, bodies))} can {MOTIONS[kind]} freely; connect them to a supported body"
    raise ImpossiblePart("Machine", [(("rotor", "joints"), text)])


def _along(column: int, share: Floats) -> float:
    return float(share[column]) if column >= 0 else 0.0

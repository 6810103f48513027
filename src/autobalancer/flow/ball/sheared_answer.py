"""The drag of a ball in a sheared fluid as a labelled dataset that shows itself."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.flow.ball.channel import Channel
from autobalancer.flow.ball.mesh import Floats
from autobalancer.laws.liquid.sheared_drag import Sheared
from autobalancer.machine import Machine
from autobalancer.results.answers.answer import Answer
from autobalancer.results.provenance import provenance
from autobalancer.shown import Column

FACTORS = np.geomspace(1e-3, 1e3, 3001)  # of the rate of shear U/d that are tried
NEAR = 1e-2  # difference of a share from 1 below which no rate follows from it
LABELS = {
    "velocity": ("velocity of the ball along its walls", "m/s"),
    "share": ("drag over that with the viscosity at rest", "1"),
    "rate_factor": ("rate of shear over velocity and diameter that has this share", "1"),
    "reduced_share": ("share at one effective rate of shear", "1"),
    "error": ("reduced drag over that by finite elements, less 1", "1"),
    "first_order": ("mean of the law over the flow of constant viscosity", "1"),
    "reynolds": ("Reynolds number", "1"),
}


class ShearedDrag(Answer):
    """Drag over that at rest, and how far one rate of shear stands for it."""

    __slots__ = ()
    drawn_by = "sheared_drag"
    row_of, needed = "velocity", ("share", "rate_factor", "error")

    def facts(self) -> Sequence[tuple[str, str]]:
        """What a machine file takes, and how good it is."""
        a = self.attrs
        return [
            ("at_ball", f"{a['at_ball']:.3g}; the drag by it is wrong by at most {100.0 * a['greatest_error']:.2g} % here"),
            ("mesh", f"{a['elements']} elements, gap of {a['mesh_gap']:.3g} ball radii; one 1.5 times coarser differs by "
                     f"{100.0 * a['mesh_error']:.2g} %"),
        ]  # fmt: skip

    def columns(self, unit: str = "") -> list[Column]:
        """A row for each velocity."""
        return [
            Column("velocity", self["velocity"].values, "m/s", ".4g"),
            Column("drag over that at rest", self["share"].values, form=".4g"),
            Column("rate factor", self["rate_factor"].values, form=".3g"),
            Column("with at_ball", self["reduced_share"].values, form=".4g"),
            Column("error", 100.0 * self["error"].values, "%", ".2g"),
            Column("to first order", self["first_order"].values, form=".4g"),
            Column("Re", self["reynolds"].values, form=".3g"),
        ]

    def remarks(self) -> Sequence[str]:
        """What is left out."""
        return (str(self.attrs["leaves_out"]),)


def labelled(
    machine: Machine,
    channel: Channel,
    law: Sheared,
    arrays: tuple[Floats, Floats, Floats, Floats],
    gap: float,
    mesh_error: float,
    elements: int,
) -> ShearedDrag:
    """Label what was solved, and fit the factor; ``arrays`` are velocities, shares, first order and Reynolds numbers."""
    velocity, share, mean, reynolds = arrays
    rate = velocity / channel.ball_diameter
    table = law.share(FACTORS[:, None] * rate)  # (factor, velocity)
    worst = np.abs(table / share - 1.0).max(axis=1)
    if np.abs(share - 1.0).max() < NEAR:
        raise QuestionError(
            f"sheared_drag: at these velocities the drag is that at rest ({share[-1]:.4g} of it at {velocity[-1]:g} m/s); ask "
            "for faster ones"
        )
    best = int(worst.argmin())
    data = {
        "share": share,
        "rate_factor": np.array([_factor(table[:, i], share[i]) for i in range(share.size)]),
        "reduced_share": table[best],
        "error": table[best] / share - 1.0,
        "first_order": mean,
        "reynolds": reynolds,
    }
    found = xr.Dataset({key: ("velocity", values) for key, values in data.items()}, {"velocity": velocity})
    for key in found.variables:
        text, unit = LABELS[str(key)]
        found[key].attrs = {"long_name": text, "units": unit}
    found.attrs = {
        "title": f"Drag of a ball, sheared fluid: {machine.name}",
        **provenance(),
        "machine_name": machine.name,
        "at_ball": float(FACTORS[best]),
        "greatest_error": float(worst[best]),
        "mesh_gap": gap,
        "mesh_error": mesh_error,
        "elements": elements,
        "ball_diameter": channel.ball_diameter,
        "leaves_out": "no inertia of the fluid, no flow around the closed race, no film narrower than the gap of the mesh",
    }
    return ShearedDrag.of(found)


def _factor(shares: Floats, share: float) -> float:
    """Where a law over the factors has a share; nan where that is not certain."""
    ascending = shares if shares[-1] > shares[0] else shares[::-1]
    if abs(share - 1.0) < NEAR or not ascending[0] < share < ascending[-1] or (np.diff(ascending) < 0.0).any():
        return float("nan")
    factors = FACTORS if shares[-1] > shares[0] else FACTORS[::-1]
    return float(np.exp(np.interp(share, ascending, np.log(factors))))

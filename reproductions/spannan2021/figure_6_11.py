"""Figure 6.11: modes of the discoidal rig and their order, Campbell diagram, critical speed.

Stiffness of the bushings is identified from the two frequencies, heights are assumed, so order, shape and whirl of the
modes, and how they change with the speed, are what is compared. The source measured an 11 % higher speed of greatest
deflection in the run-up with nothing but the rotor's own unbalance (figure 6.10); its rubber stiffens with frequency and in
small motion, which the rig of the catalog leaves out because the tables are lost. Rows of *softening bushings* are of the rig
whose shear softens with the amplitude; its resonances are in figure_6_10.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.rotors import lateral_model
from autobalancer.files.examples import rig
from autobalancer.machine import Machine
from autobalancer.plots.style import save_picture
from autobalancer.rotordynamics.campbell import campbell, critical_speeds, modes
from autobalancer.rotordynamics.natural_modes import free_motions
from reproductions import Found, compared_all, said

HERTZ = 2.0 * math.pi
TOP = 1200.0 * math.pi / 30.0
BLOW = 0.2e-3  # m, of the bushings, half of a first swing of 0.4 mm; not printed
BUSHINGS = "rotor.joints[6]."
RUBBER = "the rubber of the rig is stiffer in so small a motion than one stiffness from 9.6 Hz"


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Frequencies, order and shapes at rest, whirl at 1200 rpm, critical speed."""
    machine = rig("discoidal_rig")
    rest, fast = (modes(machine, speed, balls=False, modes=7) for speed in (0.0, TOP))
    f = rest["frequency"].values / HERTZ
    critical = float(critical_speeds(machine, balls=False)["critical_speed"][1]) / HERTZ
    shear = shear_shares(machine)
    tilting = said("both modes across tilt about a node, the first beyond an end of the axis", nodes(rest))
    rows = [
        Found("fitted", "first mode at rest", "Hz", 9.6, f[0], 0.096),
        Found("fitted", "second mode at rest", "Hz", 25.2, f[2], 0.252),
        Found("fitted", "modes below 30 Hz, pairs counted once", "1", 4.0, np.unique(f[f < 30.0].round(6)).size, 0.0),
        Found("fitted", "two modes across, turning of the stator, axial motion, in this order (1 = true)", "1", 1.0,
              float(ordered(rest)), 0.0),
        tilting,
        said("shear predominates in the first mode, axial load in the second", shear[0] > 0.5 > shear[1]),
        said("backward whirl falls and forward whirl rises with the speed", whirls(rest, fast)),
        *on_softening_bushings(),
        Found("excluded model", "speed of the passage at t = 70 s, own unbalance, linear rubber", "Hz", 10.7, critical, 0.2,
              RUBBER, "6.10"),
    ]  # fmt: skip
    diagram = campbell(machine, np.linspace(0.0, TOP, 64), balls=False, modes=6)
    save_picture(ab.plot.campbell(diagram), out / "figure_6_11.png")
    save_picture(ab.plot.modes(rest, modes=6), out / "figure_6_11_modes.png")
    soft = campbell(rig("discoidal_rig_rubber"), np.linspace(0.0, TOP, 64), balls=False, modes=6)
    save_picture(ab.plot.campbell(soft), out / "figure_6_11_softening.png")
    return compared_all("Spannan 2021", "6.11", rows)


def on_softening_bushings() -> list[Found]:
    """The same of the rig whose shear softens, which was fitted to the first mode only; its picture is of small motions."""
    machine = rig("discoidal_rig_rubber")
    rest, fast = (modes(machine, speed, balls=False, modes=7, rubber_amplitude=BLOW) for speed in (0.0, TOP))
    f = rest["frequency"].values / HERTZ
    at = f"softening bushings at {1e3 * BLOW:g} mm"
    return [
        Found("fitted", f"second mode at rest, {at}", "Hz", 25.2, f[2], 0.252),
        Found(
            "fitted",
            f"modes below 30 Hz, pairs counted once, {at}",
            "1",
            4.0,
            np.unique(f[f < 30.0].round(3)).size,
            0.0,
        ),
        Found("fitted", f"two modes across, turning of the stator, axial motion, in this order, {at} (1 = true)", "1", 1.0,
              float(ordered(rest)), 0.0, "turning follows axial motion below 0.05 mm and precedes the second mode at 0.4 mm"),
        said(f"both modes across tilt about a node, the first beyond an end of the axis, {at}", nodes(rest)),
        said(f"backward whirl falls and forward whirl rises with the speed, {at}", whirls(rest, fast)),
    ]  # fmt: skip


def ordered(rest: xr.Dataset) -> bool:
    """Whether the six lowest modes at rest come as in the figure."""
    names = [str(name).split(",")[0].split()[0] for name in rest["name"].values[:6]]
    across = set(names[:4]) <= {"cylindrical", "conical"}
    return across and names[4:] == ["torsional", "axial"]


def nodes(rest: xr.Dataset) -> bool:
    """Whether both modes tilt about a node, that of the first beyond an end of the axis, that of the second on it."""
    found = []
    for mode in (0, 2):
        x, z = rest["x_real"].values[mode] + 1j * rest["x_imag"].values[mode], rest["place"].values
        line = (x * np.exp(-1j * np.angle(x[np.argmax(np.abs(x))]))).real
        slope, start = np.polyfit(z, line, 1)
        found.append((-start / slope - z[0]) / (z[-1] - z[0]))
    return not 0.0 < found[0] < 1.0 and 0.0 < found[1] < 1.0


def shear_shares(machine: Machine) -> tuple[float, float]:
    """Share of shear of the bushings in the elastic energy of the first two modes at rest."""
    model = lateral_model(machine)
    joint = machine.rotor.joints[5]
    half = with_value_at(machine, BUSHINGS + "shear_stiffness", 0.5 * float(joint.shear_stiffness))
    sheared = 2.0 * (model.stiffness[0] - lateral_model(half).stiffness[0])
    vectors = free_motions(model, 0.0).lowest(4).vector[[0, 2]]
    first, second = (float((v.conj() @ sheared @ v).real / (v.conj() @ model.stiffness[0] @ v).real) for v in vectors)
    return first, second


def whirls(rest: xr.Dataset, fast: xr.Dataset) -> bool:
    """Whether gyroscopic moments split both pairs in the right direction."""
    found = True
    for number in (0, 1):
        still = float(rest["frequency"][2 * number])
        near = fast.where(np.abs(fast["frequency"] / still - 1.0) < 0.3, drop=True)
        for way, sign in (("forward", 1.0), ("backward", -1.0)):
            same = near["frequency"].values[near["whirl"].values == way]
            found &= same.size == 1 and bool(sign * (same[0] - still) > 0.0)
    return found

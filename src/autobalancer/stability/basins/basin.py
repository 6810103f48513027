"""Which end state follows from which start: basins of attraction, as a map and in percent.

The rule by which an end is named stands in :mod:`autobalancer.stability.basins.end_states`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import xarray as xr

from autobalancer.assembly.bearings.hardening import has_hardening
from autobalancer.assembly.fluids import Lags
from autobalancer.assembly.forces.rows import has_forces
from autobalancer.assembly.rubber import has_rubber
from autobalancer.assembly.system import assemble
from autobalancer.assembly.terms import Theory, unknown
from autobalancer.assembly.torsion.links import without_links
from autobalancer.catalog.friction_table import NONE_GIVEN
from autobalancer.catalog.resolve import Ball
from autobalancer.files.machine_file import machine_text
from autobalancer.kernels.system import BALLS, Matrix
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.drive import PrescribedSpeed
from autobalancer.machine.profile import Constant, Ramp
from autobalancer.results.provenance import provenance
from autobalancer.results.shares import wilson_interval
from autobalancer.simulation.fluid_lag import diffusing_lags
from autobalancer.stability.basins.end_states import (
    PLANE_STATES,
    REST,
    STATES,
    End,
    Question,
    deflections,
    end_state,
    overlapping,
)
from autobalancer.stability.basins.residuals import residuals
from autobalancer.stability.basins.starts import START_ANGLE, axis_name, unit_of_axis
from autobalancer.stability.friction.held_values import RELEASED
from autobalancer.stability.host.damping import slowest_decay
from autobalancer.stability.host.planar import plane, refuse_forces
from autobalancer.stability.host.stations import Stations, of_plane, stations
from autobalancer.stability.states.questions import judged
from autobalancer.stability.states.stations import states_of
from autobalancer.stability.states.verdicts import growth

REVOLUTIONS = (400.0, 20000.0)  # least and most of a hold that is not given
WAY = 1e-4  # rad, by which a race center that should run true is off the axis by less than the rule allows


def question_of(
    machine: Machine, speed: float, hold: float | None, tolerance: float, seed: int, *, ramp: bool
) -> Question:
    """A machine without gravity across its axis made ready, for starts at the speed or with a ``ramp`` up to it."""
    refuse_forces(machine)
    st = of_plane(plane(machine)) if isinstance(machine.rotor, PlanarRotor) else stations(machine)
    lags = diffusing_lags(machine)
    profile = Ramp(start=0.0, end=speed, duration=1.0) if ramp else Constant(speed=speed)
    there = machine.model_copy(update={"drive": PrescribedSpeed(profile=profile)})
    assembly = assemble(without_links(there), seed=seed, contact=False, lags=lags)
    slowest = _slowest(st, speed)
    longest = hold or _long_enough(slowest, speed, lags if ramp else {})
    rubs = any(race.friction is not None for balancer in machine.balancers for race in balancer.races)
    earliest = _steady_after(st, speed, longest) if rubs else 0.0
    return Question(machine, assembly, st, speed, longest, tolerance, _rest(st, slowest, speed), earliest, rubs)


def why_unnamed(machine: Machine) -> str:
    """Why the ends of a machine at a speed have no names; empty if they have."""
    if machine.axis == "horizontal" and machine.gravity > 0.0:
        return "gravity acts across the axis"
    if has_rubber(machine):
        return "rubber softens with the amplitude, and the states that have names are those of small motions"
    if has_hardening(machine):
        return "bearings become stiffer with the deflection, and the states that have names are those of small motions"
    if has_forces(machine):
        return "forces act on the balls, which may hold them at other places"
    return ""


def _slowest(st: Stations, speed: float) -> float:
    """Decay rate of the slowest mode of all stable states, 1/s; infinite if none is stable."""
    rates = [-growth(judged(st, speed, state)[0], state.freedom) for state in states_of(st, speed)]
    return min([rate for rate in rates if rate > 0.0], default=math.inf)


def _long_enough(slowest: float, speed: float, lags: Lags) -> float:
    """Some decay times of the slowest mode, and of fluid that a run-up left behind."""
    turn = 2.0 * math.pi / speed
    slowest = min([slowest, *(float(lag.rates.min()) for lag in lags.values())])
    return min(max(REVOLUTIONS[0] * turn, 25.0 / slowest), REVOLUTIONS[1] * turn)


def _rest(st: Stations, slowest: float, speed: float) -> float:
    """Ball speed in the rotor below which balls count as at rest, rad/s.

    Of rotors with several coordinates the slowest modes of the balls decay so slowly that balls still have a way to go at 1e-5
    of the rotor speed: there they must be within :data:`WAY` of their places.
    """
    return REST * speed if st.model.pairs == 1 else min(REST * speed, WAY * slowest)


def released(axes: Iterable[str], acceleration: float | None, balls: Iterable[Ball]) -> str:
    """How the runs begin, in words."""
    axes = list(axes)
    if acceleration or "acceleration" in axes:
        return "after run-ups"
    if any(name.startswith("ball_speed") for name in axes) or any(ball.start_speed for ball in balls):
        return "released at this speed with speeds of their own (not a run-up)"
    return RELEASED if not axes else RELEASED.replace("random", "the given")


def _steady_after(st: Stations, speed: float, hold: float) -> float:
    """Time after which the rotor has forgotten its start but for a hundredth, s; at most half of the time there is.

    Balls that friction holds may be shaken loose until then.
    """
    slowest = slowest_decay(st, speed)
    return min(math.log(100.0) / slowest if slowest > 0.0 else math.inf, 0.5 * hold)


def ends_dataset(
    question: Question,
    axes: Mapping[str, Sequence[float]],
    shape: tuple[int, ...],
    starts: Matrix,
    ends: Matrix,
    seed: int,
    acceleration: float | None,
) -> xr.Dataset:
    """Names of the ends and what they leave; ``starts`` and ``ends`` have a row for each run, see :func:`end_state`."""
    machine, named = question.machine, [end_state(question, end) for end in ends]
    over = End("overlapping start", ("overlapping start",) * len(question.st.names))
    named = [over if bad else one for one, bad in zip(named, overlapping(question, starts), strict=True)]
    names = [name.replace("[", "_").rstrip("]") for name in axes]
    dims = tuple(names) if axes else ("run",)
    size = question.assembly.state.size
    n = question.st.moment.size
    states = np.array([STATES.index(one.state) for one in named])
    found = xr.Dataset()
    for name, (path, values) in zip(names, axes.items(), strict=True):
        unit, text = unit_of_axis(path), axis_name(path)
        found = found.assign_coords({name: (name, np.asarray(values, np.float64), {"long_name": text, "units": unit})})
    found["state"] = (dims, states.reshape(shape), {"long_name": "end state", "flag_meanings": list(STATES)})
    found["time"] = (dims, ends[:, size + 1].reshape(shape), {"long_name": "time until judged", "units": "s"})
    deflection = np.array([np.abs(deflections(question, end)).max(initial=0.0) for end in ends]).reshape(shape)
    angles = ends[:, BALLS : BALLS + n].reshape(*shape, n)
    found["final_ball_angle_in_rotor"] = ((*dims, "ball"), angles, {"long_name": "final ball angle", "units": "rad"})
    found = found.merge(residuals(question, dims, angles, states.reshape(shape), deflection))
    planes = np.array([[PLANE_STATES.index(name) for name in one.planes] for one in named])
    found["plane_state"] = (
        (*dims, "plane"),
        planes.reshape(*shape, -1),
        {"long_name": "end state of a plane", "flag_meanings": list(PLANE_STATES)},
    )
    possible = states[states != STATES.index("overlapping start")]
    counts = np.bincount(possible, minlength=len(STATES))
    low, high = wilson_interval(counts, max(possible.size, 1))
    found = found.assign_coords(end=("end", list(STATES)))
    found["share"] = ("end", counts / max(possible.size, 1), {"long_name": "share of the starts", "units": "1"})
    if not axes:
        found["share_low"] = ("end", low, {"long_name": "lower end of its 95 % interval", "units": "1"})
        found["share_high"] = ("end", high, {"long_name": "upper end of its 95 % interval", "units": "1"})
    found.attrs = {
        **provenance(),
        "title": f"Basins of {machine.name}",
        "machine": machine_text(machine),
        "machine_name": machine.name,
        "states": list(STATES),
        "plane_states": list(PLANE_STATES),
        "speed": question.speed,
        "hold": question.hold,
        "tolerance": question.tolerance,
        "seed": seed,
        "released": released(axes, acceleration, question.assembly.balls),
        "overlapping": states.size - possible.size,
        "ignores": ", ".join(unknown(machine, Theory.BASIN)),
        **({"flow_model": "modes"} if diffusing_lags(machine) else {}),
        **({} if question.rubs else {"friction_text": NONE_GIVEN}),
    }
    return found if axes else _with_starts(found, starts)


def _with_starts(found: xr.Dataset, starts: Matrix) -> xr.Dataset:
    """The random starts themselves, and the number of the one with the greatest deflection at its end."""
    n = found.sizes["ball"]
    found["start_ball_angle_in_rotor"] = (("run", "ball"), starts[:, BALLS : BALLS + n], START_ANGLE)
    worst = int(np.nan_to_num(found["final_deflection"].values).argmax())
    return found.assign_attrs(worst=worst, worst_by="final_deflection", acceleration=0.0)

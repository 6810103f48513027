"""One table of all pictures of answers: which function draws what, and the one function that draws any answer."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.machine_kinds import CHAMBERS, RACES, Kind, machine_kind, refuse_unknown
from autobalancer.public_names import function_of
from autobalancer.results.answers.answer import KIND
from autobalancer.results.run_argument import RunArgument, is_run, open_run, refusal, result

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Mark = Callable[[Any], bool]  # whether a thing is an answer of this kind


@dataclass(frozen=True)
class Picture:
    """A picture: the function that draws it, the public function whose answer it draws, and how such an answer is known."""

    home: str  # below ``plots``, imported when it draws
    of: str
    holds: Mark
    further: bool = False  # drawn only where it is asked for

    @property
    def draw(self) -> Callable[..., Figure]:
        """The function itself."""
        module, _, name = self.home.rpartition(".")
        draw: Callable[..., Figure] = getattr(import_module(f"autobalancer.plots.{module}"), name)
        return draw

    @property
    def options(self) -> list[str]:
        """Names of its options."""
        return list(signature(self.draw).parameters)[1:]


def _has(*names: str, dims: tuple[str, ...] = (), attrs: tuple[str, ...] = (), lacks: tuple[str, ...] = ()) -> Mark:
    """A dataset with these variables, dimensions and attributes, and without what it ``lacks``."""
    return lambda it: (
        isinstance(it, xr.Dataset)
        and all(name in it for name in names)
        and set(dims) <= set(it.dims)
        and set(attrs) <= set(it.attrs)
        and not any(name in it or name in it.dims or name in it.attrs for name in lacks)
    )


def _is_a(*kinds: str) -> Mark:
    return lambda it: type(it).__name__ in kinds


def _one_of(*names: str, of: Mark, ndim: int) -> Mark:
    """A dataset of a kind in which one of these variables has so many dimensions."""
    return lambda it: of(it) and any(name in it and it[name].ndim == ndim for name in names)


def _run(kind: Kind, *along: str) -> Mark:
    """A run of a kind of machine, with values along these dimensions."""
    return lambda it: (
        isinstance(it, xr.Dataset)
        and is_run(it)
        and machine_kind(it) is kind
        and all(it.sizes.get(name, 0) for name in along)
    )


_MAP_OF_ORDERS = _has("amplitude", "speed", lacks=("amplitude_deviation", "amplitude_change"))
_BORDERS = ("exact_border", "averaged_border", "release_speed", "capture_speed")
_STUDY, _ENSEMBLE = _has("draw", dims=("member",)), _has("outcome", dims=("member",))
_FLOW, _ORBITS = _has("fluid_speed", dims=("moment",)), _has("axis_x", dims=("rotor_angle",))
_RESPONSE = _has("mean_of_greatest", attrs=("quantity",))
_CHAMBER_STUDY = _has(dims=("layers", "balls"))
ANSWERS: dict[str, Picture] = {  # of one answer the first is the one that is drawn where nothing else is asked for
    "comparison": Picture("run.run_up.comparison", "compare", _has("deflection", "time_in_run")),
    "overlay": Picture("fits.overlay", "compare of a run and a measurement", _has("rms_away")),
    "basin": Picture("ensembles.basin", "basin", _has("state", attrs=("states",))),
    "study": Picture("studies.study", "study", _STUDY),
    "shares": Picture("ensembles.ensemble", "ensemble", _ENSEMBLE),
    "distribution": Picture("ensembles.ensemble_distribution", "ensemble or study", _ENSEMBLE),
    "scatter": Picture("ensembles.ensemble_scatter", "ensemble or study", _ENSEMBLE, further=True),
    "rest_positions": Picture("studies.rest_positions", "study", _has("draw", "ball_angle_to_unbalance")),
    "envelopes": Picture("studies.envelopes", "envelopes", _has("below_50")),
    "design": Picture("studies.design", "design", _has("place", "stage", "front")),
    "sensitivity": Picture("studies.sensitivity", "sensitivity", _has(dims=("input",), attrs=("quantity",))),
    "eigenvalues": Picture(
        "stability_map.eigenvalues", "stability.eigenvalues", _has("eigenvalue_real", dims=("speed",))
    ),
    "map": Picture("stability_map.map", "stability.map", _one_of("growth_rate", of=_has(), ndim=2)),
    "border_curve": Picture(
        "stability_map.border_curve",
        "stability.border_curve",
        _one_of(*_BORDERS, of=_has(attrs=("parameter",), lacks=("growth_rate",)), ndim=1),
    ),
    "branches": Picture("branches.branches", "stability.branches", _has("name", dims=("point",))),
    "bifurcation_curves": Picture(
        "stability_map.bifurcation_curves", "stability.bifurcation_curves", _has("second_parameter")
    ),
    "campbell": Picture("rotor.campbell", "rotor.campbell", _has("intersection_speed", dims=("branch",))),
    "modes": Picture("rotor.modes", "rotor.modes", _has("x_real", dims=("mode",))),
    "response": Picture("rotor.response", "rotor.response", _RESPONSE),
    "polar_response": Picture("rotor.polar_response", "rotor.response", _RESPONSE, further=True),
    "whirl_orbits": Picture("rotor.whirl_orbits", "rotor.whirl_orbits", _ORBITS),
    "whirl_along_axis": Picture("rotor.whirl_along_axis", "rotor.whirl_orbits", _ORBITS, further=True),
    "torsional_response": Picture(
        "rotor.torsional_response", "rotor.torsional_response", _has("link_torque", dims=("harmonic",))
    ),
    "liquid_response": Picture("rotor.liquid_response", "rotor.liquid_response", _has("without_liquid", "share")),
    "equivalent_planar": Picture("rotor.equivalent_planar", "rotor.equivalent_planar", _has("other_modes_share")),
    "identification": Picture("fits.identification", "rotor.identify", _has("deviation", "correlation")),
    "stepped_response": Picture("run.stepped_response.stepped_response", "stepped_response", _has("amplitude_change")),
    "flow": Picture("drag.flow", "flow.annulus_flow", _FLOW),
    "spin_up": Picture("drag.spin_up", "flow.annulus_flow", _FLOW, further=True),
    "velocity_profiles": Picture("drag.velocity_profiles", "flow.annulus_flow", _FLOW, further=True),
    "secondary_flow": Picture("drag.secondary_flow", "flow.annulus_flow", _FLOW, further=True),
    "ball_drag": Picture("drag.ball_drag", "flow.ball_drag", _has("cd_times_re", "velocity_x")),
    "equilibrium_angle": Picture("drag.equilibrium_angle", "measure.equilibrium_angle", _has("angle_with_pressure")),
    "measured_drag": Picture("drag.measured_drag", "measure.evaluate_angles", _has("measured_angle")),
    "receptance": Picture("fits.receptance", "measure.receptance", _has("fitted_real")),
    "nyquist": Picture("fits.nyquist", "measure.receptance_loop", _has("loop_real")),
    "rubber": Picture("fits.rubber", "measure.rubber", _is_a("RubberFit", "RubberLaw")),
    "balancing": Picture("balancing.balancing", "measure.balance", _has("influence", "correction")),
    "four_run": Picture("balancing.four_run", "measure.four_run", _has("sensitivity", "trial_mass")),
    "run_down": Picture("balancing.run_down", "measure.unbalance_from_run_down", _has("fitted", "unbalance")),
    "ball_film": Picture("balancing.ball_film", "measure.track_balls", _has("ball_angle", "seen")),
    "rectified_picture": Picture(
        "balancing.rectified_picture", "measure.rectified_picture", _has("brightness", "ball_x")
    ),
    "rest_histogram": Picture("balancing.rest_histogram", "measure.rest_histogram", _has("count", "angle")),
    "race_shape": Picture("balancing.race_shape", "measure.race_shape", _has("crest", "profile")),
    "rests": Picture("balancing.rests", "measure.rest_friction", _is_a("RestFriction")),
    "orders": Picture("signals.orders", "measure.orders", _has("amplitude_deviation")),
    "spectrum": Picture("signals.spectrum", "measure.spectrum", _has("line_frequency")),
    "order_map": Picture("signals.order_map", "measure.order_map", _MAP_OF_ORDERS),
    "damping": Picture("signals.damping", "measure.damping", _has("logarithmic_decrement", "fitted")),
    "measured_orbit": Picture("signals.measured_orbit", "measure.orbit", _has("filtered_x")),
    "amplitudes": Picture("chamber_runs.chamber_amplitudes", "chamber.amplitudes", _CHAMBER_STUDY),
    "carried": Picture("chamber_runs.chamber_carried", "chamber.amplitudes", _CHAMBER_STUDY),
    "means": Picture(
        "chamber_runs.chamber_optimal_means", "chamber.optimal_means", _has(dims=("layers",), lacks=("balls",))
    ),
    "step_size": Picture("chamber_runs.chamber_step_size", "chamber.step_size", _has(dims=("phase_number",))),
    "archive": Picture(
        "chamber_runs.chamber_archive", "chamber.Archive.runs", _has("state", dims=("run",), lacks=("states",))
    ),
}
RUNS: dict[str, Picture] = {
    "run_up": Picture("run.run_up.run_up", "simulate", _run(RACES)),
    "race": Picture("run.race_and_orbit.race", "simulate", _run(RACES)),
    "orbit": Picture("run.race_and_orbit.orbit", "simulate", _run(RACES)),
    "impacts": Picture(
        "run.run_up.impacts", "simulate, of balls that hit something", _run(RACES, "impact"), further=True
    ),
    "drive_train": Picture(
        "run.run_up.drive_train", "simulate, of a drive with couplings or a mount", _run(RACES, "link")
    ),
    "history": Picture("chamber_runs.chamber_run", "simulate", _run(CHAMBERS)),
    "energy": Picture("chamber_runs.chamber_energy", "simulate", _run(CHAMBERS)),
    "collisions": Picture("chamber_runs.chamber_collisions", "simulate", _run(CHAMBERS)),
    "bearings": Picture("chamber_runs.chamber_bearing_forces", "simulate", _run(CHAMBERS)),
    "reactions": Picture("chamber_runs.chamber_reactions", "simulate", _run(CHAMBERS)),
    "arrangement": Picture("chamber_view.chamber_arrangement", "simulate", _run(CHAMBERS)),
}
PICTURES = ANSWERS | RUNS
# kinds with another name than their function
OF_KIND = {"Swept": "sweep", "Measured": "run_measures", "Signals": "load_signals"}


def pictures_of(found: Any) -> dict[str, Picture]:
    """The pictures that there are of an answer or a run; the first is the one that it is known by.

    Raises
    ------
    QuestionError
        If there is none.
    """
    own = {name: one for name, one in ANSWERS.items() if one.holds(found)}
    there = own or {name: one for name, one in RUNS.items() if one.holds(found)}
    if not there and not isinstance(found, xr.Dataset):
        raise refusal(found, "plot.answer", "a result of this package; a machine is drawn by plot.machine")
    if not there:
        raise QuestionError("plot.answer: there is no picture of this result; show it, or draw its variables")
    return there


def made_by(found: xr.Dataset) -> str:
    """The public function that made an answer or a run, known by its kind or its picture; empty if neither says so."""
    kind = str(found.attrs.get(KIND, type(found).__name__))
    if kind not in OF_KIND and (of := next((one.of for one in PICTURES.values() if one.holds(found)), "")):
        return re.split(r"[ ,]", of)[0]
    return function_of(OF_KIND.get(kind, re.sub(r"(?<=[a-z])(?=[A-Z])", "_", kind).lower()))


def answer(found: Any, picture: str = "", **options: Any) -> Figure:
    """Draw any answer: what a study, a measurement, a stability question or a run found.

    Parameters
    ----------
    found
        What a function of this package returned, or the path of its file.
    picture
        Which one, where there are several, such as ``"distribution"``; the page *Pictures* lists them.
    options
        Those of the picture, such as ``speed_unit``.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    QuestionError
        If there is no such picture of it, or an option that this picture does not have; the message lists those that there are.
    """
    found = open_run(found) if isinstance(found, str | Path) else found
    there = pictures_of(found)
    name = picture.replace("-", "_") or next(iter(there))
    if name not in there:
        of = f", which is of a result of {PICTURES[name].of}" if name in PICTURES else ""
        raise QuestionError(f"plot.answer: picture: given {picture!r}{of}; of this result there are {', '.join(there)}")
    refuse_unknown("plot.answer", options, there[name].options, f"the picture {name!r}")
    return there[name].draw(found, **options)


def asked(argument: RunArgument, name: str) -> xr.Dataset:
    """The answer for a picture that has a public name, opened if ``argument`` is a path.

    Raises
    ------
    QuestionError
        If it is another answer than this picture draws.
    """
    known = PICTURES[name]
    return result(argument, f"plot.{name}", known.of, known.holds)

"""What a run of a deep chamber recorded and says of its machine, for the measures of ``measure_table.py``."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.thresholds import RUN_UP
from autobalancer.machine.chamber import Chamber, ChamberUnbalance
from autobalancer.machine.drive import AsynchronousMotor
from autobalancer.machine_kinds import CHAMBERS
from autobalancer.results.answers.answer import Answer, Labeled
from autobalancer.results.display_units import worded
from autobalancer.results.labels import labeled
from autobalancer.results.measure_table import CHAMBER_MEASURES, STAGES, Measure, measured, measures_of, single_names
from autobalancer.results.run_arrays import Settled, whirls_of
from autobalancer.results.time_series import compiled, end_of_run_up, of_a_run, origin_of, plain, time_since
from autobalancer.results.verdict import speed_changes
from autobalancer.units import optional_argument

# What a run says about its machine: sizes of the chambers, and the unbalance of the rotor.


@dataclass(frozen=True)
class ChamberShape:
    """A cylinder around the rotor's axis: radius and depth (m), place of its middle along the axis (m), inner radius (m)."""

    radius: float
    depth: float
    place: float = 0.0
    inner_radius: float = 0.0


def chambers_of(run: xr.Dataset) -> list[ChamberShape]:
    """The chambers in their order, as the machine of the run describes them.

    Without a description a chamber is taken as what its balls have reached, which is exact for the radius once a ball has
    been at the race.
    """
    described = _machine(run).get("chambers")
    if described:
        parts = [Chamber(**entry) for entry in _listed(described)]
        return [
            ChamberShape(float(part.radius), part.inner_depth, float(part.position), float(part.inner_radius))
            for part in parts
        ]
    place = run["ball_position"].transpose("time", "ball", "axis").values
    radius, number = run["ball_radius"].values, run["chamber"].values.astype(int)
    reach = np.hypot(place[:, :, 1], place[:, :, 2]).max(axis=0) + radius
    along = np.abs(place[:, :, 0]).max(axis=0) + radius
    chambers = []
    for chamber in range(1, int(number.max(initial=1)) + 1):
        mine = number == chamber
        chambers.append(ChamberShape(float(reach[mine].max(initial=1e-3)), 2.0 * float(along[mine].max(initial=1e-3))))
    return chambers


def unbalance_of(run: xr.Dataset) -> tuple[complex, complex] | None:
    """Static unbalance (kg m) and couple unbalance (kg m²) of the rotor, complex in the rotor; None if it is not described.

    Of the machine that ``run`` keeps; the couple counts from the plane x = 0.
    """
    machine = _machine(run)
    if "chambers" not in machine:
        return None
    static = couple = 0.0 + 0.0j
    for entry in _listed(machine.get("unbalances", [])):
        part = ChamberUnbalance(**entry)
        static, couple = static + part.vector, couple + part.position * part.vector
    return static, couple


def _machine(run: xr.Dataset) -> dict[str, Any]:
    try:
        return tomllib.loads(str(run.attrs.get("machine", "")))
    except tomllib.TOMLDecodeError:
        return {}


def _listed(entries: Any) -> list[dict[str, Any]]:
    return entries if isinstance(entries, list) else [entries]


def bodies_of(run: xr.Dataset) -> str:
    """What rolls in the chambers, as a word: "balls" or "cylinders"."""
    return "cylinders" if "ball_length" in run.variables else "balls"


# Where the balls of a deep chamber are in the rotor, what they balance there, and when they came to rest.


CARRIED = 0.5  # a ball that turns faster than this share of the rotor speed goes around with the rotor


def window(run: xr.Dataset, last: float | None = None) -> slice:
    """Samples of the last seconds of a run, by default its last tenth; that is what the measures call steady state.

    Raises
    ------
    QuestionError
        If the run has fewer than two samples there, or ``last`` is not positive.
    """
    if "time" not in run.variables:
        raise QuestionError("this result is no run of simulate_chamber; there is nothing to measure")
    time = run["time"].values
    if time.size < 2:
        raise QuestionError(f"the run has {time.size} samples; at least two are needed")
    length = 0.1 * float(time[-1] - time[0]) if last is None else float(last)
    if not 0.0 < length <= (time[-1] - time[0]) * (1.0 + 1e-9):
        raise QuestionError(
            f"last: given {length:g} s; must be above zero and within the {time[-1] - time[0]:g} s of the run"
        )
    start = int(np.searchsorted(time, time[-1] - length * (1.0 + 1e-9)))
    if time.size - start < 2:
        raise QuestionError(f"last: there are fewer than two samples in {length:g} s; take a longer time")
    return slice(start, time.size)


def ball_places_in_rotor(run: xr.Dataset) -> xr.DataArray:
    """Places of the balls in the turning rotor (m): (time, ball, axis), x along the axis, y towards the zero mark.

    The tilt of the body against space is taken off the rotor angle, which is counted in space.
    """
    turned = run["rotor_angle"].values - run["body_rotation"].isel(axis=0).values
    place = run["ball_position"].transpose("time", "ball", "axis").values
    wound = (place[:, :, 1] + 1j * place[:, :, 2]) * np.exp(-1j * turned)[:, None]
    inside = np.stack([place[:, :, 0], wound.real, wound.imag], axis=2)
    coords = {name: run[name] for name in ("time", "ball", "axis") if name in run.coords}
    attrs = {"long_name": "position of a ball from the center of its chamber", "units": "m", "frame": "rotor"}
    return xr.DataArray(inside, coords, ("time", "ball", "axis"), attrs=attrs)


def balls_carried(run: xr.Dataset, last: float | None = None) -> xr.DataArray:
    """Which balls go around with the rotor in steady state: mean turning of each faster than half of the rotor's."""
    part = run.isel(time=window(run, last))
    place = part["ball_position"].transpose("time", "ball", "axis").values
    around = place[:, :, 1] + 1j * place[:, :, 2]
    turn = np.angle(around[1:] * np.conj(around[:-1])).sum(axis=0)
    own = part["rotor_angle"].values
    if np.abs(np.diff(own)).max(initial=0.0) > 0.5 * np.pi:
        raise QuestionError(
            "samples: fewer than four per revolution of the rotor; save more, to see how the balls circulate"
        )
    share = turn / (own[-1] - own[0]) if own[-1] != own[0] else np.zeros_like(turn)
    return xr.DataArray(
        share > CARRIED, {"ball": run["ball"]}, ["ball"], attrs={"long_name": "goes around with the rotor"}
    )


def balls_with_rotor(run: xr.Dataset, last: float | None = None) -> NDArray[np.bool_]:
    """Which balls turn with the rotor in steady state, (n,): they go around with it, and make no turn in it.

    Only where all of them do is there a residual unbalance.
    """
    place = ball_places_in_rotor(run.isel(time=window(run, last))).values
    slip = np.ptp(np.unwrap(np.angle(place[:, :, 1] + 1j * place[:, :, 2]), axis=0), axis=0)
    return np.asarray(balls_carried(run, last).values & (slip < 2.0 * np.pi))


def ball_settling_time(run: xr.Dataset, tolerance: float = 1.0, last: float | None = None) -> xr.DataArray:
    """Time (s) in the run from which each ball stays within ``tolerance`` ball radii of its mean steady place in the rotor.

    nan for a ball that still leaves it in the steady state, such as one that stays at the bottom of the chamber.
    """
    if not tolerance > 0.0:
        raise QuestionError(f"tolerance: given {tolerance:g} ball radii; must be greater than zero")
    place = ball_places_in_rotor(run).values
    steady = window(run, last)
    away = np.linalg.norm(place - place[steady].mean(axis=0), axis=2) > tolerance * run["ball_radius"].values
    time = run["time"].values
    result = np.full(place.shape[1], np.nan)
    for i in range(place.shape[1]):
        late = np.flatnonzero(away[:, i])
        after = int(late[-1]) + 1 if late.size else 0
        if after <= steady.start:
            result[i] = time[after]
    return xr.DataArray(result, {"ball": run["ball"]}, ["ball"], attrs={"long_name": "settling time", "units": "s"})


def chamber_settling(run: xr.Dataset, tolerance: float = 1.0, last: float | None = None) -> Settled:
    """How long each ball takes to settle, by :func:`ball_settling_time`, from the end of the run-up as in all other runs."""
    at, time = ball_settling_time(run, tolerance, last).values, run["time"].values
    start = float(time[0])
    ended = end_of_run_up(time, run["speed"].values, start)
    begin, name = origin_of(ended, RUN_UP, start, float(time[-1]))
    if np.isfinite(held_below(run)):
        begin, name = np.nan, ""
    return Settled(time_since(begin, at), at, name, begin)


def held_below(run: xr.Dataset) -> float:
    """The critical speed (rad/s) past which its motor does not take the rotor of a run; nan if it does, or lacks torque there."""
    drive = _machine(run).get("drive", {})
    if drive.get("kind") != "asynchronous" or "critical_speeds" not in run.attrs:
        return np.nan
    held = float(compiled().held_at(plain(run["time"].values), plain(run["speed"].values), whirls_of(run)))
    return held if float(AsynchronousMotor(**drive).synchronous_speed) > held else np.nan


def balls_unbalance(run: xr.Dataset, chamber_places: Floats | None = None) -> xr.Dataset:
    """What the balls add to the unbalance of the rotor, static and dynamic, in the rotor.

    Parameters
    ----------
    run
        Samples of a chamber.
    chamber_places
        Places (m) of the chambers along the axis; by default those of the machine of the run.

    Returns
    -------
    xarray.Dataset
        Over ``time``: ``static``, the sum of m r (kg m), and ``couple``, the sum of m x r (kg m²), each with ``part``
        ``"y"`` and ``"z"`` in the rotor; x is counted from the plane of reference.
    """
    place = ball_places_in_rotor(run)
    mass = run["ball_mass"].values
    if chamber_places is None:
        chamber_places = np.array([chamber.place for chamber in chambers_of(run)])
    along = place.values[:, :, 0] + np.asarray(chamber_places, float)[np.asarray(run["chamber"].values, int) - 1]
    radial = place.values[:, :, 1:]
    static = np.einsum("b,tbp->tp", mass, radial)
    couple = np.einsum("b,tb,tbp->tp", mass, along, radial)
    over = ("time", "part")
    dataset = labeled(
        {
            "static": (over, static, "unbalance of the balls", "kg m", "rotor"),
            "couple": (over, couple, "couple unbalance of the balls", "kg m^2", "rotor"),
        }
    )
    return Labeled.of_run(run, "Unbalance of the balls", dataset.assign_coords(time=run["time"], part=["y", "z"]))


def residual_of_balls(
    run: xr.Dataset, unbalance: complex, couple: complex = 0.0, chamber_places: Floats | None = None
) -> xr.Dataset:
    """Size of what the balls of ``run`` leave of ``unbalance`` (kg m, complex in the rotor) and ``couple`` (kg m²), over time.

    ``chamber_places`` (chambers,) are the middles of the chambers along the axis, m; by default those of the run.

    Zero ``static`` is static balance, zero of both is dynamic balance. nan where a ball does not go around with the rotor.
    """
    own, place = balls_unbalance(run, chamber_places), ball_places_in_rotor(run).values
    # how far each ball slips in the revolution of the rotor around a sample
    slip = np.unwrap(np.angle(place[:, :, 1] + 1j * place[:, :, 2]), axis=0)
    turned = np.maximum.accumulate(np.abs(run["rotor_angle"].values - run["rotor_angle"].values[0]))
    begin = np.clip(turned - np.pi, 0.0, max(turned[-1] - 2.0 * np.pi, 0.0))
    first, end = (np.searchsorted(turned, at) for at in (begin, np.minimum(begin + 2.0 * np.pi, turned[-1])))
    around = (np.abs(slip[end] - slip[first]) < (1.0 - CARRIED) * (turned[end] - turned[first])[:, None]).all(axis=1)
    static, torque = (
        np.where(around, np.abs(own[name].values @ (1.0, 1j) + given), np.nan)
        for name, given in (("static", unbalance), ("couple", couple))
    )
    left = {
        "static": ("time", static, "residual unbalance", "kg m"),
        "couple": ("time", torque, "residual couple unbalance", "kg m^2"),
    }
    return Labeled.of_run(run, "Residual unbalance", labeled(left).assign_coords(time=run["time"]))


# What a run of a deep chamber recorded, as plain arrays: all that a measure is computed from.


DIRECTIONS = {"horizontal": ("body_position", 1), "vertical": ("body_position", 2), "rotation": ("body_rotation", 0)}

READ = (  # variables that measures read, some of them several times
    "speed", "rotor_angle", "body_position", "body_rotation", "ball_position", "bearing_force", "constraint_force",
    "constraint_moment", "contacts_ball", "contacts_wall", "impact_speeds", "impact_energies", "loss_contact",
    "greatest_contact_force", "work_motor", "energy_error", "tilting",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class ChamberRecorded:
    """A run, and what is asked of it: the length of the steady state (s), the tolerance of settling (ball radii).

    ``unbalance`` and ``couple`` are those of the rotor, complex in the rotor (kg m, kg m²), ``places`` those of the chambers (m).
    """

    run: xr.Dataset
    last: float | None = None
    tolerance: float = 1.0
    unbalance: complex | None = None
    couple: complex = 0.0
    places: Floats | None = None
    at_rest: bool = True  # whether there is a steady state: else what is measured there is nan
    _read: dict[str, Floats] = field(default_factory=dict)  # a run of an archive is read when it is used, and only once

    def values(self, variable: str) -> Floats:
        """A variable of the run over time first, (T, ...)."""
        if variable not in self._read:
            self._read[variable] = np.asarray(self.run[variable].transpose("time", ..., "axis").values, np.float64)
        return self._read[variable]

    @cached_property
    def steady(self) -> slice:
        """Samples of the steady state."""
        return window(self.run, self.last)

    @cached_property
    def time(self) -> Floats:
        """(T,) s."""
        return np.asarray(self.run["time"].values, np.float64)

    def moved(self, direction: str) -> Floats:
        """The body over the whole run, (T,) m or rad."""
        variable, axis = DIRECTIONS[direction]
        return np.asarray(self.values(variable)[:, axis])

    def synchronous(self, direction: str) -> float:
        """Amplitude of the part that turns with the rotor in steady state."""
        angle = self.run["rotor_angle"].values[self.steady]
        basis = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
        fit = np.linalg.lstsq(basis, self.moved(direction)[self.steady], rcond=None)[0]
        return float(np.hypot(fit[1], fit[2]))

    def away(self, direction: str) -> Floats:
        """Distance from the mean of the steady state over the whole run, (T,)."""
        values = self.moved(direction)
        return np.asarray(np.abs(values - values[self.steady].mean()))

    def when(self, values: Floats) -> float:
        """The time (s) of the greatest of ``values`` (T,)."""
        return float(self.time[np.argmax(values)])

    def radial_force(self, bearing: int) -> Floats:
        """Across the axis, of a bearing counted from 1, (T,) N."""
        force = self.values("bearing_force")[:, bearing - 1]
        return np.asarray(np.hypot(force[:, 1], force[:, 2]))

    def over_stages(self, amounts: Floats) -> Floats:
        """What came a second before and in steady state, of ``amounts`` since the last sample (T,); nan without time."""
        first, last = self.steady.start, self.time.size - 1
        spans = (0, max(first - 1, 0)), (max(first - 1, 0), last)
        totals = np.cumsum(amounts)
        with np.errstate(invalid="ignore", divide="ignore"):
            return self._known([(totals[b] - totals[a]) / (self.time[b] - self.time[a]) for a, b in spans])

    def _known(self, stages: list[float]) -> Floats:
        return np.array([stages[0], stages[1] if self.at_rest else np.nan])

    @property
    def cylinders(self) -> bool | None:
        """True if these run in the chambers, else ``None``."""
        return True if "tilting" in self.run else None

    def parts(self, values: Floats, measure: Callable[[Floats], Any]) -> Floats:
        """A measure of ``values`` (T,) before and in steady state; nan where there are none."""
        result = (values[: self.steady.start], values[self.steady])
        return self._known([float(measure(part)) if part.size else np.nan for part in result])

    @cached_property
    def impacts(self) -> Floats:
        """Contacts of balls begun since the last sample, (T,)."""
        return np.asarray(self.run["contacts_ball"].values + self.run["contacts_wall"].values, np.float64)

    def of_impact(self, sums: str) -> Floats:
        """The mean of a contact that began, before and in steady state; nan in runs that did not keep it, or without contacts."""
        if sums not in self.run:
            return np.full(2, np.nan)
        with np.errstate(invalid="ignore", divide="ignore"):
            return self.over_stages(self.run[sums].values) / self.over_stages(self.impacts)

    @cached_property
    def impact_loss(self) -> Floats:
        """Energy lost in impacts since the last sample, (T,) J."""
        lost = np.asarray(self.run["loss_contact"].values, np.float64)
        return np.diff(lost, prepend=lost[:1])

    @cached_property
    def contact_force(self) -> Floats:
        """Greatest force of a contact since the last sample, (T,) N."""
        return np.asarray(self.run["greatest_contact_force"].values, np.float64)

    @cached_property
    def settled(self) -> Settled:
        """How long each ball takes to settle, and from where that counts."""
        return chamber_settling(self.run, self.tolerance, self.last)

    @cached_property
    def carried(self) -> Any:
        """Which balls go around with the rotor."""
        return balls_carried(self.run, self.last).values

    @cached_property
    def left(self) -> xr.Dataset | None:
        """What the balls leave of the unbalance in steady state; ``None`` if it is not known."""
        if self.unbalance is None:
            return None
        left = residual_of_balls(self.run.isel(time=self.steady), self.unbalance, self.couple, self.places)
        return left.where(balls_with_rotor(self.run, self.last).all())

    @property
    def error_over_work(self) -> float:
        """Greatest error of the energy balance over the work of the motor; nan without work."""
        work = float(np.abs(self.run["work_motor"].values[-1]))
        return float(np.abs(self.run["energy_error"].values).max()) / work if work else float("nan")


TOTALS = ("contacts_ball", "contacts_wall", "hardest_contact", "hardest_contact_time")
UNITS = {name: measure.unit for measure in CHAMBER_MEASURES for name in single_names(measure)}
PARAMETERS = {"ball_mass_total": "kg", "ball_diameter": "m", "depth": "m", "duration": "s", "step": "s", "sample": "s"}


@of_a_run(runs=CHAMBERS)
def collision_statistics(run: xr.Dataset, bins: int = 50) -> xr.Dataset:
    """Contacts of a ``run`` between balls and with the chamber: totals, rates over time in ``bins`` parts, the hardest.

    Rates (1/s) count contacts that began in a part; ``impact_power`` (W) is what impacts dissipate in it, and
    ``greatest_force`` (N) the greatest force of a contact.
    """
    window(run)
    recorded, time = ChamberRecorded(run), run["time"].values
    edges = np.linspace(0, time.size, min(bins, time.size // 2) + 1).astype(int)
    starts, ends = edges[:-1], edges[1:]
    before = np.concatenate([[time[0]], time[ends[:-1] - 1]])
    span = time[ends - 1] - before
    amounts = {
        "contacts_ball_rate": (run["contacts_ball"].values, "rate of contacts between balls", "1/s"),
        "contacts_wall_rate": (run["contacts_wall"].values, "rate of contacts with the chamber", "1/s"),
        "impact_power": (recorded.impact_loss, "power that impacts dissipate", "W"),
    }
    parts = {name: ("part_time", np.add.reduceat(of, starts) / span, *about) for name, (of, *about) in amounts.items()}
    force = np.maximum.reduceat(recorded.contact_force, starts)
    parts["greatest_force"] = ("part_time", force, "greatest force of a contact", "N")
    over = {"part_time": ("part_time", 0.5 * (before + time[ends - 1]), "middle of the part", "s")}
    whole = [m for m in CHAMBER_MEASURES if m.name in TOTALS]
    return Labeled.of_run(run, "Contacts", labeled(parts, over).assign(measured(recorded, whole, _label)))


@of_a_run(runs=CHAMBERS)
def chamber_measures(
    run: xr.Dataset,
    *,
    unbalance: complex | None = None,
    couple: complex = 0.0,
    chamber_places: NDArray[np.float64] | None = None,
    last: float | str | None = None,
    tolerance: float = 1.0,
) -> Answer:
    """All measures of a run in one dataset, each with its unit and long name.

    A run whose speed still changes has no steady state, and nan for it unless ``last`` is given.

    Parameters
    ----------
    run
        From ``simulate_chamber``, or an archive.
    unbalance, couple
        Of the rotor, complex in the rotor (kg m, kg m²), for the residual unbalance; by default those of the machine.
    chamber_places
        Places of the chambers along the axis (m); by default those of the machine.
    last
        Seconds at the end that are the steady state; by default a tenth of the run.
    tolerance
        Of the settling time, in ball radii.

    Raises
    ------
    QuestionError
        If there are too few samples.
    """
    last = optional_argument("last", last, "s")
    if unbalance is None:
        unbalance, couple = unbalance_of(run) or (None, 0.0)
    time, bodies = run["time"].values, bodies_of(run)
    steady = last is not None or not speed_changes(time, run["speed"].values, float(time[-1]))
    recorded = ChamberRecorded(run, last, tolerance, unbalance, couple, chamber_places, steady)
    dataset = measures_of(run, recorded, CHAMBER_MEASURES, lambda measure: _label(measure, bodies))
    coords = {"stage": list(STAGES), "counted_from": recorded.settled.counted_from}
    return Answer.of(dataset.assign_coords(coords), "Measured")


def _label(measure: Measure, bodies: str = "balls") -> dict[str, str]:
    return {"units": measure.unit, "long_name": worded(measure.text, bodies)}


def catalog_numbers(run: xr.Dataset, last: float | None = None) -> dict[str, float]:
    """The measures of a ``run`` as single numbers for a catalog of runs; those of a stage get its name in front.

    Its last tenth, or ``last`` seconds, count as steady, even if the speed still changes.
    """
    recorded = ChamberRecorded(run, last, 1.0, *(unbalance_of(run) or (None, 0.0)))
    known = measured(recorded, CHAMBER_MEASURES, _label)
    return {
        name: value
        for measure in CHAMBER_MEASURES
        if measure.name in known
        for name, value in zip(single_names(measure), np.atleast_1d(known[measure.name][1]).tolist(), strict=True)
    }


def catalog_unit(name: str) -> str:
    """The unit of a number of :func:`catalog_numbers`, or of a parameter of a run; empty where it has none."""
    return {**PARAMETERS, **UNITS}.get(name, "")

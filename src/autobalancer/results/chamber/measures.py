"""Measures of a run of a deep chamber: the numbers by which chambers are compared."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.results.chamber.balls import Floats, ball_settling_time, balls_carried, residual_of_balls, window
from autobalancer.results.chamber.shape import unbalance_of
from autobalancer.results.of_a_run import of_a_run
from autobalancer.results.verdict.rule import speed_changes
from autobalancer.units import optional_argument

STEADY = "in steady state"  # ends the name of what is measured there
DIRECTIONS = {
    "horizontal": ("body_position", 1, "m"),
    "vertical": ("body_position", 2, "m"),
    "rotation": ("body_rotation", 0, "rad"),
}


@of_a_run(runs="simulate_chamber")
def steady_vibration(run: xr.Dataset, last: float | None = None) -> xr.Dataset:
    """Vibration amplitude in steady state: half of the range in the last seconds, and the part that turns with the rotor.

    ``<direction>_amplitude`` for horizontal and vertical (m) and for the rotation about the rotor's axis (rad), and
    ``<direction>_synchronous``, the amplitude of the harmonic of the rotor angle, which contacts disturb less.
    """
    part = run.isel(time=window(run, last))
    found = xr.Dataset()
    angle = part["rotor_angle"].values
    basis = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    for name, (variable, axis, unit) in DIRECTIONS.items():
        values = part[variable].isel(axis=axis).values
        fit = np.linalg.lstsq(basis, values, rcond=None)[0]
        found[f"{name}_amplitude"] = _scalar(0.5 * np.ptp(values), unit, f"{name} amplitude in steady state")
        found[f"{name}_synchronous"] = _scalar(
            float(np.hypot(fit[1], fit[2])), unit, f"{name} synchronous amplitude in steady state"
        )
    return found


@of_a_run(runs="simulate_chamber")
def transient_peak(run: xr.Dataset, last: float | None = None) -> xr.Dataset:
    """Greatest departure from the mean of the steady state over the whole run, and its time, in each direction."""
    steady = window(run, last)
    found = xr.Dataset()
    for name, (variable, axis, unit) in DIRECTIONS.items():
        values = run[variable].isel(axis=axis).values
        away = np.abs(values - values[steady].mean())
        place = int(np.argmax(away))
        found[f"{name}_peak"] = _scalar(away[place], unit, f"greatest {name} deflection in the transient")
        found[f"{name}_peak_time"] = _scalar(run["time"].values[place], "s", f"time of the greatest {name} deflection")
    return found


@of_a_run(runs="simulate_chamber")
def reaction_measures(run: xr.Dataset, last: float | None = None) -> xr.Dataset:
    """Greatest and root mean square reactions, in the ``stage`` ``"transient"`` and ``"steady"``.

    ``bearing_<n>`` is the radial force of a bearing (N), ``bearing_<n>_axial`` the axial one; ``constraint_x`` (N),
    ``constraint_moment_y`` and ``_z`` (N m) hold the body in planar motion. Each with ``_greatest``, ``_rms``, ``_mean``.
    """
    steady = window(run, last)
    stages = {"transient": slice(0, steady.start), "steady": steady}
    bearing = run["bearing_force"].transpose("time", "bearing", "axis").values
    histories: dict[str, tuple[Floats, str]] = {}
    for i in range(bearing.shape[1]):
        histories[f"bearing_{i + 1}"] = (np.hypot(bearing[:, i, 1], bearing[:, i, 2]), "N")
        histories[f"bearing_{i + 1}_axial"] = (bearing[:, i, 0], "N")
    histories["constraint_x"] = (run["constraint_force"].isel(axis=0).values, "N")
    histories["constraint_moment_y"] = (run["constraint_moment"].isel(axis=1).values, "N m")
    histories["constraint_moment_z"] = (run["constraint_moment"].isel(axis=2).values, "N m")
    found = xr.Dataset(coords={"stage": list(stages)})
    for name, (values, unit) in histories.items():
        parts = [values[part] for part in stages.values()]
        for kind, text, measure in (
            ("greatest", "greatest", _greatest),
            ("rms", "root mean square", _rms),
            ("mean", "mean", _mean),
        ):
            spoken = name.replace("_", " ")
            cells = [measure(part) if part.size else np.nan for part in parts]
            found[f"{name}_{kind}"] = ("stage", cells, {"units": unit, "long_name": f"{text} of {spoken}"})
    return found


def _greatest(values: Floats) -> float:
    return float(np.abs(values).max())


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _mean(values: Floats) -> float:
    return float(values.mean())


KINDS = (("greatest", "greatest", _greatest), ("rms", "root mean square", _rms), ("mean", "mean", _mean))


@of_a_run(runs="simulate_chamber")
def collision_statistics(run: xr.Dataset, bins: int = 50) -> xr.Dataset:
    """Contacts of a ``run`` between balls and with the chamber: totals, rates over time in ``bins`` parts, the hardest.

    Rates (1/s) count contacts that began in a part; ``greatest_force`` (N) is the greatest force of a contact in it.
    """
    window(run)
    time = run["time"].values
    edges = np.linspace(0, time.size, min(bins, time.size // 2) + 1).astype(int)
    starts, ends = edges[:-1], edges[1:]
    before = np.concatenate([[time[0]], time[ends[:-1] - 1]])
    span = time[ends - 1] - before
    found = xr.Dataset(coords={"part_time": ("part_time", 0.5 * (before + time[ends - 1]), {"units": "s"})})
    force = run["greatest_contact_force"].values
    for name, text in (("contacts_ball", "contacts between balls"), ("contacts_wall", "contacts with the chamber")):
        counts = run[name].values
        found[name] = _scalar(float(counts.sum()), "", text)
        rate = np.add.reduceat(counts, starts) / span
        found[f"{name}_rate"] = ("part_time", rate, {"units": "1/s", "long_name": f"rate of {text}"})
    found["greatest_force"] = ("part_time", np.maximum.reduceat(force, starts), {"units": "N"})
    found["greatest_force"].attrs["long_name"] = "greatest force of a contact"
    hardest = int(np.argmax(force))
    found["hardest_contact"] = _scalar(force[hardest], "N", "force of the hardest contact")
    found["hardest_contact_time"] = _scalar(time[hardest], "s", "time of the hardest contact")
    return found


@of_a_run(runs="simulate_chamber")
def chamber_measures(
    run: xr.Dataset,
    *,
    unbalance: complex | None = None,
    couple: complex = 0.0,
    chamber_places: NDArray[np.float64] | None = None,
    last: float | str | None = None,
    tolerance: float = 1.0,
) -> xr.Dataset:
    """All measures of a run in one dataset, each with its unit and long name.

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
    collisions = collision_statistics(run)
    settled, carried = ball_settling_time(run, tolerance, last), balls_carried(run, last)
    found = xr.merge(
        [
            steady_vibration(run, last),
            transient_peak(run, last),
            reaction_measures(run, last),
            collisions[["contacts_ball", "contacts_wall", "hardest_contact", "hardest_contact_time"]],
        ]
    )
    slowest = float(settled.values.max()) if settled.size else np.nan
    found["settling_time"] = _scalar(slowest, "s", "settling time of the last ball")
    found["share_carried"] = _scalar(float(carried.mean()), "1", "share of the balls that go around with the rotor")
    described = unbalance_of(run)
    if unbalance is None and described is not None:
        unbalance, couple = described
    if unbalance is not None:
        left = residual_of_balls(run.isel(time=window(run, last)), unbalance, couple, chamber_places)
        found["residual_unbalance"] = _scalar(
            float(left["static"].mean()), "kg m", "residual unbalance in steady state"
        )
        found["residual_couple"] = _scalar(
            float(left["couple"].mean()), "kg m^2", "residual couple unbalance in steady state"
        )
    exchanged = float(np.abs(run["work_motor"].values[-1]))
    error = float(np.abs(run["energy_error"].values).max())
    share = error / exchanged if exchanged else np.nan
    found["energy_error"] = _scalar(share, "1", "greatest error of the energy balance over the work of the motor")
    found.attrs = {
        key: run.attrs[key] for key in ("machine_name", "outcome", "outcome_text", "source") if key in run.attrs
    }
    return found


def without_steady_state(run: xr.Dataset, measured: xr.Dataset) -> xr.Dataset:
    """The measures of a ``run`` with nan for what is measured in steady state or counts from it, if its speed still changes."""
    time = run["time"].values
    if not speed_changes(time, run["speed"].values, float(time[-1])):
        return measured
    peaks = {f"{direction}_{what}" for direction in DIRECTIONS for what in ("peak", "peak_time")}
    found = {}
    for name, value in measured.data_vars.items():
        if "stage" in value.dims:
            found[name] = value.where(value["stage"] != "steady")
        elif name in peaks or STEADY in value.attrs.get("long_name", ""):
            found[name] = value.where(False)
    return measured.assign(found)


def catalogue_measures(measured: xr.Dataset) -> dict[str, float]:
    """The measures as single numbers for a catalogue; those of a stage get its name in front."""
    found: dict[str, float] = {}
    for name, value in measured.data_vars.items():
        if value.ndim == 0:
            found[str(name)] = float(value)
        elif value.dims == ("stage",):
            for stage in value["stage"].values:
                found[f"{stage}_{name}"] = float(value.sel(stage=stage))
    return found


_UNITS = {
    "residual_unbalance": "kg m",
    "residual_couple": "kg m^2",
    "ball_mass_total": "kg",
    "ball_diameter": "m",
    "depth": "m",
}


def catalogue_unit(name: str) -> str:
    """The unit of a measure of :func:`catalogue_measures`, or of a parameter; empty where it has none."""
    if "constraint_moment" in name:
        return "N m"
    if any(word in name for word in ("bearing_", "constraint_", "hardest_contact")) and not name.endswith("_time"):
        return "N"
    if name.endswith(("_time", "duration", "step")):
        return "s"
    for direction, (_, _, unit) in DIRECTIONS.items():
        if name in (f"{direction}_amplitude", f"{direction}_synchronous", f"{direction}_peak"):
            return unit
    return _UNITS.get(name, "")


def _scalar(value: float, unit: str, text: str) -> xr.DataArray:
    return xr.DataArray(float(value), attrs={"units": unit, "long_name": text})

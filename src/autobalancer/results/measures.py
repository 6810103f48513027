"""Measures of a run: the few numbers by which run-ups are compared."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.results.jumps import jump_times, parts_between_jumps
from autobalancer.results.of_a_run import of_a_run
from autobalancer.results.places import residual_unbalance, support_forces, vibration
from autobalancer.results.series import (
    counted,
    end_of_run_up,
    release_rows,
    released_at,
    settled_from,
    wrapped,
)
from autobalancer.results.standing import standing_in
from autobalancer.units import optional_argument


@of_a_run()
def deflection_envelope(run: xr.Dataset, bins: int = 200) -> xr.Dataset:
    """Least and greatest deflection over time.

    Taken from the envelope that the run kept (exact), else from its samples (with their resolution), in ``bins`` parts.

    Returns
    -------
    xarray.Dataset
        ``low`` and ``high`` (m) over ``time`` (s), and ``speed`` (rad/s).

    Raises
    ------
    QuestionError
        If the run kept neither.
    """
    if "envelope_high" in run:
        time, low, high, speed = _series(run, *(f"envelope_{name}" for name in ("time", "low", "high", "speed")))
    else:
        t, r, w = _series(run, "time", "deflection", "speed")
        edges = np.linspace(0, t.size, min(bins, t.size) + 1).astype(int)
        pairs = [(a, b) for a, b in pairwise(edges) if b > a]
        low = np.array([r[a:b].min() for a, b in pairs])
        high = np.array([r[a:b].max() for a, b in pairs])
        time = np.array([0.5 * (t[a] + t[b - 1]) for a, b in pairs])
        speed = np.array([w[b - 1] for _, b in pairs])
    envelope = xr.Dataset({"low": ("time", low), "high": ("time", high), "speed": ("time", speed)}, {"time": time})
    for name, text, unit in (
        ("low", "least deflection", "m"),
        ("high", "greatest deflection", "m"),
        ("speed", "rotor speed", "rad/s"),
        ("time", "time", "s"),
    ):
        envelope[name].attrs.update(long_name=text, units=unit)
    return envelope


@of_a_run()
def peak_deflection(run: xr.Dataset) -> xr.Dataset:
    """Greatest deflection of the run (m), with the ``time`` (s) and ``speed`` (rad/s) at which it occurs.

    In a run through a critical speed this is the peak at resonance.
    """
    envelope = deflection_envelope(run)
    place = int(np.argmax(envelope["high"].values))
    peak = envelope.isel(time=place)
    return _scalars(
        deflection=(float(peak["high"]), "m", "greatest deflection"),
        time=(float(peak["time"]), "s", "time of the greatest deflection"),
        speed=(float(peak["speed"]), "rad/s", "rotor speed at the greatest deflection"),
    )


@of_a_run()
def residual_vibration(run: xr.Dataset, last: float | str | None = None) -> float:
    """Greatest vibration (m) at the reference station at the end of the run, without static deflection.

    On a vertical axis, which has no static deflection, it is the greatest deflection over the ``last`` seconds, by
    default over the last twentieth of the run. On a horizontal one it is the greatest distance from the mean position,
    over the last revolutions that the run kept; over the samples of the ``last`` seconds if that is given or there are
    none.

    Raises
    ------
    QuestionError
        If the run kept no data for it.
    """
    last = optional_argument("last", last, "s")
    if "end_time" not in run.attrs:
        raise QuestionError("residual_vibration: this result is no run of simulate; there is nothing to measure")
    end = float(run.attrs["end_time"])
    if last is not None and not last > 0.0:
        raise QuestionError(f"last: given {last:g} s; must be greater than zero")
    begin = end - (0.05 * end if last is None else last)
    if run.attrs.get("axis", "vertical") == "vertical":
        envelope = deflection_envelope(run)
        inside = envelope["time"].values >= begin
        inside[-1] = True
        return float(envelope["high"].values[inside].max())
    if last is None and run.sizes.get("turn", 0) > 1:
        return float(vibration(run)["greatest"].values[0])
    if "x" not in run:
        raise QuestionError(
            "the axis is horizontal, so the envelope holds static deflection and vibration together; "
            "run it with save=[..., LastRevolutions()]"
        )
    time, x, y = _series(run, "time", "x", "y")
    z = (x + 1j * y)[time >= begin]
    if z.size == 0:
        raise QuestionError(f"the run kept no sample of its last {end - begin:.3g} s; there is nothing to measure")
    late = run.isel(time=time >= begin)
    return float(np.abs(z - standing_in(late, z[:, None], "")).max())


@of_a_run()
def settling_time(run: xr.Dataset, tolerance: float = np.deg2rad(2.0)) -> xr.DataArray:
    """Time (s) that each ball takes to stay within ``tolerance`` (rad) of its final angle in the rotor.

    It counts from the ball's release, from a jump of the unbalance, from the end of the run-up or from the start of the run,
    whichever is the last one before the ball has settled; the coordinate ``counted_from`` says which, ``settled_at`` (s) is
    the time in the run. The run-up ends where the speed stays within 0.1 % of its last value. nan for a ball that still moves at
    the end (faster than 1/1000 of the rotor speed).
    """
    time, angle, speed, rotor = _balls(run)
    settled = settled_from(time, angle, rotor, tolerance)
    rows = release_rows(rotor, speed + rotor[:, None], _critical(run))
    released = np.interp(rows, np.arange(time.size), time)
    duration, names = counted(settled, released, end_of_run_up(time, rotor), float(time[0]), jump_times(run))
    found = _per_ball(run, duration, "settling time", "s")
    return found.assign_coords(settled_at=("ball", settled), counted_from=("ball", names))


@of_a_run(of_machine="ab.stability.borders(machine)")
def release_speed(run: xr.Dataset, critical_speed: float | str | None = None) -> xr.DataArray:
    """Rotor speed (rad/s) at which each ball that stalled at the critical speed breaks away.

    nan for a ball that did not stall, or did not break away. A ball counts as stalled while its speed in space is three
    times nearer to the critical speed than to the rotor speed, at least 2 % above the critical speed; it is released where
    it passes the critical speed for the last time. This measures a run; the formula is Spannan 2021, (4.73).
    ``critical_speed`` is by default the lowest of the machine.
    """
    critical_speed = optional_argument("critical_speed", critical_speed, "rad/s")
    _, _, speed, rotor = _balls(run)
    critical_speed = _critical(run) if critical_speed is None else critical_speed
    return _per_ball(
        run, released_at(rotor, speed + rotor[:, None], critical_speed), "break-away speed in the run", "rad/s"
    )


@of_a_run()
def ball_angle_to_unbalance(run: xr.Dataset) -> xr.DataArray:
    """Angle (rad, within -pi to pi) of each ball from the direction of the unbalance, over time and ball of ``run``.

    Balls on the light side are near pi, balls on the heavy side near 0.
    """
    if "ball_angle_in_rotor" not in run:
        raise QuestionError("the run kept no samples over time; run it with save=Samples()")
    angle = run["ball_angle_in_rotor"] - run["unbalance_angle_in_rotor"]
    result = xr.apply_ufunc(wrapped, angle)
    result.attrs.update(long_name="ball angle from the unbalance", units="rad", frame="rotor")
    return xr.DataArray(result.rename("ball_angle_to_unbalance"))


@of_a_run()
def measures(run: xr.Dataset) -> xr.Dataset:
    """All measures of a run in one dataset; each has its unit and its long name, which says where it is measured.

    Those over ``place``, ``plane`` and ``support`` are present if the run kept its last revolutions.
    """
    peak = peak_deflection(run)
    where = f"at {run.attrs.get('reference_station', 'the rotor')!r}"
    found = _scalars(
        peak_deflection=(float(peak["deflection"]), "m", f"greatest deflection {where}"),
        peak_speed=(float(peak["speed"]), "rad/s", f"rotor speed at the greatest deflection {where}"),
        residual_vibration=(residual_vibration(run), "m", f"vibration at the end of the run {where}"),
    )
    found = found.assign(_of_places(run)) if run.sizes.get("turn", 0) > 1 else found
    if run.sizes.get("ball", 0):
        found["settling_time"] = settling_time(run)
        found["release_speed"] = release_speed(run)
        if "ball_angle_in_rotor" in run:
            final = ball_angle_to_unbalance(run).isel(time=-1, drop=True)
            final.attrs["long_name"] = "final ball angle from the unbalance"
            found["final_ball_angle_to_unbalance"] = final.drop_vars([n for n in final.coords if n != "ball"])
    found = found.assign(_after_jumps(run)) if jump_times(run) else found
    found.attrs = {
        key: run.attrs[key] for key in ("machine_name", "outcome", "outcome_text", "source") if key in run.attrs
    }
    return found


def _after_jumps(run: xr.Dataset) -> xr.Dataset:
    """Over the jumps of the unbalance: greatest deflection until the next one, and when the last ball settles."""
    parts = [(begin, part) for begin, _, part in parts_between_jumps(run) if begin > 0.0]
    found = xr.Dataset(coords={"jump_time": ("jump", [begin for begin, _ in parts])})
    found["jump_time"].attrs.update(units="s", long_name="time of a jump of the unbalance")
    peaks = [float(peak_deflection(part)["deflection"]) for _, part in parts]
    found["peak_after_jump"] = ("jump", peaks, {"units": "m", "long_name": "greatest deflection after a jump"})
    if run.sizes.get("ball", 0):
        last = [float(settling_time(part).max(skipna=False)) for _, part in parts]
        found["settling_after_jump"] = (
            "jump",
            last,
            {"units": "s", "long_name": "settling time after a jump, last ball"},
        )
    return found


def _of_places(run: xr.Dataset) -> xr.Dataset:
    """Vibration over the places, residual unbalance over the planes, forces over the supports."""
    moved = vibration(run)[["static", "greatest", "rms", "velocity_rms"]]
    found = moved.rename(static="static_deflection", greatest="vibration", rms="vibration_rms")
    if "plane" in run.coords:
        left = residual_unbalance(run)[["unbalance", "residual", "share"]]
        found = found.merge(left.rename(residual="residual_unbalance", share="residual_share"))
    if run.sizes["support"]:
        force = support_forces(run)[["static", "greatest", "rms"]]
        found = found.merge(force.rename(static="static_force", greatest="vibrating_force", rms="vibrating_force_rms"))
    return found


def _critical(run: xr.Dataset) -> float:
    """The lowest critical speed of the machine, rad/s; nan if it has none."""
    return float(np.min(run.attrs["critical_speeds"])) if np.size(run.attrs["critical_speeds"]) else np.nan


def _scalars(**values: tuple[float, str, str]) -> xr.Dataset:
    found = xr.Dataset({name: ((), value) for name, (value, _, _) in values.items()})
    for name, (_, unit, text) in values.items():
        found[name].attrs.update(units=unit, long_name=text)
    return found


def _series(run: xr.Dataset, *names: str) -> list[np.ndarray]:
    if any(name not in run.variables for name in names):
        raise QuestionError(
            "the run kept neither samples over time nor an envelope; run it with save=Samples() or Envelope()"
        )
    if run[names[0]].size == 0:
        raise QuestionError("the run ended before its first sample; there is nothing to measure")
    return [run[name].values for name in names]


def _balls(run: xr.Dataset) -> list[np.ndarray]:
    """Time, ball angles and speeds in the rotor, rotor speed: from samples or from the ends of the envelope's bins."""
    if not run.sizes.get("ball", 0):
        raise QuestionError("the machine has no balls; there is nothing to measure on them")
    if "ball_angle_in_rotor" in run:
        return _series(run, "time", "ball_angle_in_rotor", "ball_speed_in_rotor", "speed")
    return _series(
        run, "envelope_time", "envelope_ball_angle_in_rotor", "envelope_ball_speed_in_rotor", "envelope_speed"
    )


def _per_ball(run: xr.Dataset, values: np.ndarray, text: str, unit: str) -> xr.DataArray:
    return xr.DataArray(values, {"ball": run["ball"].values}, ["ball"], attrs={"long_name": text, "units": unit})

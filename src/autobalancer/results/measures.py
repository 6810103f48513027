"""Measures of a run: the few numbers by which run-ups are compared."""

from __future__ import annotations

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.kernels.measures.columns_of_measures import LAST, SETTLED
from autobalancer.results.answers.answer import SOURCE, Labeled
from autobalancer.results.answers.measured import Measured
from autobalancer.results.measure_table import HERE, MEASURES, Measure, label_of, measured
from autobalancer.results.places import of_a_run, vibration
from autobalancer.results.recorded import SETTLING_FROM, known_origin, settling
from autobalancer.results.run_arrays import (
    away_from_standing,
    bins_of,
    critical_speed_of,
    jump_times,
    known_balls,
    parts_between_jumps,
    recorded_of,
    series,
)
from autobalancer.results.series import NONE, greatest_at, last_deflection, load_of, release_rows, values_at, wrapped
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
    found = bins_of(run, bins)
    envelope = xr.Dataset(
        {"low": ("time", found.low), "high": ("time", found.high), "speed": ("time", found.speed)}, {"time": found.time}
    )
    for name, text, unit in (
        ("low", "least deflection", "m"),
        ("high", "greatest deflection", "m"),
        ("speed", "rotor speed", "rad/s"),
        ("time", "time", "s"),
    ):
        envelope[name].attrs.update(long_name=text, units=unit)
    return Labeled.of_run(run, "Envelope of the deflection", envelope)


@of_a_run()
def peak_deflection(run: xr.Dataset) -> xr.Dataset:
    """Greatest deflection of the run (m), with the ``time`` (s) and ``speed`` (rad/s) at which it occurs.

    In a run through a critical speed this is the peak at resonance.
    """
    bins = bins_of(run)
    place = greatest_at(bins.high)
    found = xr.Dataset()
    for name, values, unit, text in (
        ("deflection", bins.high, "m", "greatest deflection"),
        ("time", bins.time, "s", "time of the greatest deflection"),
        ("speed", bins.speed, "rad/s", "rotor speed at the greatest deflection"),
    ):
        found[name] = ((), float(values[place]), {"units": unit, "long_name": text})
    return Labeled.of_run(run, "Greatest deflection", found)


@of_a_run()
def residual_vibration(run: xr.Dataset, last: float | str | None = None) -> float:
    """Greatest vibration (m) at the reference station at the end of the run, without static deflection.

    On a vertical axis, which has no static deflection without a recorded excitation, it is the greatest deflection over the
    ``last`` seconds, by default over the last twentieth of the run. Else it is the greatest distance from the mean position,
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
    begin = end - (LAST * end if last is None else last)
    if load_of(run.attrs) == NONE:
        bins = bins_of(run)
        return last_deflection(bins.time, bins.high, begin)
    if last is None and run.sizes.get("turn", 0) > 1:
        return float(vibration(run)["greatest"].values[0])
    if "x" not in run:
        raise QuestionError(
            "the rotor has a static load, its weight or a recorded excitation, so the envelope holds static deflection and "
            "vibration together; run it with save=[..., LastRevolutions()]"
        )
    late = run.isel(time=series(run, "time")[0] >= begin)
    if not late.sizes["time"]:
        raise QuestionError(f"the run kept no sample of its last {end - begin:.3g} s; there is nothing to measure")
    return float(away_from_standing(late).max())


@of_a_run()
def settling_time(run: xr.Dataset, tolerance: float = SETTLED, settling_from: str = SETTLING_FROM[0]) -> xr.DataArray:
    """Time (s) that each ball takes to stay within ``tolerance`` (rad) of the angle in the rotor to which it goes.

    It counts from one moment for all balls, zero for a ball that has settled before: from the end of the run-up, where the speed
    comes to stay within 0.1 % of its last value, or with ``settling_from="release"`` from the last release of a stalled ball, if
    one stalls; in any case from a jump of the unbalance that is later. The coordinate ``counted_from`` says which it is,
    ``settled_at`` (s) is the time in the run. Between samples angles are interpolated.

    nan for a ball that has not settled: it has been near its last angle for less than a twentieth of the run, or the way that is
    still to come, extrapolated from its motion there as an exponential approach, is longer than the tolerance.

    Raises
    ------
    QuestionError
        If the machine has no balls, the run kept nothing of them, or ``settling_from`` is another word.
    """
    found = settling(known_balls(run), critical_speed_of(run), jump_times(run), known_origin(settling_from), tolerance)
    return _per_ball(run, found.duration, "settling time", "s").assign_coords(
        settled_at=("ball", found.at), counted_from=found.counted_from
    )


@of_a_run(of_machine="ab.stability.borders(machine)")
def release_speed(run: xr.Dataset, critical_speed: float | str | None = None) -> xr.DataArray:
    """Rotor speed (rad/s) at which each ball that stalled at the critical speed breaks away.

    nan for a ball that did not stall, or did not break away. A ball counts as stalled while its speed in space is three
    times nearer to the critical speed than to the rotor speed, at least 2 % above the critical speed; it is released where
    it passes the critical speed for the last time. This measures a run; the formula is Spannan 2021, (4.73).
    ``critical_speed`` is by default the lowest of the machine.
    """
    critical_speed = optional_argument("critical_speed", critical_speed, "rad/s")
    balls = known_balls(run)
    critical_speed = critical_speed_of(run) if critical_speed is None else critical_speed
    released = values_at(release_rows(balls.speed, balls.rate, critical_speed), balls.speed)
    return _per_ball(run, released, "break-away speed in the run", "rad/s")


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
def measures(run: xr.Dataset, settling_from: str = SETTLING_FROM[0]) -> Measured:
    """All measures of a run in one dataset; each has its unit and its long name, which says where it is measured.

    They are those of :data:`autobalancer.results.measure_table.MEASURES` for which the run kept the data: those over
    ``place``, ``plane`` and ``support`` ask for its last revolutions. ``settling_from`` is as for :func:`settling_time`.
    """
    recorded = recorded_of(run, known_origin(settling_from))
    where = repr(run.attrs.get("reference_station", "the rotor"))

    def label(measure: Measure) -> dict[str, str]:
        about = label_of(measure, settling_from)
        return about | {"long_name": about["long_name"].replace(HERE, where)}

    source = {key: run.attrs[key] for key in SOURCE if key in run.attrs}
    found = xr.Dataset(measured(recorded, MEASURES, label), attrs=source)
    for name in ("ball", "place", "plane", "support", "link"):
        if name in found.dims:
            found = found.assign_coords({name: run[name].values})
    if recorded.balls is not None:
        found = found.assign_coords(counted_from=recorded.settled.counted_from)
    if recorded.parts is not None:
        begins = [begin for begin, _, _ in parts_between_jumps(run) if begin > 0.0]
        about = {"units": "s", "long_name": "time of a jump of the unbalance"}
        found = found.assign_coords(jump_time=("jump", begins, about))
    return Measured.of(found)


def _per_ball(run: xr.Dataset, values: np.ndarray, text: str, unit: str) -> xr.DataArray:
    return xr.DataArray(values, {"ball": run["ball"].values}, ["ball"], attrs={"long_name": text, "units": unit})

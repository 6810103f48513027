"""Figure 6.12 as it was measured: amplitude and lag of order 1 from the laser and a pulse a turn of the encoder.

The rig on softening rubber runs up and down with 594 g mm in three of its twelve holes, and with the own unbalance that was
chosen for figure 6.10. Only the noisy signals are evaluated. Rows of words are those of figure_6_12 for softening rubber, with
the same misses; what is new is that the evaluation gives the motion back, as closely as it says.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.files.examples import rig
from autobalancer.plots.style import BALLS, INK, RACE, heading, legend, look, picture, save_picture
from reproductions import Found, compared_all, said
from reproductions.spannan2021._logger import ENCODER, KEPT, LASER, RATE
from reproductions.spannan2021.figure_6_10 import MIDDLE
from reproductions.spannan2021.figure_6_12 import AXIAL, DOWN, SEEN, SLOWING, UNSEEN, at, run_up_and_down, seen_by_laser

HOLES = (0.0, 120.0, 240.0)  # degrees
THROUGH = (50.0, 70.0)  # s
MINOR = 0.15


class RunUp(NamedTuple):
    """Amplitude (m) and lag (deg) of one run-up as the signals and as the motion have them; deviations as stated."""

    time: np.ndarray
    amplitude: np.ndarray
    amplitude_deviation: np.ndarray
    lag: np.ndarray
    lag_deviation: np.ndarray
    true_amplitude: np.ndarray
    true_lag: np.ndarray


def reproduce(out: Path) -> list[dict[str, Any]]:
    """What the source says of the phase, and the evaluation against the motion."""
    runs = [run_up(hole) for hole in HOLES]
    draw(runs, out)
    lags = np.array([[at(one.time, one.lag, when) for when in (SEEN, UNSEEN)] for one in runs])
    mean = np.mean([np.interp(np.linspace(100.0, DOWN, 1001), one.time, one.lag).mean() for one in runs])
    peaks = np.array([one.amplitude.max() for one in runs])
    seen = [within(one, SEEN, UNSEEN) for one in runs]
    off = np.concatenate([((one.lag - one.true_lag) / one.lag_deviation)[k] for one, k in zip(runs, seen, strict=True)])
    through = [(one, within(one, *THROUGH)) for one in runs]
    size = max(np.abs(one.amplitude / one.true_amplitude - 1.0)[k].max() for one, k in through)
    turn = max(np.abs(one.lag - one.true_lag)[k].max() for one, k in through)
    rows = [
        Found("words", "mean lag from 100 s to 145 s, from signals", "deg", 180.0, mean, 10.0, AXIAL),
        said("lag below 90 deg at 57 s and 170 s, from signals", bool((lags < 90.0).all()), SLOWING),
        Found("fitted", "greatest amplitudes with the unbalance in three places, farthest apart", "%", 0.0,
              100.0 * float(np.ptp(peaks) / peaks.mean()), 100.0 * MINOR,
              "the source calls differences minor; own unbalance of 30 g mm, chosen for figure 6.10"),
        Found("internal", "error of the lag over its stated deviation, 57 s to 170 s, root mean square", "1", 1.0,
              float(np.sqrt(np.mean(off**2))), 0.1),
        Found("internal", "amplitude of order 1 through the resonance, greatest error", "%", 0.0, 100.0 * float(size), 0.5),
        Found("internal", "lag of order 1 through the resonance, greatest error", "deg", 0.0, float(turn), 0.5),
    ]  # fmt: skip
    return compared_all("Spannan 2021", "6.12 in kind", rows)


def within(one: RunUp, start: float, end: float) -> np.ndarray:
    """Which points are between two times."""
    return np.asarray((one.time > start) & (one.time < end))


def run_up(hole: float) -> RunUp:
    """Up and down with the unbalance in one hole: measured, evaluated, and as the motion is."""
    machine = with_value_at(rig("discoidal_rig_rubber"), "balancers", ())
    added = machine.unbalances[0].model_dump(exclude_unset=True) | {"angle": f"{hole} deg"}
    machine = with_value_at(machine, "unbalances", [added, {"moment": MIDDLE, "station": "race"}])
    run = run_up_and_down(machine, KEPT)
    order = ab.measure.orders(ab.measure.record(run, (LASER, ENCODER), RATE, seed=round(hole)), 1.0).isel(
        order=0, channel=0
    )
    time = order["time"].values
    size, lag = seen_by_laser(run)
    unbalance = float(run["unbalance_angle_in_rotor"][0])
    turned = (np.degrees(unbalance - order["phase"].values) + 90.0) % 360.0 - 90.0
    true = np.interp(time, run["time"].values, (lag + 90.0) % 360.0 - 90.0)
    return RunUp(
        time,
        order["amplitude"].values,
        order["amplitude_deviation"].values,
        turned,
        np.degrees(order["phase_deviation"].values),
        np.interp(time, run["time"].values, size),
        true,
    )


def draw(runs: list[RunUp], out: Path) -> None:
    """Envelope of the amplitudes, and the lag of the first run-up with twice its deviation."""
    with look():
        figure = picture(7.6, 5.6)
        above, below = figure.subplots(2, 1, sharex=True)
        for panel in (above, below):
            panel.axvspan(SEEN, UNSEEN, color=RACE, zorder=0)
        first = runs[0]
        sizes = 1e3 * np.array([np.interp(first.time, one.time, one.amplitude) for one in runs])
        above.fill_between(first.time, sizes.min(axis=0), sizes.max(axis=0), color=BALLS[0], alpha=0.35, lw=0,
                           label="three places of the unbalance")  # fmt: skip
        above.plot(first.time, sizes[0], color=BALLS[0], lw=1.0, label="first place")
        above.set(ylabel="amplitude of order 1\nat the laser (mm)", ylim=(0.0, None))
        part = (first.time > 20.0) & (first.time < UNSEEN + 4.0)
        t, lag, sure = first.time[part], first.lag[part], 2.0 * first.lag_deviation[part]
        below.fill_between(t, lag - sure, lag + sure, color=BALLS[0], alpha=0.35, lw=0, label="95 % interval")
        below.plot(t, lag, color=BALLS[0], lw=0.8, label="from signals")
        below.plot(t, first.true_lag[part], color=INK, lw=0.7, ls=(0, (4, 3)), label="motion")
        below.set(xlabel="time (s)", ylabel="angle of lag (deg)", ylim=(0.0, 210.0), yticks=[0, 45, 90, 135, 180])
        legend(above)
        below.legend(loc="center", bbox_to_anchor=(0.6, 0.4))
        heading(figure, "Spannan 2021, figure 6.12 from signals of the simulated rig")
        save_picture(figure, out / "figure_6_12_from_signals.png")

"""A measurement beside a run of the archive, and the measured speed as the drive of a machine."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.app.store.archive import Archive
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.measured.looks import Asked, turning
from autobalancer.errors import QuestionError
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine import Machine
from autobalancer.measurement.comparison.overlay import overlay
from autobalancer.plots.measured.overlay import overlay as overlay_picture
from autobalancer.results.answers.overlay import Overlay
from autobalancer.results.signals.signals import Signals
from autobalancer.simulation.run import simulate_races
from autobalancer.simulation.sampling import Samples

A_TURN = 32  # samples of a run in a turn of the rotor, of which a signal is interpolated
MOST = 400_000  # samples of a run that is made again
POINTS, SAMPLES = 60, 6000  # of a speed profile, and of the angle that it follows


def beside(archive: Archive, run: str, measured: xr.Dataset, asked: Asked, job: Job) -> tuple[Overlay, str]:
    """A measurement beside a run, and what was done for it.

    A run of the archive has about two thousand samples. Where these are too few, the same machine is run again, with more.

    Raises
    ------
    QuestionError
        If their times do not meet, a place is not in the run, or the run is one of a deep chamber.
    """
    known = archive.run(run)
    options: dict[str, Any] = {}
    if isinstance(measured, Signals) and turning(measured):
        options = {"pulses": int(float(asked.pulses or "1")), "tacho_angle": asked.tacho_angle.strip() or None}
    try:
        return overlay(known, measured, **options), ""
    except QuestionError:
        if "rotor_angle" not in known or known.sizes["time"] >= _needed(known):
            raise
    machine = parse_machine(archive.text(run), "machine")
    if not isinstance(machine, Machine):
        raise QuestionError("a run of a deep chamber cannot be put beside a measurement")
    again = simulate_races(
        machine,
        duration=float(known.attrs["end_time"]),
        seed=int(known.attrs.get("seed", 0)),
        save=Samples(_needed(known)),
        progress=job.progress,
    )
    note = f"the run was made again with {_needed(known)} samples in place of {known.sizes['time']}"
    return overlay(again, measured, **options), note


def _needed(run: xr.Dataset) -> int:
    """Samples with which a run can be seen between its samples, also where it is fastest."""
    turns = float(np.ptp(run["time"].values) * np.abs(run["speed"].values).max()) / (2.0 * np.pi)
    return int(min(MOST, np.ceil(A_TURN * turns) + 20))


def picture(found: Overlay) -> Callable[[], Any]:
    """Both in one picture."""
    return lambda: overlay_picture(found)


def drive_of(measured: xr.Dataset, asked: Asked) -> tuple[dict[str, Any], str]:
    """The measured turning of the rotor: a speed profile of a machine file, and the angle of the rotor at time zero.

    The speeds at some times, straight in between, are those whose angle is nearest to the measured one.

    Raises
    ------
    QuestionError
        If the measurement does not say how the rotor turned.
    """
    turned = asked.turned(measured)
    thin = slice(None, None, max(1, turned.sizes["time"] // SAMPLES))
    time, angle = turned["time"].values[thin], turned["rotor_angle"].values[thin]
    knots = np.linspace(time[0], time[-1], POINTS)
    parts = np.array([np.interp(time, knots, row) for row in np.eye(POINTS)]).T
    steps = 0.5 * np.diff(time)[:, None] * (parts[1:] + parts[:-1])
    turns = np.vstack([np.zeros(POINTS), np.cumsum(steps, axis=0)])
    first, *speeds = np.linalg.lstsq(np.column_stack([np.ones(time.size), turns]), angle, rcond=None)[0]
    begin = (first - speeds[0] * time[0] + np.pi) % (2.0 * np.pi) - np.pi
    profile = {
        "kind": "table",
        "time": [f"{t:.6g} s" for t in knots],
        "speed": [f"{max(w, 0.0):.8g} rad/s" for w in speeds],
    }
    return profile, f"{np.degrees(begin):.5g} deg"

"""Balls free in three dimensions: time of a ball and step, and of a start-up, on one thread.

The balls of ``chamber_ns_per_ball_step_*`` are settled in the chamber of the reference machine and driven to 160 rad/s within
0.05 s; all terms of the contacts are on. The second half of the run counts: for 50 balls they turn with the rotor, for more
the pile is being carried up. The start-up goes to disk in a process of its own, whose greatest memory is measured too.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import Any

from autobalancer.files.machine_file import balls_in_chambers
from autobalancer.machine.chamber import ChamberMachine
from autobalancer.results.archive import Archive
from autobalancer.simulation.chamber import simulate_chamber
from autobalancer.studies.chamber_study import amplitudes, archived_run
from benchmarks import compared, measured, seconds

MACHINE = Path(__file__).resolve().parent.parent / "examples" / "machines" / "deep_chamber.toml"
STEP = 1e-6  # s


def bench() -> list[dict[str, Any]]:
    """Four numbers of balls, two rows for a start-up, and a study on two cores."""
    many = [per_ball(count, 0.06, 0.5 * STEP) for count in (200, 500, 1000)]
    return [per_ball(50, 2.0, STEP), *many, *start_up(), two_cores()]


def machine(count: int, speed: float) -> ChamberMachine:
    """The reference machine with so many balls of the same total mass, at a prescribed speed unless it is 0."""
    described = balls_in_chambers(MACHINE).model_dump(exclude_unset=True)
    described["chambers"][0]["balls"][0]["count"] = count
    if speed:
        rise = {"kind": "ramp", "start": 0.0, "end": speed, "duration": 0.05}
        described["drive"] = {"kind": "speed", "profile": rise}
    return ChamberMachine(**described)


def per_ball(count: int, duration: float, step: float) -> dict[str, Any]:
    """Processor time of a step over the number of balls, in the second half of a run."""
    given = machine(count, 160.0)
    held: list[Any] = []
    half = round(0.5 * duration / 1e-3)
    run = simulate_chamber(
        given, duration=0.5 * duration, step=step, chunk=half, on_chunk=lambda part, state: held.append(state)
    )
    begin = process_time()
    run = simulate_chamber(given, duration=duration, step=step, resume=held[-1])
    time = (process_time() - begin) / (half * round(1e-3 / run.step)) / count
    return measured(f"chamber_ns_per_ball_step_{count}", 1e9 * time, "ns", note=f"steps of {run.step:.3g} s")


def start_up() -> list[dict[str, Any]]:
    """Processor time and memory of 20 s of the reference machine with 50 balls; Pakuła (2021) needed 135 h for such a run."""
    command = [sys.executable, "-c", "from benchmarks.chamber import streamed; streamed()"]
    root = Path(__file__).resolve().parent.parent
    said = subprocess.run(command, cwd=root, capture_output=True, text=True, check=True).stdout
    found = json.loads(said)
    time, error, memory = found["time"], found["error"], found["memory"]
    note = f"published: 135 h, {135 * 3600 / time:.0f} times as long; energy error {error:.0e} of the work"
    rows = [measured("chamber_50_balls_20_s", time, "s", note=note)]
    if memory:
        note = f"greatest of the process that writes these 20 s to an archive; without a run {found['empty']:.0f} MB"
        rows.append(measured("chamber_memory_mb", memory, "MB", note=note))
    return rows


def two_cores() -> dict[str, Any]:
    """A study into an archive, of eight runs whose times differ by a factor of three, on two threads against one."""
    counts, seeds, duration = (20, 50), range(4), 1.0

    def study(workers: int) -> None:
        with TemporaryDirectory() as folder:
            how: dict[str, Any] = {"layers": ("deep",), "seeds": seeds, "archive": folder, "workers": workers}
            amplitudes(machine(50, 0.0), counts, (0.5,), duration=duration, step=STEP, **how)

    one, two = (seconds(lambda workers=workers: study(workers), repeats=2) for workers in (1, 2))
    runs = f"{len(counts) * len(seeds)} start-ups of {duration:g} s with {counts[0]} and {counts[1]} balls"
    return compared("chamber_two_cores", two, "one core", one, note=f"{runs}, checked, settled, archived and measured")


def streamed() -> None:
    """Run the start-up into an archive and print what it took."""
    given = machine(50, 0.0)
    simulate_chamber(given, duration=1e-3, step=STEP)  # whatever has to be compiled
    empty = memory()
    with TemporaryDirectory() as folder:
        begin = process_time()
        run = archived_run(Archive(Path(folder)), "start-up", given, duration=20.0, step=STEP)
        time = process_time() - begin
        last = run.samples().isel(time=-1)
        error = float(last.energy_error / last.work_motor)
    print(json.dumps({"time": time, "error": error, "memory": memory(), "empty": empty}))


def memory() -> float:
    """Greatest memory of this process so far, MB; 0 where the system does not tell."""
    try:
        import resource
    except ImportError:
        return 0.0
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return used / (2**20 if sys.platform == "darwin" else 2**10)

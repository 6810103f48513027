"""What everybody waits for, measured from processes: help, a check, a run; first, warm, and from a wheel; and the weight.

``make bench ONLY=start`` measures these rows alone, in about a minute. What is done by one process is given in processor time,
which other work on the computer changes little; what several processes do together is given by the clock.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path
from time import perf_counter
from typing import Any

from benchmarks import measured
from benchmarks._run_up import MACHINE

ROOT = Path(__file__).resolve().parent.parent
IMPORT = [sys.executable, "-c", "import autobalancer"]
CHECK = [sys.executable, "-m", "autobalancer", "check", str(MACHINE)]
RUN = [sys.executable, "-m", "autobalancer", "simulate", str(MACHINE)]
COMMAND = [
    sys.executable,
    "-c",
    "import sys; sys.argv[0] = 'autobalancer'; import autobalancer.__main__ as a; a.main()",
]
TAB = {"_AUTOBALANCER_COMPLETE": "complete_bash", "COMP_WORDS": "autobalancer si", "COMP_CWORD": "1"}
REPEATS = 5
PARTS = {"lint", "test", "app-test"}  # of .ci/run
LIMITS = {
    "import_s": 0.2,
    "help_s": 0.3,
    "completion_s": 0.3,
    "warm_check_s": 1.0,
    "warm_simulate_s": 1.5,
    "first_check_s": 5.0,
    "first_simulate_s": 20.0,
    "wheel_first_simulate_s": 2.0,
    "ci_cpu_s": 640.0,
}
NOTES = {
    "import_s": "import autobalancer",
    "help_s": "autobalancer --help",
    "completion_s": "what a shell asks when the tab key is pressed",
    "warm_check_s": "autobalancer check, kernels in the cache",
    "warm_simulate_s": "autobalancer simulate of 20 s of stall and release, result file written, kernels in the cache",
    "first_check_s": "autobalancer check with an empty cache",
    "first_simulate_s": "the simulate with an empty cache",
    "wheel_first_simulate_s": "the first simulate of what make wheel built",
}


def wait(command: list[str], repeats: int = REPEATS, **environment: str) -> tuple[float, float]:
    """Least processor time of a process, and least time by the clock, s."""
    walls, processors = [], []
    bytecode = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}  # as a user has it
    for _ in range(repeats):
        before, start = _processor(), perf_counter()
        subprocess.run(command, env=bytecode | environment, check=True, stdout=subprocess.DEVNULL)
        walls.append(perf_counter() - start)
        processors.append(_processor() - before)
    return min(processors), min(walls)


def _processor() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def bench() -> list[dict[str, Any]]:
    """The ratio is the limit over the time; a limit is not a target."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        run = [*RUN, "--out", str(folder / "run.nc")]
        for once in (CHECK, run):  # compiles what is not there
            wait(once, 1)
        times = {
            "import_s": wait(IMPORT),
            "help_s": wait([*COMMAND, "--help"]),
            "completion_s": wait(COMMAND, **TAB),
            "warm_check_s": wait(CHECK),
            "warm_simulate_s": wait(run),
        }
        wheel = next((ROOT / "dist").glob(f"*-cp{sys.version_info.major}{sys.version_info.minor}-none-*.whl"), None)
        if wheel is not None:
            times["wheel_first_simulate_s"] = _from_wheel(wheel, folder / "wheel", run)
        first = {
            "first_check_s": wait(CHECK, 1, NUMBA_CACHE_DIR=str(folder / "check")),
            "first_simulate_s": wait(run, 1, NUMBA_CACHE_DIR=str(folder / "simulate")),
        }
    rows = [_limited(name, cpu, f"{NOTES[name]}; {clock:.2f} s by the clock") for name, (cpu, clock) in times.items()]
    rows += [
        _limited(name, clock, f"{NOTES[name]}; the first process took {cpu:.1f} s of processor time")
        for name, (cpu, clock) in first.items()
    ]
    parts = _parts_of_ci()
    if parts.keys() >= PARTS:
        rows.append(_limited("ci_cpu_s", sum(parts.values()), "processor time of .ci/run, when it last ran"))
    texts = [path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*.py")]
    rows.append(measured("src_lines", sum(len(text.splitlines()) for text in texts), "lines", note="of Python in src"))
    rows.append(measured("src_files", len(texts), "files", note="their ceiling is in tests/test_house.py"))
    return rows


def _from_wheel(wheel: Path, folder: Path, run: list[str]) -> tuple[float, float]:
    """As pip installs it, with bytecode; the libraries are those of this environment."""
    with zipfile.ZipFile(wheel) as packed:
        packed.extractall(folder)
    subprocess.run([sys.executable, "-m", "compileall", "-q", str(folder)], check=True)
    cache = folder / "cache"
    times = wait(run, 1, PYTHONPATH=str(folder), NUMBA_CACHE_DIR=str(cache))
    if any(cache.rglob("*.nbi")):
        raise RuntimeError(f"{wheel.name}: kernels were compiled; make wheel builds one that fits")
    return times


def _parts_of_ci() -> dict[str, float]:
    kept = ROOT / "build" / "ci_times.json"
    parts = json.loads(kept.read_text(encoding="utf-8")) if kept.exists() else {}
    return {name: float(part["processor_s"]) for name, part in parts.items()}


def _limited(name: str, value: float, note: str) -> dict[str, Any]:
    limit = LIMITS[name]
    return measured(name, value, "s", note=note) | {"peer": f"limit {limit:g} s", "ratio": limit / value}

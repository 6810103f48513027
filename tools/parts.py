"""Processor time of the parts of a check: ``python -m tools.parts run NAME COMMAND ...``, and their table without words.

Seconds of a quick machine are not those of a slow one, or of one that others use, too. So a part is measured in loops: while it
runs, a loop of fixed work is timed now and then on the same processors. More loops than its share are said, more than 1.5 shares
fail.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
KEPT = ROOT / "build" / "ci_times.json"
BY_TEST = "TIMES_BY_TEST"  # names the file in which tests/conftest.py leaves the time of each test
EVERY = 10.0  # s between two loops: 0.3 % of the time of a part
SHOWN = 8  # files of tests named for each part

# Thousands of loops, about 6 s of a quick machine each: 1.5 times what the part took in a checkout where nothing was compiled,
# and twice what style, types and pages took, which depend on stores and waiting. That bears other processors and other work.
SHARES = {"lint": 60.0, "kernels": 36.0, "test": 148.0, "app-test": 42.0}
FAILS = 1.5  # shares, which no noise reaches: 2.25 times what was measured, or more


def loop() -> float:
    """Processor time of fixed work, s: a mix of numbers, texts and tables as in an interpreter that tests."""
    start, found, total = time.thread_time(), dict[str, float](), 0.0
    for k in range(40_000):
        total += (k * 1.000001) % 7.0
        found[f"part {k % 97}"] = total
    assert len(found) == 97
    return time.thread_time() - start


def _used() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return children.ru_utime + children.ru_stime


def run(name: str, command: list[str]) -> int:
    """Run the command, say what it took and note it; the answer is its exit code."""
    KEPT.parent.mkdir(exist_ok=True)
    by_test = KEPT.with_name(f"{name}_tests.json")
    by_test.unlink(missing_ok=True)
    start, before, loops = time.monotonic(), _used(), [loop()]
    running = subprocess.Popen(command, env=os.environ | {BY_TEST: str(by_test)})
    while (code := _ended(running)) is None:
        loops.append(loop())
    took = {"processor_s": _used() - before, "clock_s": time.monotonic() - start, "loop_s": sum(loops) / len(loops)}
    parts = _kept()
    parts[name] = {key: float(f"{value:.4g}") for key, value in took.items()}
    if by_test.exists():
        parts[name]["tests"] = json.loads(by_test.read_text(encoding="utf-8"))
        by_test.unlink()
    KEPT.write_text(json.dumps(parts, indent=1), encoding="utf-8")
    print(f"{name}: {took['processor_s']:.0f} s of processor time, {took['clock_s']:.0f} s by the clock", flush=True)
    return code


def _ended(running: subprocess.Popen[bytes]) -> int | None:
    try:
        return running.wait(EVERY)
    except subprocess.TimeoutExpired:
        return None
    except KeyboardInterrupt:  # the command got it, too
        return running.wait()


def _kept() -> dict[str, Any]:
    try:
        return dict(json.loads(KEPT.read_text(encoding="utf-8")))
    except (OSError, ValueError):  # none was run, or one was killed while it wrote
        return {}


def over(parts: dict[str, Any], shares: float = 1.0) -> list[str]:
    """The parts that took more than so many of their shares."""
    return [name for name, took in parts.items() if name in SHARES and _thousands(took) > shares * SHARES[name]]


def _thousands(took: dict[str, Any]) -> float:
    return float(took["processor_s"] / took["loop_s"] / 1000.0)


def table(parts: dict[str, Any], files: bool = True) -> list[str]:
    """Lines with all parts, and with the files of tests that took most."""
    lines = [f"{'part':<12}{'processor':>12}{'clock':>10}{'thousand loops':>18}{'at most':>10}"]
    for name, took in parts.items():
        limit = f"{SHARES[name]:.3g}" if name in SHARES else "-"
        times = f"{took['processor_s']:>10.0f} s{took['clock_s']:>8.0f} s"
        lines.append(f"{name:<12}{times}{_thousands(took):>18.3g}{limit:>10}")
    for name, took in parts.items() if files else ():
        by_file = Counter[str]()
        for test, seconds in took.get("tests", {}).items():
            by_file[test.partition("::")[0]] += seconds
        lines += ["", f"{name}: most processor time"] if by_file else []
        lines += [f"{seconds:>10.1f} s  {file}" for file, seconds in by_file.most_common(SHOWN)]
    for name in over(parts):
        lines += [
            "",
            f"{name} takes {_thousands(parts[name]) / SHARES[name]:.2g} times its share, and fails above {FAILS}: see above",
            f"which files of tests take most (each test is in {KEPT}), and shrink, merge or mark tests that guard the same",
            "fact. A share is raised in tools/parts.py, with its reason.",
        ]
    return lines


def main(words: list[str]) -> int:
    """Run a part, or show the table of those that were run; 1 if one took ``FAILS`` times its share."""
    if words[:1] == ["run"]:
        return run(words[1], words[2:])
    parts = _kept()
    print("\n".join(table(parts, files="--short" not in words)) if parts else "no part was run: make test")
    return int(bool(over(parts, FAILS)))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

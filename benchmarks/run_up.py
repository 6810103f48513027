"""How long the stall-and-release run-up takes, against SciPy and heyoka, all to the same accuracy."""

from __future__ import annotations

from typing import Any

from benchmarks import compared
from benchmarks._run_up import GOAL, SAMPLES, Found, fastest, float_rates, heyoka, numpy_rates, ours, scipy

LADDER = [10.0 ** (-k / 4.0) for k in range(16, 41)]  # 1e-4 to 1e-10


def bench() -> list[dict[str, Any]]:
    """Every program at its fastest setting that reaches 1e-6."""
    us = fastest({f"tolerance {t:.1e}": ours(t) for t in LADDER}, repeats=15)
    rows = []
    for name, peer, build in (
        ("run_up_vs_scipy", "SciPy DOP853, NumPy right-hand side", numpy_rates),
        ("run_up_vs_scipy_floats", "SciPy DOP853, right-hand side in plain Python", float_rates),
    ):
        settings = {f"rtol {t:.1e}": scipy(t, build) for t in LADDER[::2]}
        rows.append(row(name, us, peer, fastest(settings, repeats=1, enough=True)))
    settings = {
        f"tol {t:.1e}, {'rotor' if rotating else 'space'} frame{', fast math' if fast else ''}": heyoka(
            t, rotating=rotating, fast_math=fast
        )
        for t in LADDER[8:]
        for rotating in (True, False)
        for fast in (False, True)
    }
    them = fastest(settings, repeats=15)
    rows.append(row("run_up_vs_heyoka", us, "heyoka, Taylor series", them))
    rows.append(without_samples(us, them))
    return rows


def row(name: str, us: Found, peer: str, them: Found) -> dict[str, Any]:
    note = (
        f"20 s, {SAMPLES} samples, errors at most {GOAL:g}; ours: rotor frame, {us.setting}, error {us.error:.1e}; "
        f"theirs: {them.setting}, error {them.error:.1e}"
    )
    return compared(name, us.seconds, peer, them.seconds, note=note)


def without_samples(us: Found, them: Found) -> dict[str, Any]:
    """The same settings, but only the state at the end is asked for."""
    tolerance = float(us.setting.split()[1])
    setting = them.setting.split(", ")
    mine = ours(tolerance, samples=False)
    peer = heyoka(
        float(setting[0].split()[1]), rotating="rotor" in setting[1], fast_math=len(setting) > 2, samples=False
    )
    times = [min(run()[0] for _ in range(15)) for run in (mine, peer)]
    return compared(
        "run_up_end_vs_heyoka", times[0], "heyoka, Taylor series", times[1], note="same settings, only the end is kept"
    )

"""How long the stall-and-release run-up takes, against SciPy and heyoka, all to the same accuracy."""

from __future__ import annotations

from typing import Any

from benchmarks import compared
from benchmarks._run_up import GOAL, SAMPLES, Found, Run, fastest, float_rates, heyoka, numpy_rates, ours, scipy

LADDER = [10.0 ** (-k / 4.0) for k in range(16, 61)]  # 1e-4 to 1e-15
TIGHT = 1e-9


def bench() -> list[dict[str, Any]]:
    """Every program at its fastest setting that reaches 1e-6, and the two fast ones at 1e-9."""
    us, them = fastest(our_settings(), repeats=15), fastest(heyoka_settings(), repeats=15)
    rows = [row("run_up_vs_heyoka", us, "heyoka, Taylor series", them, GOAL), without_samples(us, them)]
    us_tight, them_tight = (fastest(s, goal=TIGHT, repeats=15) for s in (our_settings(), heyoka_settings()))
    rows.append(row("run_up_vs_heyoka_1e-9", us_tight, "heyoka, Taylor series", them_tight, TIGHT))
    for name, peer, build in (
        ("run_up_vs_scipy", "SciPy DOP853, NumPy right-hand side", numpy_rates),
        ("run_up_vs_scipy_floats", "SciPy DOP853, right-hand side in plain Python", float_rates),
    ):
        settings = {f"rtol {t:.1e}": scipy(t, build) for t in LADDER[:25:2]}
        rows.append(row(name, us, peer, fastest(settings, repeats=2, enough=True), GOAL))
    return rows


def our_settings() -> dict[str, Run]:
    return {f"tolerance {t:.1e}": ours(t) for t in LADDER if t > 1e-13}


def heyoka_settings() -> dict[str, Run]:
    return {
        f"tol {t:.1e}, {'rotor' if rotating else 'space'} frame{', fast math' if fast else ''}": heyoka(
            t, rotating=rotating, fast_math=fast
        )
        for t in LADDER[12:]
        for rotating in (True, False)
        for fast in (False, True)
    }


def row(name: str, us: Found, peer: str, them: Found, goal: float) -> dict[str, Any]:
    note = (
        f"20 s, {SAMPLES} samples, errors at most {goal:g}; ours: rotor frame, {us.setting}, error {us.error:.1e}; "
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
    pairs = [(mine()[0], peer()[0]) for _ in range(25)]
    note = "same settings as in run_up_vs_heyoka, but only the end is kept"
    return compared(
        "run_up_end_vs_heyoka", min(p[0] for p in pairs), "heyoka, Taylor series", min(p[1] for p in pairs), note=note
    )

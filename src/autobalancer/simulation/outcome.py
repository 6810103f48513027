"""How a run ended: a value with a sentence and a cure, not an exception."""

from __future__ import annotations

from dataclasses import dataclass

from autobalancer.kernels.integrators.runge_kutta import EVENT, FINISHED, NOT_FINITE, STEP_TOO_SMALL


@dataclass(frozen=True)
class Outcome:
    """``name`` is one of finished, event, step too small, not finite, budget spent, interrupted."""

    name: str
    text: str


def outcome(
    status: int, time: float, duration: float, *, interrupted: bool, steps: int, event: str = "", fault: str = ""
) -> Outcome:
    """The outcome of a run that stopped at ``time``; ``fault`` names a force or friction law that was not a number."""
    if interrupted:
        return Outcome("interrupted", f"interrupted at {time:.6g} s of {duration:.6g} s; what was computed is kept")
    if status == FINISHED:
        return Outcome("finished", f"reached {duration:.6g} s")
    if status == EVENT:
        return Outcome("event", f"ended at {time:.6g} s by: {event}")
    if fault and status in (STEP_TOO_SMALL, NOT_FINITE):
        return Outcome("not finite", f"at {time:.6g} s {fault}")
    if status == STEP_TOO_SMALL:
        return Outcome(
            "step too small",
            f"at {time:.6g} s the step size fell below rounding; "
            "the tolerance may be too tight or a value far too large",
        )
    if status == NOT_FINITE:
        return Outcome("not finite", f"at {time:.6g} s the motion grew without limit; check masses, drag and drive")
    return Outcome(
        "budget spent",
        f"{steps} steps were taken up to {time:.6g} s; "
        "raise max_steps or shorten the run; steps much shorter than a revolution mean a stiff machine: look for a drag "
        "or a stiffness that is far too large",
    )

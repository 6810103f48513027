"""What a deep chamber can do at best, as rows of a table: a name and a text each."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

from autobalancer.results.number_text import couple_text, force_text, length_text, moment_text

if TYPE_CHECKING:
    from autobalancer.simulation.chamber.bounds import ChamberBounds


def bounds_rows(found: ChamberBounds, said: Callable[[float], str]) -> list[tuple[str, str]]:
    """Everything that is shown of it, with speeds as ``said`` writes them."""
    calm = "calm: balls stay in touch with the bottom" if found.shaking < 1.0 else "balls hop at the bottom"
    one = "one row along the axis, which acts as one ball"
    lying = one if found.axial_rows == 1 else f"{found.axial_rows} rows along the axis"
    pressure = "" if math.isnan(found.race_pressure) else f", {1e-6 * found.race_pressure:.4g} MPa"
    held = moment_text(found.held_residual) if found.held_residual else "nothing, for gravity keeps the balls moving"
    rate = f"{found.decay_rate:.3g} 1/s, at best {found.best_decay_rate:.3g} 1/s with a drag of {found.best_drag:.3g} N s/m"
    return [
        ("speed", f"{said(found.speed)}, highest critical speed {said(found.critical_speed)}"),
        ("unbalance", f"{moment_text(found.unbalance)}; the balls can balance {moment_text(found.capability)}"),
        ("residual", f"at least {moment_text(found.least_residual)}; rolling resistance can hold {held}"),
        (
            "vibration",
            f"{length_text(found.vibration_without_balls)} without balls; at least {length_text(found.least_vibration)}",
        ),
        (
            "pick-up",
            f"one sliding ball needs a friction of {found.least_friction:.3g} on a calm rotor and has {found.friction:g}\n"
            f"the balls lie in {lying}\n"
            f"the rotor shakes with {found.shaking:.3g} g at most, {calm}",
        ),
        ("run-up", f"critical speed passed after {found.run_up_time:.3g} s or later"),
        ("small motions", f"decay with {rate}"),
        ("settling", f"takes {found.least_settling_time:.3g} s or longer"),
        ("ball on the race", f"{force_text(found.race_force)}{pressure}"),
        (
            "couple of the balls",
            f"at most {couple_text(found.greatest_couple)}, {force_text(found.couple_bearing_force)} on each bearing",
        ),
        ("bearings", f"the more loaded one bears {force_text(found.least_bearing_force)} or more"),
    ]

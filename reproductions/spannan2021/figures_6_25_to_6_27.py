"""Figures 6.25 to 6.27 in kind: run-ups with one ball in three oils, on the planar stand-in of table 6.4.

The ball of sections 6.1.6 and 6.1.8: 5.4 g, 10.95 mm, of which 4.75 g are effective in oil. Drag law (6.9), repaired. The curves
of the source are pictures only, and its text gives no number of turns. So the turns that the ball makes in the rotor before
the whirl holds it, below the resonance, are held against an independent integration of the ball alone under drag, the
acceleration of the rotor and its whirl, taken as steady at each speed; means over eight start positions. Friction on the floor
of the annulus, on which the balls of the source lay at first, is left out.

The rig tilts and stands on rubber; the stand-in passes its resonance at 9.7 Hz, the tilting rig of the catalog at 9.6 Hz
(figure 6.10).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import autobalancer as ab
from autobalancer.assembly.parameters import with_value_at
from autobalancer.catalog.resolve import Ball, resolve
from autobalancer.machine import Machine
from autobalancer.plots.drawing.save import save_picture
from reproductions import Found, compared_all, said

MACHINE = Path(__file__).parents[2] / "examples" / "machines" / "one_ball_run_up.toml"
DENSITY = {5: 844.0, 20: 955.0, 50: 950.0}  # kg/m^3 by mm^2/s: tables 6.3 and 6.1
UNBALANCE = 594.0  # g mm, section 6.1.3
STARTS = np.arange(8) * math.pi / 4.0 + 0.1
HELD = 50.0  # rad/s, below the resonance at 61 rad/s
TURN = 2.0 * math.pi


def reproduce(out: Path) -> list[dict[str, Any]]:
    """Ball position, residual deflection with the ball against without, turns before capture."""
    machine = with_value_at(ab.load_machine(MACHINE), "balancers[1].races[1].drag", {"law": "discoidal"})
    bare = ab.simulate(with_value_at(machine, "balancers", ()))
    turns, farthest, misses = [], 0.0, []
    for viscosity, density in DENSITY.items():
        race = "balancers[1].races[1].fluid"
        oil = with_value_at(with_value_at(machine, f"{race}.viscosity", viscosity * 1e-6), f"{race}.density", density)
        run = ab.simulate(oil)
        save_picture(ab.plot.run_up(run), out / f"one_ball_{viscosity}_mm2_s.png")
        moment = 1e6 * float(run["ball_moment"][0])
        farthest = max(farthest, 180.0 - abs(float(np.degrees(ab.ball_angle_to_unbalance(run)[-1, 0]))))
        simulated, alone = turns_of(oil)
        ratio = ab.residual_vibration(run) / ab.residual_vibration(bare)
        turns.append(simulated)
        misses.append((ratio / (1.0 - moment / UNBALANCE) - 1.0, simulated / alone - 1.0))
    left, alone = 100.0 * np.abs(misses).max(axis=0)
    rows = [
        Found("words", "ball opposite to the unbalance at the end, farthest of three oils", "deg", 0.0, farthest, 3.0),
        said("the thinner the oil, the more turns the ball lags", turns[0] > turns[1] > turns[2]),
        Found(
            "internal", "deflection at 1200 rpm with ball / without, against the moments, farthest", "%", 0.0, left, 0.5
        ),
        Found("internal", "turns in the rotor before capture, against the ball alone, farthest", "%", 0.0, alone, 0.5),
    ]
    return compared_all("Spannan 2021", "6.25 to 6.27 in kind", rows)


def turns_of(machine: Machine) -> tuple[float, float]:
    """Turns in the rotor before the whirl holds the ball, simulated and by the ball alone, means over the starts."""
    ball, found = resolve(machine)[0], []
    profile = machine.drive.profile
    end = float(np.interp(HELD, profile.speed, profile.time))
    for start in STARTS:
        one = with_value_at(machine, "balancers[1].races[1].balls[1].start_angles", [float(start)])
        run = ab.simulate(one, duration=end, save=ab.Samples(2))
        found.append((abs(float(run["ball_angle_in_rotor"][-1, 0]) - start) / TURN, drifted(one, ball, start, end)))
    simulated, alone = np.array(found).mean(axis=0)
    return float(simulated), float(alone)


def drifted(machine: Machine, ball: Ball, start: float, end: float) -> float:
    """Turns of a ball alone, whose rotor whirls as unbalance and ball make it at a constant speed."""
    rotor, profile, curve = machine.rotor, machine.drive.profile, ball.drag_curve
    mass = float(rotor.mass) + ball.effective_mass
    lag = ball.effective_mass * ball.orbit_radius**2 - ball.spin_ratio * ball.mass * ball.radius * ball.orbit_radius
    times, speeds = (np.array([float(v) for v in values]) for values in (profile.time, profile.speed))

    def rate(t: float, y: np.ndarray) -> list[float]:
        w = float(np.interp(t, times, speeds))
        gain = w**2 / (float(rotor.stiffness) - mass * w**2 + 1j * float(rotor.damping) * w)
        whirl = (1e-6 * UNBALANCE + ball.moment * np.exp(1j * y[0])) * gain
        pull = ball.moment * w**2 * (np.exp(-1j * y[0]) * whirl).imag
        step = np.searchsorted(times, t, side="right")
        growth = (speeds[step] - speeds[step - 1]) / (times[step] - times[step - 1]) if step < times.size else 0.0
        return [y[1], (pull - float(curve.torque(y[1], ball.orbit_radius)) - lag * growth) / ball.inertia]

    state = np.array([start, 0.0])
    for begin, until in zip(times, [*times[1:], end], strict=True):
        if begin < end:
            state = solve_ivp(rate, (begin, min(until, end)), state, rtol=1e-7, atol=1e-9, method="LSODA").y[:, -1]
    return abs(float(state[0]) - start) / TURN

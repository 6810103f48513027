"""What a result says of balls on real races: who rests, how hard each is pressed, and whether one would have left."""

from __future__ import annotations

from typing import Any

import numpy as np

from autobalancer.assembly.places import Places, accelerations, deflections
from autobalancer.assembly.system import Assembly
from autobalancer.kernels.balls.normal_forces import normal_forces
from autobalancer.kernels.derivatives import derivatives
from autobalancer.kernels.system import BALLS, SPEED, THETA, Floats, Matrix
from autobalancer.simulation.equations import equations

STANDARD_GRAVITY = 9.80665


def has_real_races(assembly: Assembly) -> bool:
    """Whether guided balls run on races with friction, shape, curved drag or excitation."""
    return bool(assembly.rough and assembly.balls)


def on_races(states: Matrix, times: Floats, assembly: Assembly) -> dict[str, Any]:
    """Normal force on each ball, N, and whether adherence holds it; variables over (time, ball)."""
    n = len(assembly.balls)
    force, work = np.zeros((times.size, n)), np.zeros(states.shape[1])
    times, states = np.ascontiguousarray(times), np.ascontiguousarray(states)
    normal_forces(equations(assembly).rates, assembly.system, times, states, work, force)
    holding = assembly.system.balls.adherence > 0.0
    rests = (states[:, BALLS + n : BALLS + 2 * n] == 0.0) & holding
    return {"ball_at_rest": (("time", "ball"), rests), "ball_normal_force": (("time", "ball"), force)}


def stored_in_forces(states: Matrix, assembly: Assembly) -> dict[str, Any]:
    """Potential energy of the forces on balls, J; a variable over time where any has one."""
    if not assembly.system.forces.energy.any():
        return {}
    from autobalancer.kernels.balls.force_energy import force_energies

    energy = np.zeros(len(states))
    force_energies(assembly.system, np.ascontiguousarray(states), energy)
    return {"force_energy": ("time", energy)}


def wall_forces(states: Matrix, times: Floats, assembly: Assembly, places: Places) -> Matrix:
    """Normal force of a plain race on each guided ball, N, (times, balls): what its motion and its weight ask for."""
    balls, n, system = assembly.balls, len(assembly.balls), assembly.system
    rates = np.zeros_like(states)
    derivatives(equations(assembly).rates, system, np.ascontiguousarray(times), np.ascontiguousarray(states), rates)
    host = deflections(places, accelerations(states, rates, assembly))[:, list(places.plane_of_ball)]
    speed, change = states[:, SPEED, None], rates[:, SPEED, None]
    angle, slip = states[:, BALLS : BALLS + n], states[:, BALLS + n : BALLS + 2 * n]
    outward = np.exp(-1j * (states[:, THETA, None] + angle))
    orbit = np.array([ball.orbit_radius for ball in balls])
    center = np.array([ball.eccentricity for ball in balls]) * (1j * change - speed**2) * np.exp(-1j * angle)
    felt = ((host + 1j * _gravity(places)) * outward + center).real - orbit * (speed + slip) ** 2
    return np.asarray(-np.array([ball.effective_mass for ball in balls]) * felt, np.float64)


def _gravity(places: Places) -> float:
    """Along -y, m/s^2."""
    return float(places.machine.gravity) if places.machine.axis == "horizontal" else 0.0


def left_race(times: Floats, states: Matrix, run: dict[str, Any], assembly: Assembly, places: Places) -> dict[str, Any]:
    """Attributes where the race had to pull at a guided ball, which it cannot: first ball, its time, when the last one
    is back to stay, and a sentence.

    A pull of less than a hundredth of the ball's weight is none: so much do balls feel on a rotor at standstill. Plain
    races are asked on a horizontal axis only, where the weight can take balls off.
    """
    if "ball_normal_force" in run and "ball_at_rest" in run:
        force = run["ball_normal_force"][1]
    elif (
        assembly.resolved
        or not (assembly.balls and times.size and _gravity(places))
        or places.machine.tilting_races == "full"
    ):
        return {}
    else:
        force = wall_forces(states, times, assembly, places)
    weight = STANDARD_GRAVITY * np.array([ball.effective_mass for ball in assembly.balls])
    pulled = force < -0.01 * weight
    if not pulled.any():
        return {}
    rows = np.flatnonzero(pulled.any(axis=1))
    when, last = int(rows[0]), int(rows[-1])
    ball, count = int(np.argmax(pulled[when])) + 1, int(pulled.any(axis=0).sum())
    pressed = np.flatnonzero(force[:when, ball - 1] >= 0.0)
    time = float(times[pressed[-1] + 1 if pressed.size else 0])
    back = np.flatnonzero((force[last:][:, pulled[last]] >= 0.0).all(axis=1))
    after = float(times[last + back[0] if back.size else -1])
    until = "to the end of the run" if not back.size else f"to {after:.5g} s"
    text = (
        f"from {time:.5g} s {until}, {count} {'ball' if count == 1 else 'balls'} (first ball {ball}) would have left the race "
        "at times: the normal force is negative. Guided balls cannot leave it; simulate with 'resolved' balls to see it"
    )
    return {"left_race_ball": ball, "left_race_time": time, "left_race_end": after, "left_race_text": text}

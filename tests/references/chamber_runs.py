"""Runs of a deep chamber that are made up of known motions, in the form of simulated ones."""

from __future__ import annotations

import numpy as np

from autobalancer.simulation.chamber.chamber_run import ChamberRun

AXES = ["x", "y", "z"]
MACHINE = 'name = "made up"\n'
SPEED = 157.0
CHAMBER, BALL = 0.1, 0.01


def chamber_run(
    duration: float = 4.0,
    *,
    angles: tuple[float, ...] = (2.6, 3.0, 3.4),
    axial: tuple[float, ...] = (-0.02, 0.0, 0.03),
    settled: float = 2.0,
    amplitude: float = 20e-6,
    peak: float = 2e-3,
    step: float = 1e-3,
    carried: bool = True,
) -> ChamberRun:
    """Balls that swing to ``angles`` (rad, in the rotor) and ``axial`` places (m), at rest there from ``settled`` (s) on.

    The body vibrates vertically with ``amplitude`` (m), in the transient with up to ``peak``; horizontally with half of
    it, and turns with 1e-5 rad. With ``carried`` false the balls stay at the bottom.
    """
    time = step * np.arange(round(duration / step) + 1)
    angle = np.unwrap(SPEED * time)
    n = len(angles)
    early = np.clip(1.0 - time / settled, 0.0, None)
    place = np.zeros((time.size, n, 3))
    velocity = np.zeros_like(place)
    radius = CHAMBER - BALL
    for i, (where, along) in enumerate(zip(angles, axial, strict=True)):
        turned = angle + where + 2.0 * early if carried else np.full_like(time, -0.5 * np.pi)
        place[:, i] = np.stack([along * (1.0 - early), radius * np.cos(turned), radius * np.sin(turned)], axis=1)
        speed = np.gradient(turned, time)
        velocity[:, i] = np.stack([0.0 * time, -speed * place[:, i, 2], speed * place[:, i, 1]], axis=1)
    burst = peak * np.exp(-(((time - 0.5 * settled) / 0.1) ** 2))
    body = np.stack([0.0 * time, 0.5 * amplitude * np.cos(angle), amplitude * np.sin(angle) + burst - 1e-4], axis=1)
    rotation = np.stack([1e-5 * np.sin(angle), 0.0 * time, 0.0 * time], axis=1)
    bearing = np.zeros((time.size, 2, 3))
    bearing[:, :, 2] = -500.0
    bearing[:, 0, 1] = 100.0 * np.cos(angle)
    force, moment = np.zeros((time.size, 3)), np.zeros((time.size, 3))
    force[:, 0] = 50.0 * early * np.sin(300.0 * time)
    moment[:, 1], moment[:, 2] = 5.0 * early, -2.0 * early
    hits = np.where(early > 0.0, 2, 0)
    moving = 0.5 * np.cumsum(early) * step
    per_time = {
        "rotor_angle": angle,
        "speed": np.full_like(time, SPEED),
        "contacts_ball": hits,
        "contacts_wall": 3 * hits,
        "greatest_contact_force": 10.0 + 100.0 * early,
        "energy_kinetic": 100.0 * (1.0 - early),
        "energy_potential": 0.1 * np.sin(time),
        "energy_contact": 0.0 * time,
        "work_motor": 100.0 * (1.0 - early) + 0.1 * np.sin(time) + 5.0 * moving,
        "loss_contact": moving,
        "loss_friction": moving,
        "loss_rolling": moving,
        "loss_supports": moving,
        "loss_bearings": moving,
        "energy_error": 1e-6 * time,
    }
    return ChamberRun(
        {
            **{name: ("time", np.asarray(values, float)) for name, values in per_time.items()},
            "body_position": (("time", "axis"), body),
            "body_rotation": (("time", "axis"), rotation),
            "ball_position": (("time", "ball", "axis"), place),
            "ball_velocity": (("time", "ball", "axis"), velocity),
            "ball_spin": (("time", "ball", "axis"), 0.0 * place),
            "bearing_force": (("time", "bearing", "axis"), bearing),
            "constraint_force": (("time", "axis"), force),
            "constraint_moment": (("time", "axis"), moment),
        },
        coords={
            "time": time,
            "ball": np.arange(1, n + 1),
            "axis": AXES,
            "bearing": [1, 2],
            "ball_radius": ("ball", np.full(n, BALL)),
            "ball_mass": ("ball", np.full(n, 0.03)),
            "chamber": ("ball", np.ones(n, int)),
        },
        attrs={
            "machine": MACHINE,
            "machine_name": "made up",
            "step": 1e-6,
            "seed": 0,
            "outcome": "finished",
            "outcome_text": "reached the end",
            "duration": duration,
            "source": "autobalancer made up",
        },
    )

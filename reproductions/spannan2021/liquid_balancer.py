"""Fluid alone as a balancer: the outlook of the thesis calls its balancing potential lower than that of balls."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import autobalancer as ab
from autobalancer.machine import Balancer, Machine
from autobalancer.plots.style import save_picture
from reproductions import Found, compared_all

SPEED = 100.0  # rad/s, four times the critical speed of the drum


def reproduce(out: Path) -> list[dict[str, Any]]:
    """What liquid leaves of the deflection of a drum, and what balls of a sixth of its mass leave."""
    drum = ab.example("liquid_ring")
    liquid = ab.rotor.liquid_response(drum, np.linspace(12.0, 105.0, 300))
    save_picture(ab.plot.answer(liquid), out / "liquid_balancer.png")
    left = float(ab.rotor.liquid_response(drum, [SPEED])["deflection"][0])
    race = {
        "orbit_radius": "240 mm",
        "drag": {"law": "viscous", "damping": "0.2 N*m*s"},
        "balls": [{"count": 2, "diameter": "42 mm", "density": "7800 kg/m^3"}],
    }
    parts = {key: getattr(drum, key) for key in ("name", "axis", "rotor", "unbalances", "drive")}
    balls = Machine(**parts, balancers=[Balancer(races=[race])])
    stepped = ab.stepped_response(balls, [SPEED], dwell=30.0, window=4.0, progress=False)
    by_balls = float(stepped["amplitude"][0])
    note = f"a sample drum, the thesis names none: liquid leaves {1e3 * left:.2f} mm, balls {1e3 * by_balls:.1g} mm"
    quantity = "a fluid balancer balances less than balls do: leaves more"
    return compared_all(
        "Spannan 2021", "section 7.1", [Found("words", quantity, "yes", 1.0, float(left > by_balls), 0.0, note)]
    )

"""A mass on rubber that softens with the amplitude, written down once more: complex numbers, no kernels."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

MASS = 12.27
CHAIN = ((9432.0, 0.03e-3), (4211.0, 0.1e-3), (4293.0, 0.3e-3), (5481.0, 1e-3), (5621.0, 3e-3))
ELASTIC, VISCOUS = 25325.0, 20.6
MAXWELL = ((3000.0, 4e-3), (2000.0, 40e-3))


def described(law: str = "elastoplastic", maxwell: bool = False, share: float = 1.0) -> dict[str, Any]:
    """The same as keys of a machine file; a ``share`` of it is one of several side by side."""
    found: dict[str, Any] = {
        "stiffness": share * ELASTIC,
        "damping": share * VISCOUS,
        "friction": {
            "law": law,
            "breakaway_amplitude": [a for _, a in CHAIN],
            "stiffness": [share * k for k, _ in CHAIN],
        },
    }
    if maxwell:
        found["maxwell"] = {
            "relaxation_time": [tau for _, tau in MAXWELL],
            "stiffness": [share * k for k, _ in MAXWELL],
        }
    return found


def free_motion(velocity: complex, times: np.ndarray, law: str = "elastoplastic", maxwell: bool = False) -> Any:
    """Deflection, velocity, stored energy and energy lost after a blow, at these times."""
    count = len(CHAIN)
    k, a = np.array([one for one, _ in CHAIN]), np.array([one for _, one in CHAIN])
    km, tau = np.array([one for one, _ in MAXWELL]), np.array([one for _, one in MAXWELL])
    if not maxwell:
        km = 0.0 * km

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        z, v, f, g = y[0], y[1], y[2 : 2 + count], y[2 + count : -1]
        if law == "elastoplastic":
            give = np.maximum((f.conj() * v).real, 0.0) / (k * a**2)
        else:
            give = abs(v) / a
        force = ELASTIC * z + VISCOUS * v + f.sum() + g.sum()
        lost = VISCOUS * abs(v) ** 2 + (give * np.abs(f) ** 2 / k).sum()
        if maxwell:
            lost += (np.abs(g) ** 2 / (km * tau)).sum()
        return np.concatenate([[v, -force / MASS], k * v - give * f, km * v - g / tau, [lost]])

    start = np.zeros(3 + count + len(MAXWELL), np.complex128)
    start[1] = velocity
    found = solve_ivp(rates, (0.0, times[-1]), start, "DOP853", times, rtol=1e-12, atol=1e-14)
    z, v, f, g = found.y[0], found.y[1], found.y[2 : 2 + count], found.y[2 + count : -1]
    stored = 0.5 * MASS * np.abs(v) ** 2 + 0.5 * ELASTIC * np.abs(z) ** 2 + (np.abs(f.T) ** 2 / (2.0 * k)).sum(1)
    if maxwell:
        stored = stored + (np.abs(g.T) ** 2 / (2.0 * km)).sum(1)
    return z, v, stored, found.y[-1].real

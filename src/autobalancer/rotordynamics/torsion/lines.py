"""Torsional natural frequencies as lines of a Campbell diagram."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from autobalancer.assembly.torsion.model import torsion_of
from autobalancer.machine import Machine
from autobalancer.rotordynamics.torsion.eigenproblem import shape_name, undamped_torsion


def torsional_lines(machine: Machine, harmonics: Sequence[float], first: float, last: float) -> dict[str, Any]:
    """Variables of a diagram: frequencies without damping, the same at all speeds, and where they meet multiples of the speed."""
    model = torsion_of(machine)
    rates, shapes = undamped_torsion(model)
    names = [shape_name(model.names, shape) for shape in shapes]
    met = sorted((rate / h, h) for rate in rates for h in harmonics if first <= rate / h <= last)
    at = "torsional_intersection"
    return {
        "torsional_frequency": ("torsion", rates, {"long_name": "torsional natural frequency", "units": "rad/s"}),
        "torsional_name": ("torsion", np.array(names, dtype=object), {"long_name": "name of the torsional mode"}),
        f"{at}_speed": (at, np.array([w for w, _ in met]), {"long_name": "where torsion meets it", "units": "rad/s"}),
        f"{at}_harmonic": (at, np.array([h for _, h in met]), {"long_name": "frequency over speed"}),
    }

"""Which candidate comes next: from the ranges, or from the better ones by small changes and by mixing two."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from reproductions.pakula2021.lost.candidate import NAMES, SPEEDS, Candidate

RANGES = {  # least and greatest, drawn evenly in the logarithm
    "unbalance": (0.05, 0.2),
    "ball_mass": (1.2, 4.0),
    "density": (5000.0, 19000.0),
    "radius": (0.07, 0.15),
    "rolling_arm": (1e-6, 3e-4),
    "between": (0.1, 2.0),
    "torque": (4.0, 60.0),
    "overload": (1.8, 3.2),
    "slip": (0.1, 0.5),
    "rotor_inertia": (0.05, 1.5),
    "half_span": (0.3, 1.0),
    "below": (0.05, 0.3),
    "body_below": (0.05, 0.3),
    "body_inertia": (8.0, 30.0),
}
STEEL = 7800.0


def anywhere(random: np.random.Generator) -> Candidate:
    """From all of the ranges; every second one of steel and with one friction."""
    numbers: dict[str, Any] = {
        name: math.exp(random.uniform(math.log(low), math.log(high))) for name, (low, high) in RANGES.items()
    }
    if random.random() < 0.5:
        numbers["density"] = STEEL
    if random.random() < 0.5:
        numbers["between"] = 1.0
    numbers["speed"] = float(random.choice(SPEEDS, p=[0.15, 0.7, 0.15]))
    numbers["supports"] = float(random.choice([1.0, 2.0]))
    return _rounded(numbers)


def near(random: np.random.Generator, parents: Sequence[Candidate]) -> Candidate:
    """One of ``parents``, or a mixture of two, with one to four numbers changed."""
    one, two = (parents[int(random.integers(len(parents)))] for _ in range(2))
    mixed = random.random() < 0.3
    numbers: dict[str, Any] = {name: getattr(two if mixed and random.random() < 0.5 else one, name) for name in NAMES}
    size = float(random.choice([0.06, 0.15, 0.35]))
    for name in random.choice(list(RANGES), size=int(random.integers(1, 5)), replace=False):
        low, high = RANGES[name]
        numbers[name] = min(max(numbers[name] * math.exp(size * random.normal()), low), high)
    if random.random() < 0.1:
        numbers["supports"] = 3.0 - numbers["supports"]
    if random.random() < 0.05:
        numbers["density"] = STEEL
    if random.random() < 0.05:
        numbers["between"] = 1.0
    return _rounded(numbers)


def _rounded(numbers: dict[str, Any]) -> Candidate:
    """Four digits, so that a table of candidates is the candidates."""
    return replace(
        Candidate(), **{name: float(f"{value:.4g}") if name != "speed" else value for name, value in numbers.items()}
    )

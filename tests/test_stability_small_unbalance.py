"""Balls and unbalance that are small beside the rotor: what counts is their ratio, not their size."""

from __future__ import annotations

import math

import numpy as np
import pytest

from autobalancer.machine import Machine
from autobalancer.stability.maps.balanced import balanced_states
from autobalancer.stability.maps.exact import _edge, stable_windows
from autobalancer.stability.states.rest_states import described


def two_planes(share: float) -> Machine:
    """Rotor of 5 kg on anisotropic supports; balls, drag and unbalance all go with ``share``, the mass of a ball over its own."""
    ball, orbit = 5.0 * share, 0.05
    race = {"orbit_radius": orbit, "drag": {"law": "viscous", "damping": 8.0 * ball * orbit**2}}
    race["balls"] = [{"count": 2, "mass": ball, "motion": "point"}]
    return Machine.model_validate(
        {
            "name": "two planes",
            "axis": "vertical",
            "rotor": {
                "kind": "rigid",
                "mass": 5.0,
                "transverse_inertia": 0.05,
                "polar_inertia": 0.015,
                "supports": [
                    {"position": -0.12, "stiffness": [25e3, 20e3], "damping": 40.0},
                    {"position": 0.10, "stiffness": [22e3, 17.6e3], "damping": 35.0},
                ],
            },
            "stations": [{"name": "a", "position": -0.10}, {"name": "b", "position": 0.15}],
            "unbalances": [
                {"moment": 0.9 * ball * orbit, "angle": 0.3, "station": 0.02},
                {"moment": 0.6 * ball * orbit, "angle": 2.0, "station": -0.10},
            ],
            "balancers": [{"station": station, "races": [race]} for station in "ab"],
            "drive": {"kind": "speed", "profile": {"kind": "constant", "speed": 400.0}},
        }
    )


def test_growth_rates_on_anisotropic_supports_go_with_the_balls_down_to_the_smallest() -> None:
    """Of light balls the rates are those of the averaged theory, in proportion to the mass of the balls."""
    speeds = np.linspace(20.0, 600.0, 13)
    ratios = []
    for share in (1e-6, 1e-8):
        machine = two_planes(share)
        (state,) = balanced_states(described(machine, None, 600.0))
        ratios.append(state.rates(speeds) / share)
    assert np.isfinite(ratios).all()
    np.testing.assert_allclose(ratios[0], ratios[1], rtol=5e-3)


def test_stable_speeds_on_anisotropic_supports_have_a_limit_for_ever_lighter_balls() -> None:
    borders = []
    for share in (1e-5, 1e-6, 1e-7):
        found = stable_windows(two_planes(share), 600.0)
        assert len(found.windows) == 1, found.note
        borders.append(found.windows[0][0])
    first, second = np.diff(borders)
    assert second / first == pytest.approx(0.1, abs=0.02)  # the first order in the mass of the balls
    assert borders[-1] == pytest.approx(122.5, abs=0.1)


def test_the_edge_of_a_stable_range_is_found_beside_speeds_without_a_state() -> None:
    def rate(speed: float) -> float:
        return math.nan if 1.4 < speed < 1.9 else speed - 1.7

    assert _edge(rate, (1.0, 2.0), (-0.7, 0.3), None) == pytest.approx(1.4)

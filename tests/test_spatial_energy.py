"""Energy and angular momentum of a rotor that tilts while balls run in its races."""

from __future__ import annotations

import numpy as np
import pytest
from tests.references.spatial import Spatial, split
from tests.references.spatial_machines import states_of, tilting

from autobalancer.machine import Machine

TIMES = np.linspace(0.0, 3.0, 61)
both = pytest.mark.parametrize("races", ["deflection", "full"])


def kept(machine: Machine, quantity: str) -> np.ndarray:
    """Energy or angular momentum at all times."""
    reference = Spatial(machine)
    states = split(machine, states_of(machine, TIMES))
    assert np.ptp(states[:, 0, 5:], axis=0).min() > 3.0  # the balls really run
    return np.array([getattr(reference, quantity)(t, q, v) for t, (q, v) in zip(TIMES, states, strict=True)])


@both
@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
@pytest.mark.parametrize("isotropic", [True, False])
def test_energy_is_kept_by_a_tilting_rotor_that_spins_freely(races: str, axis: str, isotropic: bool) -> None:
    """The gyroscopic moments do no work while the speed itself reacts to tilt, unbalance and balls."""
    machine = tilting(isotropic=isotropic, damping=0.0, beta=0.0, axis=axis, tilting_races=races)
    energy = kept(machine, "energy")
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


@both
def test_energy_that_moves_between_tilt_and_balls_is_kept_to_a_billionth_of_the_part_that_moves(races: str) -> None:
    """The spin would hide errors; here the rotor stands still at first."""
    start = {"speed": 0.0, "deflection": [5e-4, 0.0], "velocity": [0.0, 0.1]}
    machine = tilting(damping=0.0, beta=0.0, tilting_races=races, start=start)
    states = split(machine, states_of(machine, TIMES))
    reference = Spatial(machine)
    energy = np.array([reference.energy(t, q, v) for t, (q, v) in zip(TIMES, states, strict=True)])
    np.testing.assert_allclose(energy, energy[0], rtol=1e-9)


@both
def test_angular_momentum_of_spin_whirl_and_balls_is_kept_on_isotropic_supports(races: str) -> None:
    machine = tilting(isotropic=True, damping=0.0, beta=1e-4, tilting_races=races)
    momentum = kept(machine, "angular_momentum")
    np.testing.assert_allclose(momentum, momentum[0], rtol=1e-10)


@both
def test_angular_momentum_is_not_kept_on_unequal_supports(races: str) -> None:
    momentum = kept(tilting(damping=0.0, beta=0.0, tilting_races=races), "angular_momentum")
    assert np.ptp(momentum) > 1e-6 * abs(momentum[0])


def test_damping_lets_the_energy_only_fall() -> None:
    machine = tilting(damping=30.0, beta=3e-5, tilting_races="full", axis="horizontal")
    times = np.linspace(0.0, 1.0, 1001)
    states, reference = split(machine, states_of(machine, times)), Spatial(machine)
    energy = np.array([reference.energy(t, q, v) for t, (q, v) in zip(times, states, strict=True)])
    assert np.diff(energy).max() < 1e-12 * energy[0]
    assert energy[-1] < energy[0] - 1e-2

"""Balls on real races that tilt: friction, waves, drag and excitation together with the full motion of the race."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import simpson
from tests.references.race_runs import states_from
from tests.references.spatial import joined, split
from tests.references.spatial_machines import rates, states_of, tilting
from tests.references.spatial_races import SpatialRaces

import autobalancer as ab
from autobalancer.assembly.system import Assembly, assemble
from autobalancer.machine import Machine

WAVES = [{"order": k, "amplitude": a, "angle": 0.7 * k} for k, a in ((1, 6e-4), (2, 1e-3), (3, -5e-4))]
FREE = {"kind": "torque", "torque": 0.0}
OIL = {"density": 900.0, "viscosity": 2e-5}


def rough(change: dict[str, Any] | None = None, **top: Any) -> Machine:
    """The rotor with balls at two stations, whose races are not round and rub."""
    race = {"harmonics": WAVES, "friction": {"rolling_resistance": 0.02}} if change is None else change
    machine = tilting(**{"tilting_races": "full", "drive": FREE, **top})
    for b in (1, 2):
        for key, value in race.items():
            machine = ab.with_parameter(machine, f"balancers[{b}].races[1].{key}", value)
    return machine


def random_place(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """q and q' with slopes of a hundredth."""
    lateral = np.array([1e-3, 1e-2] * 2)
    q = np.concatenate([random.normal(size=4) * lateral, random.uniform(-4.0, 4.0, 5)])
    return q, np.concatenate([random.normal(size=4) * 100.0 * lateral, [220.0], random.normal(size=4) * 60.0])


def seen(assembly: Assembly, machine: Machine, q: np.ndarray, v: np.ndarray, time: float = 0.0) -> np.ndarray:
    """q'' by the compiled equations, every ball rolling the way it moves."""
    assembly.system.guided.mode = np.sign(v[5:])
    return np.asarray(split(machine, rates(assembly, time, joined(machine, q, v))[None])[0, 1])


@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
@pytest.mark.parametrize("drive", ["torque", "ramp"])
def test_accelerations_and_normal_forces_are_those_of_the_lagrangian_in_space(axis: str, drive: str) -> None:
    ramp = {"kind": "speed", "profile": {"kind": "ramp", "start": 100.0, "end": 400.0, "duration": 1.0}}
    machine = rough(axis=axis, drive=ramp if drive == "ramp" else FREE | {"torque": 3.0})
    assembly, reference, random = assemble(machine, rotating=False), SpatialRaces(machine), np.random.default_rng(5)
    for _ in range(5):
        q, v = random_place(random)
        expected, normal = reference.accelerations(q, v, 300.0 if drive == "ramp" else None)
        assert normal.min() > 0.0
        found = seen(assembly, machine, q, v, 0.4)
        for group in ([0, 2], [1, 3], [4], [5, 6, 7, 8]):
            scale = np.abs(expected[group]).max()
            np.testing.assert_allclose(found[group], expected[group], rtol=0.0, atol=1e-11 * scale)
        np.testing.assert_allclose(assembly.system.guided.normal, normal, rtol=1e-10)


def test_the_tilt_is_part_of_the_normal_force() -> None:
    """Else the test above would not see it."""
    full, flat = rough(), rough(tilting_races="deflection")
    q, v = random_place(np.random.default_rng(1))
    forces = []
    for machine in (full, flat):
        assembly = assemble(machine, rotating=False)
        seen(assembly, machine, q, v)
        forces.append(assembly.system.guided.normal.copy())
    assert np.abs(forces[0] / forces[1] - 1.0).max() > 3e-5


@pytest.mark.parametrize("axis", ["vertical", "horizontal"])
def test_without_dissipation_waves_and_tilt_keep_the_energy(axis: str) -> None:
    machine = rough({"harmonics": WAVES}, axis=axis, damping=0.0, beta=0.0)
    states = split(machine, states_of(machine, np.linspace(0.0, 1.0, 21)))
    assert np.ptp(states[:, 0, 5:], axis=0).min() > 0.5  # the balls really run
    energies = [SpatialRaces(machine).energy(q, v) for q, v in states]
    np.testing.assert_allclose(energies, energies[0], rtol=1e-9)


def test_what_rolling_resistance_takes_is_what_the_energy_loses() -> None:
    machine = rough(damping=0.0, beta=0.0)
    reference, assembly, times = SpatialRaces(machine), assemble(machine, rotating=False), np.linspace(0.0, 0.02, 61)
    n = len(assembly.balls)
    assembly.state[6 + n : 6 + 2 * n] = 60.0
    states = split(machine, states_from(assembly, times))
    lost = simpson([reference.power_rubbed(q, v) for q, v in states], times)
    energies = [reference.energy(q, v) for q, v in states]
    assert lost > 0.05
    assert energies[0] - energies[-1] == pytest.approx(lost, rel=1e-5)


@pytest.mark.parametrize(
    "change", [{"harmonics": [{"order": 2, "amplitude": 0.0}]}, {"friction": {"rolling_resistance": 1e-12}}]
)
def test_a_real_race_without_anything_real_tilts_as_a_plain_one(change: dict[str, Any]) -> None:
    times = np.linspace(0.0, 0.5, 11)
    plain, real = (
        states_of(m, times, tolerance=1e-12) for m in (tilting(tilting_races="full", drive=FREE), rough(change))
    )
    np.testing.assert_allclose(real, plain, rtol=1e-8, atol=1e-10)


def test_small_tilts_act_on_a_ball_with_their_square() -> None:
    """Without weight along the axis, on a rotor too heavy to answer."""
    heavy = {"mass": 5e8, "transverse_inertia": 6e6, "polar_inertia": 3.5e6}
    misses = []
    for size in (1e-3, 5e-4):
        found = []
        for races in ("full", "deflection"):
            machine = rough(tilting_races=races, gravity=0.0, drive=FREE)
            machine = machine.model_copy(update={"rotor": machine.rotor.model_copy(update=heavy)})
            q, v = random_place(np.random.default_rng(2))
            q[[1, 3]], v[[1, 3]] = size * np.array([1.0, -0.4]), 200.0 * size * np.array([0.3, 1.0])
            q[[0, 2]] = v[[0, 2]] = 0.0
            found.append(seen(assemble(machine, rotating=False), machine, q, v)[5:])
        misses.append(np.abs(found[0] - found[1]))
    np.testing.assert_allclose(misses[0] / misses[1], 4.0, rtol=1e-3)


def test_adherence_holds_a_ball_on_a_race_that_tilts_a_little_and_lets_go_where_it_tilts_more() -> None:
    """The race leans across the ball, whose weight pulls it down along the race."""
    hold = 1e-3 * 0.1 * 20.0**2 / 9.80665  # adherence times centrifugal force over weight
    for slope, rests in ((0.9 * hold, True), (1.1 * hold, False)):
        states = states_from(leaning(slope), np.array([0.0, 1e-3]))
        assert bool(states[-1, 7] == 0.0) is rests


def leaning(slope: float) -> Assembly:
    """One ball on a rotor too heavy to move, whose races lean along x, pressed on the wall by a fast spin."""
    machine = Machine(
        name="leaning",
        axis="vertical",
        rotor={
            "kind": "rigid",
            "mass": 1e9,
            "transverse_inertia": 1e9,
            "polar_inertia": 1e-3,
            "supports": [{"position": z, "stiffness": 1.0, "damping": 0.0} for z in (-0.1, 0.1)],
        },
        balancers=[
            {
                "station": 0.0,
                "races": [
                    {
                        "orbit_radius": 0.1,
                        "drag": {"law": "viscous", "damping": 0.0},
                        "friction": {"rolling_resistance": 1e-3, "adherence": 1e-3},
                        "balls": [{"count": 1, "mass": 5e-3, "diameter": 0.01, "start_angles": [0.0]}],
                    }
                ],
            }
        ],
        tilting_races="full",
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 20.0}},
    )
    assembly = assemble(machine, rotating=False)
    q = np.array([0.0, slope, 0.0, 0.0, 0.0, 0.5 * np.pi])
    assembly.state[:] = joined(machine, q, np.array([0.0, 0.0, 0.0, 0.0, 20.0, 0.0]))
    return assembly


def test_a_run_with_all_of_it_says_who_rests_and_how_hard_each_is_pressed() -> None:
    """Friction, a lagging oil, a wavy race and a base that shakes, on races that tilt."""
    shake = {"kind": "base_motion", "acceleration": 0.5, "frequency": 150.0, "direction": 0.4}
    race = {"harmonics": WAVES, "friction": {"rolling_resistance": 0.002, "adherence": 0.003}, "fluid": OIL}
    machine = rough(race, excitations=[shake])
    run = ab.simulate(machine, duration=0.05)
    assert run.attrs["outcome"] == "finished"
    assert (run["ball_normal_force"].values > 0.0).all()
    calm = ab.simulate(machine.model_copy(update={"excitations": ()}), duration=0.05)
    assert np.abs(run["x"].values - calm["x"].values).max() > 1e-6

"""Stability of balls on a shaft that bends."""

from __future__ import annotations

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rotors.reduction import AIM, Answers
from autobalancer.assembly.system import assemble
from autobalancer.machine import (
    Balancer,
    Balls,
    Constant,
    Disk,
    Machine,
    PrescribedSpeed,
    Race,
    RigidRotor,
    ShaftMaterial,
    ShaftRotor,
    ShaftSegment,
    Support,
    Unbalance,
    ViscousDrag,
)
from autobalancer.stability.host.reduction import basis_for, reduced
from autobalancer.stability.host.stations import Stations, stations
from autobalancer.stability.states.linearized import eigensystem
from autobalancer.stability.states.linearized import matrices as station_matrices
from autobalancer.stability.states.rest_states import balanced_of

PLACES = (0.15, 0.45)
SUPPORTS = tuple(Support(position=z, stiffness=2e4, damping=20.0) for z in (0.05, 0.55))


def machine(rotor: ShaftRotor | RigidRotor, shift: float = 0.0) -> Machine:
    """Two planes with two balls each; ``shift`` is the origin of the rotor's axis."""
    balls = Race(orbit_radius=0.05, drag=ViscousDrag(damping=3e-4), balls=(Balls(count=2, mass=0.004, motion="point"),))
    return Machine(
        name="shaft",
        axis="vertical",
        rotor=rotor,
        unbalances=(
            Unbalance(moment=1e-4, angle=0.4, station=0.2 - shift),
            Unbalance(moment=5e-5, station=0.5 - shift),
        ),
        balancers=tuple(Balancer(station=z - shift, races=(balls,)) for z in PLACES),
        drive=PrescribedSpeed(profile=Constant(speed=300.0)),
    )


def shaft(modulus: float, elements: int = 4) -> ShaftRotor:
    """A uniform shaft with two disks."""
    return ShaftRotor(
        material=ShaftMaterial(density=7800.0, youngs_modulus=modulus, poisson_ratio=0.3),
        segments=tuple(ShaftSegment(length=0.6 / elements, diameter=0.03) for _ in range(elements)),
        disks=tuple(
            Disk(name=f"disk {i}", position=z, mass=2.0, transverse_inertia=2e-3, polar_inertia=3e-3)
            for i, z in enumerate(PLACES)
        ),
        supports=SUPPORTS,
    )


def leading(st: Stations, speed: float) -> np.ndarray:
    """Greatest real parts of the balanced state among motions slow enough to matter, which high bending modes are not."""
    values, _ = eigensystem(*station_matrices(st, speed, balanced_of(st, speed)[0]))
    return values.real[np.abs(values.imag) < 6000.0][:4]


def test_a_stiff_shaft_has_the_stability_of_the_rigid_rotor_with_its_mass_and_inertias() -> None:
    """What is left falls with the modulus, but for its square and the rounding of a matrix with high bending modes, of 1e-5.

    That rounding differs between linear algebra libraries; with a still stiffer shaft it is all there is.
    """
    soft, stiff = from_rigid(6e11), from_rigid(2.1e12)
    assert 1e-4 < np.abs(soft).min() < np.abs(soft).max() < 5e-3
    np.testing.assert_allclose(stiff, soft * 6.0 / 21.0, rtol=0.0, atol=1.2e-5)


def from_rigid(modulus: float) -> np.ndarray:
    """By which share critical speeds and leading real parts of the shaft differ from those of the rigid rotor."""
    stiff = stations(machine(shaft(modulus)))
    n = stiff.model.pairs
    m = stiff.model.mass[:n, :n] - stiff.rows.T @ stiff.rows * 0.008
    model = lateral_model(machine(shaft(modulus)))
    at, ahead = model.axis.rows(0.0, None), model.axis.rows(0.6, None)
    # rigid motions of the shaft: all nodes moved alike, all turned about the left end
    shapes = np.column_stack([rigid_motion(model, at.deflection, ahead.deflection, kind) for kind in ("move", "tilt")])
    whole = shapes.T @ m @ shapes
    spin = -shapes.T @ model.gyroscopic[:n, n : 2 * n] @ shapes
    center = whole[0, 1] / whole[0, 0]
    rotor = RigidRotor(
        mass=whole[0, 0],
        transverse_inertia=whole[1, 1] - whole[0, 0] * center**2,
        polar_inertia=abs(spin[1, 1]),
        supports=tuple(s.model_copy(update={"position": s.position - center}) for s in SUPPORTS),
    )
    rigid = stations(machine(rotor, center))
    ratios = [np.array(stiff.critical_speeds[:2]) / rigid.critical_speeds]
    ratios += [leading(stiff, speed)[:2] / leading(rigid, speed)[:2] for speed in (150.0, 400.0)]
    return np.concatenate(ratios) - 1.0


def rigid_motion(model: object, left: np.ndarray, right: np.ndarray, kind: str) -> np.ndarray:
    """Coordinates of a rigid motion: the soft direction of a stiff shaft with these deflections at its ends."""
    ends = (1.0, 1.0) if kind == "move" else (0.0, 0.6)
    n = model.pairs  # type: ignore[attr-defined]
    k = model.stiffness[0][:n, :n]  # type: ignore[attr-defined]
    both = np.vstack([left, right])
    bordered = np.block([[k / np.abs(k).max(), both.T], [both, np.zeros((2, 2))]])
    return np.linalg.solve(bordered, np.concatenate([np.zeros(n), ends]))[:n]


def test_a_reduced_shaft_has_the_eigenvalues_of_the_whole_one_with_fewer_coordinates() -> None:
    whole = stations(machine(shaft(2.1e11)))
    small = reduced(whole, 2000.0)
    assert small.model.pairs < 0.7 * whole.model.pairs
    for speed in (60.0, 100.0, 300.0):
        assert np.allclose(leading(small, speed)[0], leading(whole, speed)[0], rtol=3e-7)
        one, other = balanced_of(small, speed)[0], balanced_of(whole, speed)[0]
        assert np.abs(np.exp(1j * one.angles) - np.exp(1j * other.angles)).max() < 1e-9


def receptance_error(st: Stations, basis: np.ndarray, top: float = 600.0) -> float:
    answers = Answers(st.model, st.rows, top)
    return answers.error_of(basis, answers.reduced(basis), st.load)


def test_runs_and_stability_reduce_a_shaft_by_one_criterion() -> None:
    m = machine(shaft(2.1e11))
    st = stations(m)
    basis = basis_for(st, 300.0)
    assert basis is not None
    both = np.zeros((st.model.size, 2 * basis.shape[1]))
    both[: st.model.pairs, : basis.shape[1]] = both[st.model.pairs : 2 * st.model.pairs, basis.shape[1] :] = basis
    error = receptance_error(st, basis)
    assert 0.0 < error <= AIM
    # forward and backward whirl are the ellipses of x and y in other axes
    assert receptance_error(st, both) == pytest.approx(error, rel=1e-6)
    small = assemble(m).reduction
    assert small is not None
    assert small.error <= AIM
    bad = basis[:, :1]
    assert receptance_error(st, bad) > AIM
    nothing = np.column_stack([basis, 0.0 * basis[:, 0]])  # the matrix of the reduced rotor is singular at every speed
    assert receptance_error(st, nothing) == np.inf


def test_two_planes_balance_a_shaft_above_its_rigid_speeds_but_not_just_above_its_bending_speed() -> None:
    st = stations(machine(shaft(2.1e11)))
    assert np.allclose(st.critical_speeds[:3], (73.76, 115.45, 2513.2), rtol=1e-3)
    rates = {speed: leading(st, speed)[0] for speed in (100.0, 300.0, 1500.0, 2540.0, 2900.0)}
    assert [speed for speed, rate in rates.items() if rate < 0.0] == [300.0, 1500.0, 2900.0]


def test_with_planes_that_are_not_those_of_the_unbalance_a_bent_shaft_is_not_left_without_vibration() -> None:
    m = machine(shaft(2.1e11))
    found = ab.stability.equilibria(m, 600.0)
    balanced = found.isel(state=0)
    assert str(balanced["name"].values) == "balanced"
    assert float(balanced["deflection_at_station"].max()) < 1e-12
    st = stations(m)
    whirl = st.coordinates(600.0, balanced["ball_angle_in_rotor"].values)
    assert np.abs(whirl).max() > 1e-8
    assert float(found["required_moment"][0]) != pytest.approx(
        float(ab.stability.equilibria(m, 200.0)["required_moment"][0]), rel=1e-3
    )

"""Exact stability on anisotropic supports of balls that feel the tilt of their race, or forces: states, multipliers, borders."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.references.spatial_machines import rates, tilting
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_quantity
from autobalancer.assembly.reduced_rotor import spatial_parts
from autobalancer.assembly.system import assemble
from autobalancer.catalog.resolve import resolve
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig
from autobalancer.kernels.system import BALLS, SPEED, THETA
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.simulation.record import Samples
from autobalancer.stability.host.stations import (
    Stations,
    in_plane,
    of_plane,
    plane,
    refuse_motion_along_the_axis,
    stations,
)
from autobalancer.stability.host.vector_field import Field
from autobalancer.stability.maps.balanced import balanced_states
from autobalancer.stability.states.linearized import exponents_of, in_mean, modes, swinging
from autobalancer.stability.states.rest_states import balanced_of, states_of

RACE = "balancers[1].races[1]"
RIG = ab.example("discoidal")
TWO_PLANES = ab.with_parameter(ab.example("two_plane_rotor"), "tilting_races", "full")


def springs(stiffness: float, along_y: float = 1.3, machine: Machine = RIG) -> Machine:
    """The planar rig with springs along its race (N/m), and so many times as stiff along y as along x."""
    assert isinstance(machine.rotor, PlanarRotor)
    along_x = machine.rotor.stiffness
    uneven = ab.with_parameter(machine, "rotor.stiffness", (along_x, along_y * along_x))  # type: ignore[operator]
    forces = [{"kind": "race_springs", "stiffness": stiffness}] if stiffness else []
    return ab.with_parameter(uneven, f"{RACE}.forces", forces)


def full(along_y: float, form: str = "full") -> Machine:
    """Two planes on a rigid rotor, so many times as stiff along y as along x, in the full motion."""
    supports = [
        {"position": at, "stiffness": [2e4, 2e4 * along_y], "damping": 20.0}
        for at in (support.position for support in TWO_PLANES.rotor.supports)  # type: ignore[union-attr]
    ]
    return ab.with_parameter(ab.with_parameter(TWO_PLANES, "rotor.supports", supports), "tilting_races", form)


def compiled(machine: Machine, theta: float, speed: float, state: np.ndarray) -> np.ndarray:
    """The compiled equations in space at a state of the vector field and a rotor angle, turned into the frame of the rotor."""
    assembly = assemble(machine, contact=False)
    assert not assembly.system.rotating
    basis, balls = spatial_parts(machine, resolve(machine)).reduction.basis, len(assembly.balls)
    half, rest = basis.shape[0], BALLS + 2 * balls
    places = [[0, 1, *range(rest, rest + half - 2)], [2, 3, *range(rest + half - 2, rest + 2 * half - 4)]]
    y = np.zeros_like(assembly.state)
    y[THETA], y[SPEED], y[BALLS:rest] = theta, speed, state[2 * half :]
    parts, turn = half // 2, np.exp(1j * theta)
    for where, part in zip(places, np.split(state[: 2 * half], 2), strict=True):
        z = (part[:parts] + 1j * part[parts:]) * turn
        y[where] = np.linalg.solve(basis, np.concatenate([z.real, z.imag]))
    dy = rates(assembly, 0.0, y)
    found = []
    for where, part in zip(places, np.split(state[: 2 * half], 2), strict=True):
        space = basis @ dy[where]
        z = (space[:parts] + 1j * space[parts:]) / turn - 1j * speed * (part[:parts] + 1j * part[parts:])
        found += [z.real, z.imag]
    return np.concatenate([*found, dy[BALLS:rest]])


@pytest.mark.parametrize("theta", [0.0, 0.7, 2.5])
def test_the_vector_field_of_tilting_races_is_that_of_the_compiled_equations_at_any_rotor_angle(theta: float) -> None:
    speed = 400.0
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    machine = tilting(drive=drive, tilting_races="full")
    field, random = Field(stations(machine), speed, theta), np.random.default_rng(1)
    sizes = np.repeat([1e-2, 3.0, 2.0, 50.0], 4)
    for _ in range(3):
        state = sizes * random.normal(size=16)
        expected = compiled(machine, theta, speed, state)
        for ours, theirs in zip(np.split(field(state), 4), np.split(expected, 4), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=1e-11 * np.abs(theirs).max())


def directions(st: Stations, angles: np.ndarray) -> np.ndarray:
    """Of the balls, those of a station in order: equal balls may change places."""
    found = np.exp(1j * angles)
    return np.concatenate([np.sort_complex(np.round(found[st.station == place], 9)) for place in range(len(st.names))])


def test_multipliers_of_supports_that_hardly_differ_are_those_of_the_eigenvalues_of_alike_ones() -> None:
    for hardly, alike, speed in (
        (stations(full(1.0 + 1e-8)), stations(full(1.0)), 190.0),
        (in_plane(springs(0.02, 1.0 + 1e-8)), in_plane(springs(0.02, 1.0)), 110.0),
    ):
        assert alike.isotropic
        assert not hardly.isotropic
        states = states_of(alike, speed)[:4]
        for guess, state in zip(states_of(hardly, speed), states, strict=False):
            mean = in_mean(hardly, speed, guess)
            np.testing.assert_allclose(directions(hardly, mean.angles), directions(alike, state.angles), atol=1e-5)
            np.testing.assert_allclose(mean.whirl, state.whirl, atol=1e-6 * np.abs(state.whirl).max() + 1e-12)
            found, half = exponents_of(hardly, speed, guess), math.pi / speed
            expected = np.exp(modes(alike, speed, state)[0] * half)
            for value in np.exp(found * half):
                assert np.abs(expected - value).min() < 1e-5


def lighter(share: float, form: str) -> Machine:
    """Two planes with balls, unbalances and drag of another size, which change together."""
    machine = full(1.3, form)
    for name, value in (("ball_mass", 4e-3), ("drag", 2e-4)):
        machine = with_quantity(machine, name, share * value)
    unbalances = tuple(
        u.model_copy(update={key: share * float(getattr(u, key)) for key in ("moment", "couple") if getattr(u, key)})
        for u in machine.unbalances
    )
    return machine.model_copy(update={"unbalances": unbalances, "gravity": 0.0})  # weight does not depend on the size


def test_the_lighter_the_balls_the_less_the_full_motion_differs_from_the_deflection() -> None:
    apart = []
    for share in (0.01, 1e-4):
        both = [stations(lighter(share, form)) for form in ("full", "deflection")]
        # one from the field over half a turn, the other from the harmonic balance
        found = [np.sort(exponents_of(st, 250.0, balanced_of(st, 250.0)[0]).real) for st in both]
        apart.append(np.abs(found[0] - found[1]).max())
    assert apart[0] > 1e-5
    assert apart[1] == pytest.approx(0.01 * apart[0], rel=0.01)


@pytest.mark.parametrize("form", ["deflection", "full"])
def test_a_shaft_whose_dampers_hardly_differ_has_the_growth_rate_of_alike_ones(form: str) -> None:
    shaft = ab.with_parameter(rig("cfrp_rig"), "tilting_races", form)
    hardly = ab.with_parameter(shaft, "rotor.supports[2].damping", (57.0 * 0.999, 57.0 * 1.001))  # the same mean
    assert not stations(hardly).isotropic
    assert stations(hardly).model.pairs > 40
    uneven, alike = (ab.stability.eigenvalues(one, [35.0]) for one in (hardly, shaft))
    assert float(uneven["growth_rate"][0]) == pytest.approx(float(alike["growth_rate"][0]), rel=1e-5)


def test_supports_that_change_places_have_the_same_states_and_multipliers() -> None:
    # the machine a quarter turn later; the mean of a state and its growth do not know where the turn began
    speed = 170.0
    one = full(1.4)
    other = ab.with_parameter(one, "rotor.supports", [_exchanged(support) for support in one.rotor.supports])  # type: ignore[union-attr]
    pair = stations(one), stations(other)
    for a, b in zip(*(states_of(st, speed)[:5] for st in pair), strict=True):
        first, second = in_mean(pair[0], speed, a), in_mean(pair[1], speed, b)
        np.testing.assert_allclose(directions(pair[0], first.angles), directions(pair[1], second.angles), atol=1e-7)
        np.testing.assert_allclose(first.whirl, second.whirl, atol=1e-12)
        np.testing.assert_allclose(
            *(np.sort(exponents_of(st, speed, s).real) for st, s in zip(pair, (a, b), strict=True)), atol=1e-6
        )


def _exchanged(support: Any) -> dict[str, Any]:
    return {"position": support.position, "stiffness": support.stiffness[::-1], "damping": support.damping}


def test_without_drag_and_damping_motions_come_in_pairs_that_grow_and_decay_alike() -> None:
    # the equations over half a turn are those of a Hamilton function that repeats
    speed = 400.0
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}
    machine = tilting(damping=0.0, beta=0.0, drive=drive, tilting_races="full")
    machine = ab.with_parameter(machine, f"{RACE}.forces", [{"kind": "race_springs", "stiffness": 0.5}])
    st, half = stations(machine), math.pi / speed
    states = balanced_of(st, speed)[:2]
    assert states
    for state in states:
        multipliers = np.exp(exponents_of(st, speed, state) * half)
        for value in multipliers:
            assert np.abs(multipliers - 1.0 / value).min() < 1e-6


def test_springs_that_vanish_leave_the_border_of_balls_without_them() -> None:
    (plain,) = ab.stability.borders(springs(0.0), only=("exact border",))  # from the harmonic balance
    apart = []
    for stiffness in (1e-4, 1e-5):
        (member,) = balanced_states(in_plane(springs(stiffness)))
        low, high = 0.999 * plain.speed, 1.0005 * plain.speed
        rates_there = member.rates(np.array([low, high]))
        assert rates_there[0] > 0.0 > rates_there[1]
        apart.append(float(np.interp(0.0, -rates_there, [low, high])) / plain.speed - 1.0)
    assert abs(apart[0]) < 5e-4
    assert abs(apart[1]) < 0.2 * abs(apart[0])


@pytest.mark.parametrize(("speed", "grows"), [(70.0, True), (74.0, False)])
def test_runs_on_both_sides_of_the_border_grow_and_decay_as_the_multipliers_say(speed: float, grows: bool) -> None:
    machine = springs(0.005)
    st, turn = in_plane(machine), 2.0 * math.pi / speed
    (member,) = balanced_states(st)
    (guess,) = member.states(speed)  # type: ignore[attr-defined]
    cycle, state = swinging(st, speed, guess.angles)
    begin = cycle.around(state)[0]
    for path, value in (
        ("drive", {"kind": "speed", "profile": {"kind": "constant", "speed": speed}}),
        ("start", {"deflection": begin[:2].tolist(), "velocity": begin[2:4].tolist()}),
        (f"{RACE}.balls[1].start_angles", (begin[4:6] + np.array([1e-6, 0.0])).tolist()),
        (f"{RACE}.balls[1].start_speeds", begin[6:].tolist()),
    ):
        machine = ab.with_parameter(machine, path, value)
    run = ab.simulate(machine, duration=130 * turn, save=(Samples(131),), tolerance=1e-12)
    way = run["ball_angle_in_rotor"].values[:, 0] - begin[4]
    assert np.abs(way).max() < 1e-4  # it stays near the periodic state
    there = way[80:]  # the slowest motion is left; two turns say what the third is
    solution = np.linalg.lstsq(np.column_stack([there[1:-1], there[:-2]]), there[2:], rcond=None)[0]
    found = np.log(np.abs(np.roots([1.0, *-solution])[0])) / turn
    rate = exponents_of(st, speed, guess)[0].real
    assert (rate > 0.0) == grows
    assert found == pytest.approx(rate, abs=0.02 * abs(rate))


@pytest.mark.parametrize(("speed", "turns", "close"), [(180.0, 60, 2e-3), (250.0, 250, 2e-5)])
def test_runs_of_two_planes_in_the_full_motion_grow_and_decay_as_the_multipliers_say(
    speed: float, turns: int, close: float
) -> None:
    machine, turn = full(1.3), 2.0 * math.pi / speed
    st, flat = stations(machine), stations(full(1.3, "deflection"))
    (state,) = balanced_of(st, speed)
    angles = in_mean(st, speed, state).angles + np.array([1e-5, 0.0, 0.0, 0.0])
    machine = ab.with_parameter(machine, "drive", {"kind": "speed", "profile": {"kind": "constant", "speed": speed}})
    for number, pair in enumerate(np.split(angles, 2), 1):
        machine = ab.with_parameter(machine, f"balancers[{number}].races[1].balls[1].start_angles", pair.tolist())
    run = ab.simulate(machine, duration=turns * turn, save=(Samples(turns + 1),), tolerance=1e-12)
    ways = np.diff(run["ball_angle_in_rotor"].values, axis=0)[turns // 2 :]
    # three turns say what the fourth is: three motions are left
    before = np.concatenate([np.column_stack([way[2:-1], way[1:-2], way[:-3]]) for way in ways.T])
    solution = np.linalg.lstsq(before, np.concatenate([way[3:] for way in ways.T]), rcond=None)[0]
    rates_there = np.log(np.roots([1.0, *-solution]).astype(complex)).real / turn
    rate, other = (exponents_of(one, speed, balanced_of(one, speed)[0])[0].real for one in (st, flat))
    found = rates_there[np.argmin(np.abs(rates_there - rate))]
    assert (found > 0.0) == (speed < 190.17)  # the exact border
    assert found == pytest.approx(rate, rel=close)
    assert abs(rate / other - 1.0) > 2.0 * close  # than the deflection alone would have it


def test_the_ends_of_starts_on_tilting_races_have_their_names() -> None:
    st = stations(full(1.3))
    found = ab.basin(full(1.3), 250.0, random=1, hold=3.0)
    assert list(found["plane"].values) == list(st.names)
    assert "failed" not in {str(found["end"].values[number]) for number in found["state"].values.ravel()}


def test_a_rotor_that_moves_along_its_axis_under_forces_across_it_is_refused_in_words() -> None:
    model = of_plane(plane(ab.example("discoidal"))).model
    wider = replace(
        model,
        mass=np.diag([*np.diag(model.mass), 1.0]),
        gyroscopic=np.zeros((3, 3)),
        damping=np.zeros((1, 3, 3)),
        stiffness=np.array([[[2e5, 0.0, 3e3], [0.0, 1e5, 0.0], [3e3, 0.0, 1e5]]]),
        coordinates=("x", "y", "z"),
    )
    with pytest.raises(QuestionError, match="also move it along or about the axis"):
        refuse_motion_along_the_axis(wider)
    refuse_motion_along_the_axis(replace(wider, stiffness=np.array([np.diag([2e5, 1e5, 1e5])])))


def test_the_command_line_answers_on_supports_that_differ(tmp_path: Path) -> None:
    file = tmp_path / "springs.toml"
    ab.save_machine(springs(0.005), file)
    answer = CliRunner().invoke(
        app, ["eigenvalues", str(file), "--speeds", "74 rad/s:75 rad/s:2"], env={"COLUMNS": "200"}
    )
    assert answer.exit_code == 0, answer.output
    assert "stable" in answer.output
    assert "ignores" not in answer.output

"""Balls that meet, partitions, and races of measured shape."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.references.race_runs import states_of
from tests.references.races import races
from tests.references.rates import rates_at
from tests.references.standing_races import BOTTOM, DENSITY, DIAMETER, ORBIT, standing

from autobalancer.assembly.guided_balls import race_harmonics
from autobalancer.assembly.quantities import with_value_at
from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError
from autobalancer.files.examples import rig
from autobalancer.kernels.balls.on_stations import guided_rough
from autobalancer.laws.impacts import damping_ratio, rebound
from autobalancer.machine import Contact, Friction, Machine, Race, Roundness
from autobalancer.studies.stepped_response import stepped_response

TOUCH = 2.0 * math.asin(0.5 * DIAMETER / ORBIT)


def _of_sizes(sizes: list[float], angles: list[float], speeds: list[float], **race: Any) -> Machine:
    balls = [
        {"diameter": d, "density": DENSITY, "start_angles": [BOTTOM + angle], "start_speeds": [speed]}
        for d, angle, speed in zip(sizes, angles, speeds, strict=True)
    ]
    return standing(axis="vertical", orbit_radius=None, race_radius=ORBIT + 0.5 * DIAMETER, balls=balls, **race)


@pytest.mark.parametrize("sizes", [[0.01, 0.01], [0.01, 0.02], [0.02, 0.01]])
@pytest.mark.parametrize("harmonics", [[], [{"order": 2, "amplitude": 1e-12}]])
@pytest.mark.parametrize("speeds", [[4.0, -2.0], [0.0, -3.0], [2.0, 0.0]])
@pytest.mark.parametrize(("restitution", "stiffness"), [(0.0, None), (0.3, None), (1.0, None), (0.0, 1e5), (0.8, 1e5)])
def test_two_balls_rebound_with_the_ratio_of_restitution(
    restitution: float,
    stiffness: float | None,
    speeds: list[float],
    harmonics: list[dict[str, float]],
    sizes: list[float],
) -> None:
    contact = {"restitution": restitution} | ({} if stiffness is None else {"stiffness": stiffness})
    machine = _of_sizes(sizes, [0.0, 0.5], speeds, contact=contact, harmonics=harmonics)
    found = states_of(machine, np.array([0.0, 0.6]), tolerance=1e-11)[-1]
    before, after = speeds[1] - speeds[0], found[9] - found[8]
    # of soft contacts the ratio is at least 0.01, and steps across corners of the force cost a millionth
    soft = stiffness is not None
    expected = -max(restitution, 0.01 if soft else 0.0) * before
    assert after == pytest.approx(expected, abs=(3e-6 if soft else 1e-9) * abs(before))
    one, other = (ball.inertia for ball in assemble(machine).balls)
    share = one / (one + other)
    mean = share * speeds[0] + (1.0 - share) * speeds[1]
    # momentum along the race, whose waves of 1e-11 of the radius change it by as much
    assert share * found[8] + (1.0 - share) * found[9] == pytest.approx(mean, abs=1e-9)


@pytest.mark.parametrize("stiffness", [None, 1e6])
def test_balls_of_any_size_rebound_from_partitions_and_beside_them_from_each_other(stiffness: float | None) -> None:
    """The first two meet in their sector, the third, of another size, meets its partition alone."""
    contact = {"restitution": 0.6} | ({} if stiffness is None else {"stiffness": stiffness})
    for sizes in ([0.01, 0.02, 0.006], [0.02, 0.01, 0.02], [0.006, 0.014, 0.01]):
        machine = _of_sizes(
            sizes, [0.6, 1.1, 3.6], [3.0, 1.0, -3.0], contact=contact, partitions={"count": 2, "angle": BOTTOM}
        )
        found = states_of(machine, np.array([0.0, 0.45]), tolerance=1e-11)[-1]
        assert found[10] - found[9] == pytest.approx(0.6 * 2.0, rel=3e-6)
        assert found[11] == pytest.approx(0.6 * 3.0, rel=3e-6)


def test_the_same_contact_seen_from_either_ball_is_the_mirror_image() -> None:
    times = np.linspace(0.0, 0.4, 401)
    for contact in (
        {"restitution": 0.3},
        {"restitution": 0.3, "friction": 0.3},
        {"restitution": 0.3, "stiffness": 1e5},
    ):
        one, other = (
            states_of(_of_sizes(sizes, angles, speeds, contact=contact), times)
            for sizes, angles, speeds in (
                ([0.01, 0.02], [-0.25, 0.25], [4.0, -1.0]),
                ([0.02, 0.01], [-0.25, 0.25], [1.0, -4.0]),
            )
        )
        np.testing.assert_allclose(one[:, [8, 9]], -other[:, [9, 8]], atol=1e-7)
        assert np.ptp(one[:, 8]) > 1.0


def test_the_damping_of_a_contact_gives_its_restitution_and_back() -> None:
    for restitution in (0.1, 0.5, 0.9, 0.999):
        assert rebound(damping_ratio(restitution)) == pytest.approx(restitution, rel=1e-12)
    assert damping_ratio(1.0) == 0.0


def test_balls_keep_their_order_however_often_they_meet() -> None:
    random = np.random.default_rng(4)
    angles = np.sort(random.uniform(-3.0, 3.0, 5)) + 0.02 * np.arange(5)
    speeds = random.uniform(-30.0, 30.0, 5)
    machine = standing(
        axis="vertical",
        angles=angles.tolist(),
        speeds=speeds.tolist(),
        contact={"restitution": 0.95},
    )
    found = states_of(machine, np.linspace(0.0, 5.0, 5001), tolerance=1e-9)
    gaps = np.diff(np.column_stack([found[:, 6:11], found[:, 6] + 2.0 * math.pi]), axis=1)
    assert TOUCH - 1e-10 < gaps.min() < TOUCH + 0.01
    assert np.ptp(found[:, 6]) > 0.5


@pytest.mark.parametrize("parts", ["contact", "adherence", "partitions", "waves"])
def test_runs_with_contacts_and_balls_at_rest_converge_with_the_tolerance(parts: str) -> None:
    """An instant that the stepper misses, or a force that it sees late, would leave an error that no tolerance makes small."""
    sticks = parts == "adherence"
    friction = Friction(rolling_resistance=5e-2 if sticks else 2e-3, adherence=0.3 if sticks else 4e-3)
    given: dict[str, Any] = {"contact": {"restitution": 0.6}} | ({} if parts == "waves" else {"friction": friction})
    if parts in ("partitions", "waves"):
        given["partitions"] = {"count": 3, "angle": 0.0}
    if parts == "waves":
        given["harmonics"] = [{"order": 3, "amplitude": 1e-5}]
    machine = standing(angles=[0.4, 2.0, 4.1], speeds=[12.0, -9.0, 6.0], **given)
    times = np.linspace(0.0, 1.5, 16)
    rough, fine, finest = (states_of(machine, times, tolerance=tolerance) for tolerance in (1e-7, 1e-11, 1e-13))
    assert np.ptp(finest[:, 6:9], axis=0).min() > 0.1
    assert (finest[-1, 9:12] == 0.0).all() == sticks
    at_fine, at_rough = (np.abs(found[:, 6:9] - finest[:, 6:9]).max() for found in (fine, rough))
    # impacts multiply what the tolerance leaves; flights below 1e-11 rad are not flown, whatever the tolerance
    assert at_rough < 1e-6
    assert at_fine < 1e-8


def test_balls_that_may_coincide_pass_through_each_other() -> None:
    machine = standing(axis="vertical", angles=[0.0, 0.5], speeds=[3.0, -3.0], collisions=False)
    found = states_of(machine, np.array([0.0, 0.5]))[-1]
    np.testing.assert_allclose(found[8:10], [3.0, -3.0], rtol=1e-9)
    assert found[6] > found[7]


@pytest.mark.parametrize("oval", [0.0, 1e-3])
def test_elastic_balls_on_a_horizontal_race_keep_their_energy(oval: float) -> None:
    machine = standing(
        angles=[-1.0, 0.8, 2.0],
        speeds=[3.0, 0.0, -5.0],
        contact={"restitution": 1.0},
        harmonics=[{"order": 2, "amplitude": oval, "angle": 0.7}, {"order": 3, "amplitude": 1e-12}],
    )
    reference, found = races(machine), states_of(machine, np.linspace(0.0, 3.0, 3001), tolerance=1e-12)
    energies = []
    for state in found[::10]:
        q, v = reference.split(state)
        q[:2] = v[:2] = 0.0
        energies.append(reference.energy(q, v))
    np.testing.assert_allclose(energies, energies[0], rtol=0.0, atol=1e-9 * np.abs(energies[0]))
    order = np.array([found[0, 9:12], found[-1, 9:12]])
    assert np.abs(order[1] - order[0]).max() > 0.1


def test_three_balls_pressed_together_rest_without_jitter() -> None:
    machine = standing(angles=[-0.4, 0.1, 0.6], beta=2e-4, contact={"restitution": 0.5})
    # rates of stiff contacts at rest are the error of the steps: 1e-6 at a tolerance of 1e-10, 1e-9 here
    found = states_of(machine, np.linspace(0.0, 40.0, 401), tolerance=1e-12)
    assert np.ptp(found[-50:, 6:9], axis=0).max() < 1e-11
    assert np.abs(found[-50:, 9:12]).max() < 1e-7
    np.testing.assert_allclose(np.diff(found[-1, 6:9]), TOUCH, rtol=2e-5)  # pressed together by their weight
    assert found[-1, 7] == pytest.approx(-0.5 * math.pi, abs=1e-6)  # the heap lies symmetric at the bottom


def test_partitions_hold_their_balls() -> None:
    machine = standing(
        axis="vertical",
        angles=[0.5, 2.0],
        speeds=[40.0, -30.0],
        partitions={"count": 4, "angle": 0.1},
        contact={"restitution": 0.9},
    )
    found = states_of(machine, np.linspace(0.0, 2.0, 2001), tolerance=1e-9)
    half = math.asin(0.5 * DIAMETER / ORBIT)
    for place in (6, 7):
        part = math.floor((found[0, place] - 0.1) / (0.5 * math.pi))
        low, high = 0.1 + part * 0.5 * math.pi + half, 0.1 + (part + 1) * 0.5 * math.pi - half
        assert found[:, place].min() > low - 0.1 * TOUCH
        assert found[:, place].max() < high + 0.1 * TOUCH
        assert np.ptp(found[:, place]) > 0.9 * (high - low)
    # each rebound takes the share of restitution
    speeds = np.unique(np.round(np.abs(found[:, 8]), 6))
    steady = [s for s in speeds if np.sum(np.abs(np.abs(found[:, 8]) - s) < 1e-6) > 20]
    assert len(steady) > 4
    np.testing.assert_allclose(np.array(steady[:-1]) / np.array(steady[1:]), 0.9, rtol=1e-4)


# the shape of a race -----------------------------------------------------------------------------------------------------


def _race(**more: object) -> Race:
    return Race(
        orbit_radius=0.1,
        drag={"law": "viscous", "damping": 0.0},
        balls=[{"diameter": 0.01, "density": 7800}],
        **more,
    )


def test_a_measured_profile_is_its_fourier_series() -> None:
    waves = [(1, 2e-5, 0.3), (2, 1e-4, -1.0), (5, 3e-5, 2.0)]
    first = 0.4
    angles = first + 2.0 * math.pi * np.arange(72) / 72
    profile = sum(a * np.cos(k * (angles - at)) for k, a, at in waves) + 4e-5
    measured = race_harmonics(_race(roundness={"deviations": profile.tolist(), "angle": first, "harmonics": 6}))
    given = race_harmonics(_race(harmonics=[{"order": k, "amplitude": a, "angle": at} for k, a, at in waves]))
    np.testing.assert_allclose(measured[:5], given, atol=1e-17)
    np.testing.assert_allclose(measured[5], 0.0, atol=1e-17)


def test_a_first_harmonic_is_an_eccentric_race_to_first_order() -> None:
    """The same ball at the same place with the same velocity: the rotor's acceleration differs by the square of the offset."""

    def machine(**race: object) -> Machine:
        return Machine(
            name="offset",
            axis="vertical",
            rotor={"mass": 1.0, "stiffness": 1e4, "damping": 0.0},
            balancers=[
                {
                    "races": [
                        {
                            "orbit_radius": 0.1,
                            "drag": {"law": "viscous", "damping": 0.0},
                            "friction": {},
                            "balls": [{"mass": 0.1, "diameter": 0.01}],
                            **race,
                        }
                    ]
                }
            ],
            drive={"kind": "speed", "profile": {"kind": "constant", "speed": 100.0}},
        )

    def pull(one: Machine, angle: float, rate: float) -> np.ndarray:
        assembly = assemble(one, rotating=False, general=True)
        if not one.balancers[0].races[0].harmonics:
            from autobalancer.kernels.balls.on_stations import guided as equations
        else:
            equations = guided_rough
        state = assembly.state
        state[5], state[6], state[7] = 100.0, angle, rate
        return rates_at(equations, 0.0, state, assembly.system)[2:4]

    misses = []
    for offset in (4e-4, 2e-4):
        center, phi, rate = offset * np.exp(0.5j), 1.3, 20.0
        place = center + 0.1 * np.exp(1j * phi)
        angle = float(np.angle(place))
        turning = float((np.conj(place) * 0.1j * np.exp(1j * phi) * rate).imag / abs(place) ** 2)
        eccentric = pull(machine(eccentricity=offset, eccentricity_angle=0.5), phi, rate)
        wavy = pull(machine(harmonics=[{"order": 1, "amplitude": offset, "angle": 0.5}]), angle, turning)
        plain = pull(machine(eccentricity=1e-12), angle, turning)
        misses.append(np.linalg.norm(wavy - eccentric))
        assert misses[-1] < 0.02 * np.linalg.norm(plain - eccentric)
    assert misses[0] / misses[1] == pytest.approx(4.0, rel=0.1)


def test_a_ball_on_an_oval_race_in_a_fast_rotor_seeks_the_wide_places() -> None:
    """Potential energy of the centrifugal force: -m w^2 eps(phi)^2/2, whatever ever else."""
    machine = standing(
        axis="vertical",
        angles=[1.0 + 0.5 * math.pi],
        speed=200.0,
        beta=1e-3,
        harmonics=[{"order": 2, "amplitude": 1e-3, "angle": 0.4}],
    )
    found = states_of(machine, np.array([0.0, 30.0]), tolerance=1e-9)[-1]
    assert math.remainder(found[6] - 0.4, math.pi) == pytest.approx(0.0, abs=1e-6)


# what makes no sense -----------------------------------------------------------------------------------------------------


def test_impossible_friction_contact_and_profiles_are_refused() -> None:
    with pytest.raises(
        MachineError, match=r"adherence: given 0\.01; must not be less than the rolling resistance, 0\.02"
    ):
        Friction(rolling_resistance=0.02, adherence=0.01)
    with pytest.raises(MachineError, match=r"restitution: given 1\.2; must be between 0 and 1"):
        Contact(restitution=1.2)
    with pytest.raises(MachineError, match="not closed"):
        Roundness(deviations=[1e-6 * i for i in range(26)])
    with pytest.raises(MachineError, match="at least 8"):
        Roundness(deviations=[0.0, 1e-6, 0.0])
    with pytest.raises(MachineError, match="24 points carry 1 to 11"):
        Roundness(deviations=[1e-6 * math.sin(i * math.pi / 12) for i in range(24)], harmonics=12)
    with pytest.raises(MachineError, match="either 'harmonics' or a measured 'roundness'"):
        _race(harmonics=[{"order": 2, "amplitude": 1e-4}], roundness={"deviations": [0.0] * 26})
    with pytest.raises(MachineError, match="collisions"):
        _race(collisions=False, contact={"restitution": 0.5})
    with pytest.raises(MachineError, match="must be between 1 and 60"):
        _race(harmonics=[{"order": 0, "amplitude": 1e-4}])


@pytest.mark.parametrize(("turn", "restitution"), [(3.1780877134844623, None), (3.209494314016944, 0.5)])
def test_two_balls_that_touch_are_measured_at_every_speed_where_they_begin_to_stick_and_slip(
    turn: float, restitution: float | None
) -> None:
    machine, race = rig("rodrigues_rig_fitted"), "balancers[1].races[1]."
    machine = with_value_at(machine, f"{race}friction", {"rolling_resistance": 0.0005, "adherence": 0.0005})
    machine = with_value_at(machine, f"{race}balls[1].start_angles", (turn, turn + 0.1113))
    if restitution is not None:
        machine = with_value_at(machine, f"{race}contact", {"restitution": restitution})
    # the ball that waits is pushed loose and stopped within a step; the last speed sets the stiffness of the contact
    speeds = np.array([*range(600, 1101, 10), 5400]) * math.pi / 30.0
    found = stepped_response(machine, speeds, dwell=0.25, window=0.25, stations=["B1", "B2"], max_steps=20_000)
    assert set(found["outcome"].values.tolist()) == {"finished"}
    assert np.isfinite(found["amplitude"].values).all()
    apart = np.diff(found["least_ball_angle_in_rotor"].values[:-1], axis=1)
    assert apart.min() > 0.99 * 0.11127  # and they never passed through each other

"""Balancing without phase: circles, mirror images, uncertainty and runs that do not belong together."""

from __future__ import annotations

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.machine import Unbalance
from autobalancer.measure import BalanceRun, Reading, TrialMass, four_run
from autobalancer.measurement.balancing.four_run import closed_form

PLACES = (0.0, 120.0, 240.0)
MASSES = np.array([0.0, *(0.02 * np.exp(1j * np.radians(PLACES)))])


def job(amplitudes, places=PLACES, mass: float = 0.02) -> list[BalanceRun]:
    trials = [
        BalanceRun(f"trial at {place:g}", [Reading(a)], [TrialMass("disk", mass, f"{place} deg")])
        for a, place in zip(amplitudes[1:], places, strict=True)
    ]
    return [BalanceRun("original", [Reading(amplitudes[0])]), *trials]


def seen(correction: complex, places=PLACES, mass: float = 0.02, sensitivity: float = 3e-3) -> np.ndarray:
    """Amplitudes of a linear rotor."""
    masses = np.array([0.0, *(mass * np.exp(1j * np.radians(place)) for place in places)])
    return sensitivity * np.abs(masses - correction)


def first(found) -> complex:
    return complex(found.correction[0, 0] * np.exp(1j * found.correction_angle[0, 0]))


@pytest.mark.parametrize("correction", [0.03 * np.exp(2j), 0.004 * np.exp(-1j), 0.1 * np.exp(4j)])
def test_exact_amplitudes_give_the_exact_correction(correction):
    found = four_run(job(seen(correction)))
    assert first(found) == pytest.approx(correction, rel=1e-7)
    assert float(found.sensitivity[0, 0]) == pytest.approx(3e-3, rel=1e-7)
    assert float(found.miss[0]) < 1e-6
    c, h = closed_form(seen(correction), MASSES)
    assert (c, h) == (pytest.approx(correction, rel=1e-9), pytest.approx(3e-3, rel=1e-9))


def test_the_amplitude_with_masses_in_holes_is_that_of_the_rotor_with_just_these():
    correction = 0.03 * np.exp(2j)
    found = four_run(job(seen(correction)), holes=7, stock=["5 g", "12 g"])
    on = (found.part_mass * np.exp(1j * found.part_angle)).sum().item()
    assert float(found.residual[0, 0]) == pytest.approx(3e-3 * abs(on - correction), rel=1e-6)
    assert float(found.part_left[0]) == pytest.approx(abs(on - correction), rel=1e-6)
    assert "12 g at" in dict(found.facts())["correction"]


def test_places_and_masses_may_be_any():
    places, correction = (10.0, 75.0, 200.0, 290.0), 0.03 * np.exp(2j)
    assert first(four_run(job(seen(correction, places), places))) == pytest.approx(correction, rel=1e-7)


def test_the_example_of_shreve_agrees_with_its_circles():
    # Balancing Without Phase: 10 mils, then 7, 12 and 18 mils with 50 g at 0, 120 and 240 deg. Its drawing: circles of these
    # radii around the trial places on a circle of 10 mils meet near P; the correction is 50 g times 10 over |P|, towards P
    amplitudes, mils = np.array([10.0, 7.0, 12.0, 18.0]), 2.54e-5
    found = four_run(job(amplitudes * mils, mass=0.05), deviation="5 %")
    centers = 10.0 * np.exp(1j * np.radians(PLACES))
    rows = np.column_stack([centers.real, centers.imag])
    right = 0.5 * (100.0 - amplitudes[1:] ** 2)  # |P - center|^2 = r^2, less the mean of all three
    x, y = np.linalg.lstsq(rows, right - right.mean(), rcond=None)[0]
    drawn = 0.05 * 10.0 / abs(complex(x, y)) * np.exp(1j * np.angle(complex(x, y)))
    closed, _ = closed_form(amplitudes, np.array([0.0, *(0.05 * np.exp(1j * np.radians(PLACES)))]))
    assert np.angle(closed) == pytest.approx(np.angle(drawn), abs=1e-9)  # both use the differences of squares alone
    # these circles do not meet exactly: least squares lie between both closed forms, which spread what does not fit otherwise
    assert abs(closed) < abs(first(found)) < abs(drawn)
    assert np.degrees(np.angle(first(found) / drawn)) == pytest.approx(0.0, abs=3.0)


def test_three_runs_have_two_answers_and_the_fourth_decides():
    correction = 0.03 * np.exp(2j)
    a = seen(correction)
    with pytest.raises(QuestionError, match=r"two trial runs .*two places do equally well"):
        four_run(job(a[:3], PLACES[:2]))
    both = four_run(job(a[:3], PLACES[:2]), both=True)
    places = (both.correction * np.exp(1j * both.correction_angle)).values[0]
    assert both.sizes["solution"] == 2
    assert min(abs(places - correction)) < 1e-8
    assert both.misfit.max() < 1e-6
    assert "only a fourth run shows" in both.facts()[0][1]
    assert first(four_run(job(a))) == pytest.approx(correction, rel=1e-7)


def test_trial_places_on_one_line_leave_a_mirror_image():
    correction = 0.03 * np.exp(2j)
    runs = job(seen(correction, (0.0, 180.0)), (0.0, 180.0))
    with pytest.raises(QuestionError, match="all masses lie on one line"):
        four_run(runs)
    places = four_run(runs, both=True)
    found = (places.correction * np.exp(1j * places.correction_angle)).values[0]
    np.testing.assert_allclose(sorted(found.imag), sorted([correction.imag, -correction.imag]), rtol=1e-6)
    np.testing.assert_allclose(found.real, correction.real, rtol=1e-6)


def test_one_percent_of_noise_leaves_three_percent_and_two_degrees_as_stated():
    correction, rng = 0.03 * np.exp(2j), np.random.default_rng(2)
    off, stated, left = [], [], []
    for _ in range(40):
        found = four_run(
            job(seen(correction) * (1.0 + 0.01 * rng.standard_normal(4))), deviation=0.01, holes=7, stock=["12 g"]
        )
        # the vibration, as a vector, that is predicted with masses in holes less that of the rotor, in standard deviations
        on = (found.part_mass * np.exp(1j * found.part_angle)).sum().item()
        missed = float(found.sensitivity[0, 0]) * (on - first(found)) - 3e-3 * (on - correction)
        left.append(abs(missed) / float(found.residual_deviation[0, 0]))
        off.append((abs(first(found)) / abs(correction) - 1.0, np.angle(first(found) / correction)))
        stated.append(
            (float(found.correction_deviation[0, 0]) / abs(correction), float(found.correction_angle_deviation[0, 0]))
        )
    scatter = np.sqrt(np.mean(np.square(off), axis=0))
    assert scatter[0] < 0.03
    assert np.degrees(scatter[1]) < 2.0
    np.testing.assert_allclose(np.mean(stated, axis=0), scatter, rtol=0.35)  # of 40 jobs: 11 %, three times
    assert np.sqrt(0.5 * np.mean(np.square(left))) == pytest.approx(1.0, rel=0.35)


def test_how_far_the_circles_miss_each_other_is_a_share_of_what_the_trial_mass_does():
    readings = seen(0.03 * np.exp(2j))
    readings[1] += 0.1 * 3e-3 * 0.02  # one reading by a tenth of the effect: h times the trial mass
    found = four_run(job(readings), deviation=0.05)
    away = found.missed.values[:, 0] * 0.05 * readings
    assert float(found.miss[0]) == pytest.approx(np.sqrt((away**2).sum()) / (float(found.sensitivity[0, 0]) * 0.02))
    assert 0.01 < float(found.miss[0]) < 0.1  # the correction and h take up the rest
    circles, _, trial = (text for _, text in found.facts())
    assert f"{100.0 * float(found.miss[0]):.2g} % of what the trial mass does" in circles
    assert "distrust" in circles
    assert trial.startswith("take it off")


def test_angles_against_rotation_are_the_mirror_image():
    a = seen(0.03 * np.exp(2j))
    one, other = four_run(job(a)), four_run(job(a), angles="against rotation")
    assert float(one.correction[0, 0]) == pytest.approx(float(other.correction[0, 0]))
    assert float(one.correction_angle[0, 0]) == pytest.approx(
        float(other.correction_angle[0, 0])
    )  # both as the user counts


def test_runs_that_do_not_belong_together_are_refused_with_their_names():
    a = seen(0.03 * np.exp(2j))
    moved = a * np.array([1.0, 2.5, 1.0, 1.0])
    with pytest.raises(QuestionError, match=r"circles do not meet: run '.*balls in a race that have moved"):
        four_run(job(moved), deviation=0.01)
    with pytest.raises(QuestionError, match="runs 'trial at 120' and 'again' have the same mass at the same place"):
        four_run([*job(a), BalanceRun("again", [Reading(a[2])], [TrialMass("disk", 0.02, "120 deg")])])
    with pytest.raises(QuestionError, match="no more than its uncertainty"):
        four_run(job([1.0, 1.01, 0.99, 1.0]))
    with pytest.raises(QuestionError, match="one plane with trial masses; given 'disk', 'fan'"):
        four_run([*job(a), BalanceRun("x", [Reading(1.0)], [TrialMass("fan", 0.02)])])
    with pytest.raises(QuestionError, match="given 2 runs"):
        four_run(job(a[:2], PLACES[:1]))
    with pytest.raises(QuestionError, match="given none"):
        four_run([BalanceRun(n, [Reading(1.0)]) for n in "abcd"])


def rig_runs(places: list[list[float]]) -> list[BalanceRun]:
    """Four runs of a rig with balls at given angles in the rotor, one list for each run."""
    machine, found = ab.example("discoidal"), []
    for place, balls in zip((None, *PLACES), places, strict=True):
        mass = () if place is None else (Unbalance(moment=4e-4, angle=np.radians(place)),)
        seen = ab.rotor.response(machine, [100.0], unbalance=(*machine.unbalances, *mass), ball_angles=balls)
        on = [] if place is None else [TrialMass("disk", "400 g*mm", f"{place} deg")]
        found.append(BalanceRun(str(place), [Reading(float(seen.semi_major[0, 0]))], on))
    return found


def test_balls_that_are_held_are_part_of_the_unbalance_and_balls_that_moved_are_told():
    held = rig_runs([[1.0, 2.0]] * 4)
    found = four_run(held, deviation=0.01)
    machine = ab.example("discoidal")
    own, one = (
        complex(float(seen.x_real[0, 0]), float(seen.x_imag[0, 0]))
        for seen in (
            ab.rotor.response(machine, [100.0], ball_angles=[1.0, 2.0]),
            ab.rotor.response(machine, [100.0], unbalance=1.0, balls=True),
        )
    )
    assert first(found) == pytest.approx(-own / one, rel=1e-6)
    moved = rig_runs([[1.0, 2.0], [4.0, 4.5], [1.5, 3.0], [2.0, 5.0]])
    with pytest.raises(QuestionError, match=r"balls in a race that have moved between runs"):
        four_run(moved, deviation=0.01)

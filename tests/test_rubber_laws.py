"""Closed forms of rubber whose stiffness falls with amplitude, against its differential equations."""

import math

import numpy as np
import pytest
from scipy.integrate import quad, trapezoid

from autobalancer.errors import QuestionError
from autobalancer.laws.rubber import RubberLaw, friction_stiffness

RATIO = np.array([0.8, 1.4, 3.0, 12.0])
STEPS = 2000  # of a cycle; the rates have kinks, so Runge and Kutta's error is of the second order there


def rate(law: str, force: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """f' with k = a_c = 1, written out."""
    if law == "endochronic":
        return velocity - np.abs(velocity) * force
    return velocity - force * np.maximum((np.conj(force) * velocity).real, 0.0)


def last_cycle(law: str, motion: str, cycles: int) -> tuple[np.ndarray, np.ndarray]:
    """Deflection and force over the last cycle at angular frequency one, (STEPS + 1, amplitudes)."""

    def velocity(t: float) -> np.ndarray:
        turned = 1j * np.exp(1j * t)
        return RATIO * (turned if motion == "circle" else turned.real + 0j)

    force, h, kept = np.minimum(RATIO, 1.0) + 0j, 2.0 * math.pi / STEPS, []
    for n in range(cycles * STEPS + 1):
        t = n * h
        if n >= (cycles - 1) * STEPS:
            kept.append(force)
        one = rate(law, force, velocity(t))
        two = rate(law, force + 0.5 * h * one, velocity(t + 0.5 * h))
        three = rate(law, force + 0.5 * h * two, velocity(t + 0.5 * h))
        four = rate(law, force + h * three, velocity(t + h))
        force = force + h / 6.0 * (one + 2.0 * two + 2.0 * three + four)
    angle = np.linspace(0.0, 2.0 * math.pi, STEPS + 1)
    turned = np.exp(1j * angle)
    return RATIO * (turned if motion == "circle" else turned.real + 0j)[:, None], np.array(kept)


@pytest.mark.parametrize("law", ["elastoplastic", "endochronic"])
@pytest.mark.parametrize("motion", ["circle", "line"])
def test_stiffness_and_loss_of_a_friction_element_are_those_of_its_equation(law, motion):
    z, force = last_cycle(law, motion, 9)
    angle = np.linspace(0.0, 2.0 * math.pi, STEPS + 1)[:, None]
    first = trapezoid(force * np.exp(-1j * angle), angle, axis=0) / (RATIO * math.pi)
    known = friction_stiffness(RATIO, law, motion)
    if motion == "circle":
        first = first / 2.0  # both quadratures of a circle are in the one product
    assert known == pytest.approx(first, abs=3e-6)
    work = trapezoid((np.conj(force) * np.gradient(z, angle[1, 0], axis=0)).real, angle, axis=0)
    cost = RubberLaw(0.0, 0.0, ((1.0, 1.0),), law=law).loss(RATIO, 1.0, motion)
    assert cost == pytest.approx(work, rel=2e-4, abs=2e-5)  # np.gradient is of the first order at both ends


def loss_over_softening(law: str, motion: str) -> float:
    """K'' over -dK'/d ln a of elements of this law, spread evenly over the logarithm of a_c."""
    if motion == "circle":
        return math.pi / 4.0 if law == "elastoplastic" else math.pi / 2.0

    def loss(log: float) -> float:
        return float(friction_stiffness(math.exp(log), law, motion).imag)

    return float(quad(loss, -25.0, 0.0)[0] + quad(loss, 0.0, 3.0)[0] + quad(loss, 3.0, 25.0)[0])


@pytest.mark.parametrize("law", ["elastoplastic", "endochronic"])
def test_a_line_costs_less_than_the_circle_of_the_same_stiffness_elements(law):
    assert loss_over_softening(law, "line") < loss_over_softening(law, "circle")


def test_loss_over_softening_of_a_chain_with_fine_steps_is_the_ratio_of_the_law():
    step = 0.05
    limits = np.exp(np.arange(-8.0, 8.0, step))
    for law in ("elastoplastic", "endochronic"):
        for motion in ("circle", "line"):  # the sum over elements has waves
            rubber = RubberLaw(0.0, 0.0, tuple((step, float(limit)) for limit in limits), law=law)
            change = 0.01
            soft = -(rubber.stiffness(1.0 + change, 1.0, motion) - rubber.stiffness(1.0 - change, 1.0, motion)).real
            loss = rubber.stiffness(1.0, 1.0, motion).imag
            assert loss / (soft / (2.0 * change)) == pytest.approx(loss_over_softening(law, motion), rel=1e-2)


@pytest.mark.parametrize("law", ["elastoplastic", "endochronic"])
@pytest.mark.parametrize("motion", ["circle", "line"])
def test_small_motions_are_elastic_and_large_ones_cost_a_bounded_force(law, motion):
    assert friction_stiffness(1e-7, law, motion) == pytest.approx(1.0, abs=2e-7)
    bounded = 1.0 if motion == "circle" else 4.0 / math.pi  # of a constant force on a circle, of a square wave
    assert 1e6 * friction_stiffness(1e6, law, motion).imag == pytest.approx(bounded, rel=1e-5)


@pytest.mark.parametrize("law", ["elastoplastic", "endochronic"])
def test_the_series_of_small_lines_meets_the_closed_form(law):
    below, above = friction_stiffness([0.01 - 1e-12, 0.01 + 1e-12], law, "line")
    assert abs(above - below) < 1e-8  # the next terms of the series


def test_elements_without_friction_are_linear_and_maxwell_elements_stiffen_with_frequency():
    rubber = RubberLaw(100.0, 2.0, maxwell=((50.0, 0.1),))
    assert rubber.stiffness(1e-3, 10.0) == pytest.approx(100.0 + 20j + 50.0 * 1j / (1.0 + 1j))
    assert rubber.stiffness(1.0, 10.0, "line") == rubber.stiffness(1e-3, 10.0)
    assert rubber.at_rest(1e9).real == pytest.approx(150.0)
    assert math.isinf(rubber.largest_amplitude)


def test_numbers_that_no_rubber_has_are_refused():
    with pytest.raises(QuestionError, match=r"friction\[1\]"):
        RubberLaw(1.0, 0.0, ((-1.0, 1e-3),))
    with pytest.raises(QuestionError, match="law: given 'dahl'"):
        friction_stiffness(1.0, "dahl")
    with pytest.raises(QuestionError, match="finite"):
        friction_stiffness(math.nan)

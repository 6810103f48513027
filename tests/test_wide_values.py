"""Several numbers at once as one value: the same numbers as one after the other."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest
from numba import njit

from autobalancer.kernels.compiler.flags import NUMBERS
from autobalancer.kernels.compiler.numba_struct import data
from autobalancer.kernels.compiler.simd import (
    amount,
    greater,
    greatest,
    lane,
    lanes_of_processor,
    load,
    reading,
    root,
    rounded,
    select,
    store,
    total,
)
from autobalancer.kernels.trigonometry import exponential_of_lanes, sine_cosine, sine_cosine_of_lanes

load_2, all_2 = reading(2)
load_4, _ = reading(4)


@njit(**NUMBERS)
def arithmetic(a, b, out):  # type: ignore[no-untyped-def]
    x, y = load(data(a), 0), load(data(b), 0)
    z = -(x * 2.0 - y / x + 3)
    z += 1.0
    z = select(x > y, z, 7.0)
    store(z, data(out), 0)
    store(greater(root(amount(x)), rounded(y)), data(out), 8)
    return total(z), greatest(amount(z)), lane(z, 2)


@njit(**NUMBERS)
def narrow(a, out):  # type: ignore[no-untyped-def]
    store(load_2(data(a), 1) * all_2(3.0), data(out), 0)
    store(load_4(data(a), 4) - 1.0, data(out), 2)


@njit(**NUMBERS)
def largest(a):  # type: ignore[no-untyped-def]
    return greatest(load(data(a), 0))


@njit(**NUMBERS)
def exponentials(exponents, found):  # type: ignore[no-untyped-def]
    store(exponential_of_lanes(load(data(exponents), 0)), data(found), 0)


@njit(**NUMBERS)
def sines(angles, wide, plain):  # type: ignore[no-untyped-def]
    s, c = sine_cosine_of_lanes(load(data(angles), 0))
    store(s, data(wide), 0)
    store(c, data(wide), 8)
    for i in range(8):
        plain[i], plain[8 + i] = sine_cosine(angles[i])


def test_arithmetic_on_wide_values_is_that_on_each_number() -> None:
    a, b = np.random.default_rng(1).normal(size=(2, 8)) * 3.0
    out = np.zeros(16)
    sums = arithmetic(a, b, out)
    expected = np.where(a > b, -(a * 2.0 - b / a + 3.0) + 1.0, 7.0)
    assert out[:8] == pytest.approx(expected, rel=1e-15)
    assert np.array_equal(out[8:], np.maximum(np.sqrt(np.abs(a)), np.rint(b)))
    assert sums == pytest.approx((expected.sum(), np.abs(expected).max(), expected[2]), rel=1e-14)


def test_values_of_two_and_four_lanes_stand_beside_those_of_eight() -> None:
    a, out = np.arange(8.0), np.zeros(6)
    narrow(a, out)
    assert out.tolist() == [3.0, 6.0, 3.0, 4.0, 5.0, 6.0]
    assert lanes_of_processor() in (1, 2, 4, 8)


def test_what_is_not_a_number_is_the_greatest_and_is_not_lost() -> None:
    for place in range(8):
        values = np.arange(8.0)
        values[place] = np.nan
        assert np.isnan(largest(values))


def test_sines_of_lanes_are_those_of_single_angles_in_every_quarter_turn() -> None:
    random = np.random.default_rng(2)
    for angles in (np.arange(-4, 4) * np.pi / 2 + 0.3, random.uniform(-900.0, 900.0, 8), random.normal(size=8) * 1e5):
        wide, plain = np.zeros(16), np.zeros(16)
        sines(angles, wide, plain)
        assert wide == pytest.approx(plain, abs=2.3e-16)


def test_interpreted_wide_values_do_the_same() -> None:
    code = (
        "import numpy as np, tests.test_wide_values as t\n"
        "out = np.zeros(16); a = np.arange(1.0, 9.0)\n"
        "print(t.arithmetic(a, a[::-1].copy(), out)[0])"
    )
    asked = subprocess.run(
        [sys.executable, "-c", code],
        env=os.environ | {"NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        check=True,
    )
    a, out = np.arange(1.0, 9.0), np.zeros(16)
    assert float(asked.stdout) == pytest.approx(arithmetic(a, a[::-1].copy(), out)[0], rel=1e-14)


def test_the_exponential_function_is_that_of_the_library_to_two_ulp() -> None:
    found, rng = np.empty(8), np.random.default_rng(3)
    for span in (1e-12, 0.3, 3.0, 50.0, 690.0):
        exponents = rng.uniform(-span, span, 8)
        exponents[0] = 0.0
        exponentials(exponents, found)
        assert found[0] == 1.0
        np.testing.assert_allclose(found, np.exp(exponents), rtol=5e-16, atol=0.0)
    exponentials(np.full(8, -1e4), found)
    assert 0.0 < found[0] < 1e-303

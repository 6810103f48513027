"""Roots and least values have the bits of SciPy's."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from autobalancer.roots import least, root

FUNCTIONS: dict[str, Any] = {
    "polynomial": lambda x: ((2.0 * x - 0.7) * x + 1.3) * x - 0.1,
    "step": lambda x: math.tanh(30.0 * (x - 0.21)) + 0.05,
    "growth": lambda x: np.exp(5.0 * x) - 1.3,
}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize(("xtol", "rtol"), [(1e-13, 1e-14), (1e-6, 1e-9), (1e-3, 2.0**-50)])
def test_a_root_has_the_bits_of_scipy(name: str, xtol: float, rtol: float) -> None:
    function = FUNCTIONS[name]
    assert root(function, -1.0, 1.0, xtol=xtol, rtol=rtol) == brentq(function, -1.0, 1.0, xtol=xtol, rtol=rtol)
    assert root(function, 1.0, -1.0, xtol=xtol, rtol=rtol) == brentq(function, 1.0, -1.0, xtol=xtol, rtol=rtol)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("xtol", [1e-5, 1e-10])
def test_a_least_value_has_the_place_and_the_bits_of_scipy(name: str, xtol: float) -> None:
    for function in (FUNCTIONS[name], lambda x: FUNCTIONS[name](x) ** 2):
        wanted = minimize_scalar(function, bounds=(-1.0, 2.0), method="bounded", options={"xatol": xtol})
        assert least(function, -1.0, 2.0, xtol=xtol) == (wanted.x, wanted.fun)


def test_an_end_may_be_the_root_and_without_a_change_of_sign_or_a_value_there_is_none() -> None:
    assert root(lambda x: x, 0.0, 1.0) == root(lambda x: x, -1.0, 0.0) == 0.0
    with pytest.raises(ValueError, match=r"one sign at 1\.0 and 2\.0"):
        root(lambda x: x, 1.0, 2.0)
    with pytest.raises(ValueError, match="no value at"):
        root(lambda x: math.nan if abs(x) < 0.5 else x, -1.0, 1.0)

"""Balls in models of other programs: the examples, which assert that both programs agree."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parent.parent / "examples" / "exchange"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["mujoco", "exudyn"])
def test_a_model_of_another_program_moves_with_the_balls_as_in_simulate(name: str) -> None:
    """To a millionth of the deflection; here once more, to be sure that both moved, and of how many digits differ."""
    pytest.importorskip(name)
    found = runpy.run_path(str(EXAMPLES / f"plot_{name}.py"))
    turned = np.ptp(found["run"]["ball_angle_in_rotor"].values, axis=0)
    assert turned.min() > 0.1
    assert found["miss"] < 1e-6 * found["run"]["deflection"].values.max()
    assert found["away"] < 1e-6

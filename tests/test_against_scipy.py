"""The planar machine by SciPy's DOP853 on the reference equations, for many random machines."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.references import lagrange
from tests.references.machines import DRIVES, random_machine
from tests.references.motion import motion
from tests.references.runs import run_to, states_at

from autobalancer.assembly.system import assemble

SMOOTH = [kind for kind in DRIVES if kind in ("torque", "constant", "hill")]


@pytest.mark.parametrize("drive", SMOOTH)
@pytest.mark.parametrize("seed", range(4))
def test_scipy_moves_random_machines_in_the_same_way(drive: str, seed: int) -> None:
    random = np.random.default_rng(100 + seed)
    machine = random_machine(random, drive=drive, scheduled=False)
    reference = lagrange.planar(machine)
    times = np.linspace(0.0, 0.3, 31)
    start = assemble(machine, rotating=False).state
    theirs = solve_ivp(
        reference.rates, (0.0, times[-1]), start, method="DOP853", t_eval=times, rtol=1e-12, atol=1e-14
    ).y.T
    ours, expected = motion(machine, states_at(machine, times)), motion(machine, theirs)
    np.testing.assert_allclose(ours.deflection, expected.deflection, rtol=0.0, atol=1e-11)
    np.testing.assert_allclose(ours.rotor_angle, expected.rotor_angle, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(ours.angles, expected.angles, rtol=0.0, atol=1e-8)


def test_the_order_eight_pair_takes_about_the_steps_of_scipys() -> None:
    """Same pair, same error norm: far more steps would mean a poor step control."""
    machine = random_machine(
        np.random.default_rng(5), drive="torque", axis="vertical", isotropic=False, scheduled=False
    )
    assembly, reference = assemble(machine), lagrange.planar(machine)
    tolerance = 1e-8
    theirs = solve_ivp(
        reference.rates,
        (0.0, 0.5),
        assembly.state,
        method="DOP853",
        rtol=1e-13,
        atol=tolerance * (assembly.scale + assembly.growing * np.abs(assembly.state)),
    )
    _, memory = run_to(machine, [0.5], tolerance=tolerance)
    assert memory.counts[0] < 1.6 * (theirs.t.size - 1)

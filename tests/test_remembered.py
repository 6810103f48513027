"""What is made once for machines that differ in other things is made anew where it would differ."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.assembly.rotors import lateral_model, with_ball_mass
from autobalancer.assembly.rotors.critical import forward_whirls
from autobalancer.cache import remembered

MACHINES = Path(__file__).parents[1] / "examples" / "machines"


def test_the_last_results_are_remembered_by_value_of_numbers_and_by_identity_of_all_else() -> None:
    made = list[object]()

    @remembered(3)
    def doubled(*given: object) -> int:
        made.append(given)
        return len(made)

    array = np.zeros(2)
    assert doubled(array, 0.0) == doubled(array, 0.0) == 1
    assert doubled(array, -0.0) == 2
    assert doubled(np.zeros(2), 0.0) == 3
    assert doubled(array, 0.0) == 1
    assert doubled(("a", 1, None), b"b") == doubled(("a", 1, None), b"b") == 4
    assert doubled(array, -0.0) == 5  # the one that was forgotten
    assert doubled(array, 0.0) == 1


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("rotor.supports[1].stiffness", 1.3e5),
        ("rotor.mass", 12.0),
        ("ball_mass", 0.1),
        ("balancers[1].station", 0.05),
        ("axis", "horizontal"),
    ],
)
def test_another_machine_has_its_own_rotor(name: str, value: object) -> None:
    machine = ab.load_machine(MACHINES / "two_plane_rotor.toml")
    for _ in range(2):  # the second time from memory
        other = ab.with_parameter(machine, name, value)
        for one in (machine, other):
            model, fresh = lateral_model(one), lateral_model.__wrapped__(one)  # type: ignore[attr-defined]
            assert np.array_equal(model.stiffness, fresh.stiffness)
            assert np.array_equal(model.mass, fresh.mass)
            loaded = with_ball_mass(one, model)
            assert np.array_equal(loaded.mass, with_ball_mass.__wrapped__(one, model).mass)  # type: ignore[attr-defined]
            assert forward_whirls(loaded) == forward_whirls.__wrapped__(loaded)  # type: ignore[attr-defined]

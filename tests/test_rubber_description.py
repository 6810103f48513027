"""Rubber that softens with the amplitude: what a machine file may say, and what theories of small motions take of it."""

import numpy as np
import pytest

import autobalancer as ab
from autobalancer.errors import MachineError
from autobalancer.machine import (
    Bushing,
    Constant,
    Machine,
    PlanarRotor,
    PrescribedSpeed,
    RigidRotor,
    Rubber,
    Spring,
    Support,
)

CHAIN = {"breakaway_amplitude": ["0.03 mm", "0.3 mm"], "stiffness": ["9 kN/m", "5 kN/m"]}
RELAXING = {"relaxation_time": ["2 ms", "20 ms"], "stiffness": ["2 kN/m", "3 kN/m"]}
SLIDING = {"stiffness": "25 kN/m", "damping": "20 N*s/m", "friction": CHAIN}


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"breakaway_amplitude": ["0.3 mm", "0.03 mm"], "stiffness": [1.0, 2.0]}, "entry 2 is 3e-05 after 0.0003"),
        ({"breakaway_amplitude": ["0.3 mm", "0.3 mm"], "stiffness": [1.0, 2.0]}, "must increase"),
        ({"breakaway_amplitude": ["0.3 mm"], "stiffness": [1.0, 2.0]}, "given 2 values for 1 amplitudes"),
        ({"breakaway_amplitude": [], "stiffness": []}, "empty"),
        ({"breakaway_amplitude": ["0.3 mm"], "stiffness": [0.0]}, "greater than zero"),
        ({"breakaway_amplitude": ["-0.3 mm"], "stiffness": [1.0]}, "greater than zero"),
        ({**CHAIN, "law": "plastic"}, "'elastoplastic' or 'endochronic'"),
    ],
)
def test_impossible_friction_elements_of_rubber_are_named(given, said):
    with pytest.raises(MachineError, match="friction") as error:
        Rubber(stiffness="25 kN/m", friction=given)
    assert said in str(error.value)


def test_rubber_without_elements_or_beside_a_spring_is_refused():
    with pytest.raises(MachineError, match="friction: missing"):
        Rubber(stiffness="25 kN/m")
    with pytest.raises(MachineError, match="stiffness: given beside 'rubber'"):
        PlanarRotor(mass=12.0, stiffness=1e4, rubber=SLIDING)
    with pytest.raises(MachineError, match="damping: given beside 'rubber'"):
        Support(position=0.0, damping=3.0, rubber=SLIDING)
    table = {"speed": [0.0, 1.0], "stiffness": [1.0, 1.0], "damping": [0.0, 0.0]}
    with pytest.raises(MachineError, match="shear_table: 'shear_rubber' contains it"):
        Bushing(between=("a", "b"), position=0.0, shear_rubber=SLIDING, shear_table=table)
    with pytest.raises(MachineError, match="stiffness_proportional_damping"):
        RigidRotor(
            mass=1.0, transverse_inertia=1.0, polar_inertia=1.0, stiffness_proportional_damping=1e-3,
            supports=[Support(position=-0.1, rubber=SLIDING), Support(position=0.1, rubber=SLIDING)],
        )  # fmt: skip


def machine_of(rotor):
    return Machine(name="on rubber", axis="vertical", rotor=rotor, drive=PrescribedSpeed(profile=Constant(speed=0.0)))


def test_small_motions_of_a_mass_on_rubber_have_the_stiffness_of_all_elements():
    modes = ab.rotor.modes(machine_of(PlanarRotor(mass=12.0, rubber=SLIDING)), 0.0)
    frequency = np.sqrt(39e3 / 12.0)
    assert np.allclose(modes.undamped_frequency, frequency, rtol=1e-12)
    assert np.allclose(modes.decay_rate, 20.0 / 24.0, rtol=1e-9)


def test_a_maxwell_element_adds_the_stiffness_and_the_loss_of_a_spring_behind_a_damper():
    rubber = Rubber(stiffness="25 kN/m", maxwell=RELAXING)
    frequency = 60.0
    k, c = rubber.small_motions(frequency)
    exact = 25e3 + sum(
        k / (1.0 + 1.0 / (1j * frequency * tau)) for k, tau in ((2e3, 2e-3), (3e3, 20e-3))
    )  # springs 1/k + 1/(i w c) in series, c = k tau
    assert k + 1j * frequency * c == pytest.approx(exact, rel=1e-12)
    # a table of the supports is linear between these frequencies
    grid = np.array(rubber.frequencies())
    between = np.interp(frequency, grid, [rubber.small_motions(w)[1] for w in grid])
    assert between == pytest.approx(c, rel=1e-2)


def test_every_kind_of_rotor_has_the_same_small_motions_on_the_same_rubber():
    rubber = {**SLIDING, "maxwell": RELAXING}
    planar = ab.rotor.modes(machine_of(PlanarRotor(mass=12.0, rubber=rubber)), 0.0)
    frequency = float(planar.undamped_frequency[0])
    halves = {
        "stiffness": 12.5e3, "damping": 10.0, "friction": {**CHAIN, "stiffness": [4.5e3, 2.5e3]},
        "maxwell": {**RELAXING, "stiffness": [1e3, 1.5e3]},
    }  # fmt: skip
    rotor = RigidRotor(
        mass=12.0, transverse_inertia=0.2, polar_inertia=0.1,
        supports=[Support(position=z, rubber=halves) for z in (-0.1, 0.1)],
    )  # fmt: skip
    model = ab.rotor.lateral_model(machine_of(rotor))
    assert np.sqrt(model.stiffness_at(frequency)[0, 0] / 12.0) == pytest.approx(frequency, rel=1e-4)
    spring = Spring(between=("rotor", "ground"), position=0.0, rubber=rubber)
    stiffness, _ = spring.matrices(frequency)
    assert np.sqrt(stiffness[0, 0] / 12.0) == pytest.approx(frequency, rel=1e-12)
    bushing = Bushing(between=("housing", "ground"), position=0.0, shear_rubber=rubber)
    stiffness, _ = bushing.matrices(frequency)
    assert np.diag(stiffness)[:3] == pytest.approx([0.0, 12.0 * frequency**2, 12.0 * frequency**2], rel=1e-12)


def test_check_says_how_soft_rubber_becomes_and_what_counts_with_which_stiffness():
    said = dict(ab.check(machine_of(PlanarRotor(mass=12.0, rubber=SLIDING))).rows())
    first, second = said["rubber"].split("\n")
    assert first == "support: 39 kN/m in small motions, 25 kN/m in the largest, when all elements slide"
    assert second.startswith("critical speeds, borders and what friction holds are those of small motions")


def test_a_machine_on_rubber_is_read_and_written_alike(tmp_path):
    machine = machine_of(PlanarRotor(mass=12.0, rubber={**SLIDING, "maxwell": RELAXING}))
    ab.save_machine(machine, tmp_path / "rubber.toml")
    again = ab.load_machine(tmp_path / "rubber.toml")
    assert again == machine
    harder = ab.with_parameter(again, "rotor.rubber.friction.stiffness[2]", "7 kN/m")
    assert harder.rotor.rubber.initial_stiffness == pytest.approx(41e3)
    assert ab.with_parameter(again, "rotor.mass", "13 kg").rotor.rubber == machine.rotor.rubber

"""Every key of a machine file is declared with the theories that know it, and what a theory does not know it says."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import autobalancer as ab
from autobalancer.assembly.terms import TERMS, Theory, declared_for, unknown
from autobalancer.machine import Balancer, Race
from autobalancer.machine.keys import TAGS, parts_at, tables_of
from autobalancer.machine.machine import Machine
from autobalancer.machine.part import Part, key
from autobalancer.machine.quantity import Ratio

ALL_PARTS = [part for table in tables_of(Machine) for part in table.parts]
DISC = ab.load_machine("examples/machines/discoidal.toml")


class BrakedRace(Race):
    """A race with a key that somebody added to the equations and declared nowhere."""

    brake: Ratio = key("a constant torque on the balls", 0.0)


def braked(brake: float) -> Machine:
    race = DISC.balancers[0].races[0]
    own = BrakedRace(**{name: getattr(race, name) for name in race.model_fields_set}, brake=brake)
    return DISC.model_copy(update={"balancers": (Balancer(races=(own,)),)})


def keys_with_values() -> Iterator[tuple[type[Part], str]]:
    return (
        (part, name)
        for part in ALL_PARTS
        for name in part.model_fields
        if name not in TAGS and not parts_at(part, name)
    )


def test_every_key_of_a_machine_file_is_declared_with_the_theories_that_know_it() -> None:
    missing = [f"{part.__name__}.{name}" for part, name in keys_with_values() if not declared_for(part, name)]
    assert not missing, "declare these in assembly/terms.py"


def test_the_table_of_terms_declares_no_key_that_there_is_not_and_gives_every_reason() -> None:
    bases = {base for part in ALL_PARTS for base in part.__mro__ if issubclass(base, Part)}
    there = {(base.__name__, name) for base in bases for name in (*base.model_fields, "*")}
    assert not [owner for term in TERMS for owner in term.owners() if owner not in there]
    assert all(term.why or not term.idle for term in TERMS)
    assert not [term.name for term in TERMS if term.known & term.idle]
    assert len({term.name for term in TERMS}) == len(TERMS)


@pytest.mark.parametrize("theory", Theory)
def test_a_key_that_nobody_declared_is_known_to_no_theory(theory: Theory) -> None:
    said = ("balancers[1].races[1].brake (not known to any theory)",)
    assert unknown(braked(0.1), theory) == unknown(braked(0.0), theory) + said


def test_every_answer_names_a_key_that_nobody_declared() -> None:
    machine, said = braked(0.1), "ignores balancers[1].races[1].brake (not known to any theory)"
    answers = [
        ab.stability.equilibria(machine, 125.0),
        ab.stability.eigenvalues(machine, [125.0]),
        ab.stability.map(machine, {"speed": [125.0], "viscosity": [5e-6]}, borders=0),
        ab.stability.border_curve(machine, "viscosity", [5e-6], only=("exact border",)),
    ]
    assert all(said in repr(answer) for answer in answers)
    assert all(said in repr(answer) for answer in (ab.check(machine), ab.stability.held_by_friction(machine)))
    notes = {border.name: border.note for border in ab.stability.borders(machine)}
    assert len(notes) == 5
    assert all(said in note for note in notes.values())
    assert said in ab.stability.stable_windows(machine, 130.0).note
    assert said in ab.stability.explicit_averaged_border(machine).note
    with pytest.warns(ab.errors.RangeWarning, match="minimum drag: the averaged border ignores balancers"):
        ab.stability.minimum_drag(machine, 125.0, "averaged border")
    assert said in repr(ab.rotor.modes(machine))

"""Every key of a machine file is declared with the theories that know it, and what a theory does not know it says."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from typing import Any, Literal

import numpy as np
import pytest
from tests.references.every_key import OIL, machine, machines, variants

import autobalancer as ab
from autobalancer.assembly.guided_balls import ball_rows
from autobalancer.assembly.rotors.lateral_model import LateralModel, matrices
from autobalancer.assembly.terms import TERMS, Theory, declared_for, unknown
from autobalancer.catalog.resolve import capability_of, resolve
from autobalancer.errors import QuestionError
from autobalancer.machine import Balancer, PlanarRotor, Race, RigidRotor, Support
from autobalancer.machine.keys import TAGS, parts_at, tables_of
from autobalancer.machine.machine import Machine
from autobalancer.machine.part import Mass, Part, Ratio, key
from autobalancer.machine.rotors.body import RotorModel
from autobalancer.sketch import layout_of

ALL_PARTS = [part for table in tables_of(Machine) for part in table.parts]
DISC = ab.load_machine("examples/machines/discoidal.toml")


class BrakedRace(Race):
    """A race with a key that somebody added to the equations and declared nowhere."""

    brake: Ratio = key("a constant torque on the balls", 0.0)


class BearingRace(Race):
    """A race whose balls get a number under the name that the equations have for it."""

    pulls: Ratio = key("whether what guides its balls also pulls", 0.0, of_ball=True)


def with_race(kind: type[Race], **more: float) -> Machine:
    race = DISC.balancers[0].races[0]
    own = kind(**{name: getattr(race, name) for name in race.model_fields_set}, **more)
    return DISC.model_copy(update={"balancers": (Balancer(races=(own,)),)})


def braked(brake: float) -> Machine:
    return with_race(BrakedRace, brake=brake)


def test_a_number_of_a_ball_goes_from_its_key_to_the_equations_under_its_name() -> None:
    balls = resolve(with_race(BearingRace, pulls=0.25))
    assert ball_rows(balls).pulls.tolist() == [0.25] * len(balls)
    assert not ball_rows(resolve(DISC)).pulls.any()


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


def of_states(machine: Machine) -> Any:
    found = ab.stability.equilibria(machine, 120.0)
    return np.concatenate([found["eigenvalue_real"].values.ravel(), found["deflection"].values])


def of_stalled(machine: Machine) -> Any:
    both = ("release speed", "capture speed") if isinstance(machine.rotor, PlanarRotor) else ("release speed",)
    return np.array([border.speed for border in ab.stability.borders(machine, only=both, up_to=300.0)])


def of_held(machine: Machine) -> Any:
    planes = ab.stability.held_by_friction(machine, 120.0, starts=8).planes
    return np.array([value for plane in planes for value in vars(plane).values() if isinstance(value, float)])


def of_rotor(machine: Machine) -> Any:
    found = ab.rotor.modes(machine, 120.0)
    return np.concatenate(
        [found["frequency"], found["decay_rate"], ab.rotor.response(machine, [100.0])["semi_major"][0]]
    )


def of_averaged(machine: Machine) -> Any:
    return np.array([border.speed for border in ab.stability.borders(machine, only=("averaged border",))])


def of_ends(machine: Machine) -> Any:
    if not isinstance(machine.rotor, PlanarRotor):  # a rotor moves in these runs as in all runs
        return np.array([])
    found = ab.basin(machine, 120.0, {"ball_speed": [-20.0]}, hold=0.1, progress=False)
    names = {"final_ball_angle_in_rotor", "final_deflection", "vibration", "residual_unbalance"} & set(found)
    return np.concatenate([found[name].values.ravel() for name in sorted(names)])


def of_liquid(machine: Machine) -> Any:
    found = ab.rotor.liquid_response(machine, [120.0])
    return np.array([found[name].values[0] for name in ("deflection", "phase", "frozen", "liquid_moment")])


def of_capability(machine: Machine) -> Any:
    return np.array([capability_of(resolve(machine))])


STATEMENTS = {
    Theory.AT_REST: of_states,
    Theory.AVERAGED: of_averaged,
    Theory.BASIN: of_ends,
    Theory.LIQUID: of_liquid,
    Theory.STALLED: of_stalled,
    Theory.HELD: of_held,
    Theory.ROTOR: of_rotor,
    Theory.CAPABILITY: of_capability,
}
SYMMETRIC = {
    "Unbalance.angle",
    "Schedule.time",  # a turn of all, and what is over when the state is there
    "Bushing.angle",
    "Disk.extent",
    "BallBearing.axial_stiffness",
}  # three feet all around; reach of a disk; along the axis
UNMOVED = {  # known keys that change nothing in these machines
    Theory.AT_REST: {"Pins.count", "Pins.hold", "Pins.reach",
                     "Pins.release_speed",  # their speed is below that of the state
                     "RadialSpring.stiffness", "RadialSpring.free_length",
                     # along the radius of guided balls
                     "InclinedRace.incline", "InclinedRace.inner_radius", "InclinedRace.outer_radius",
                     "RaceSprings.free_length"},
    Theory.STALLED: {"unbalance", "speed over time", "eccentric races", "partitions", "linear drag", "drag that is not linear",
                     "Balls.inertia", "Fluid.virtual_mass", "Race.orbit_radius", "Race.race_radius", "SpeedTable.speed"},
    Theory.AVERAGED: {"unbalance", "Balls.inertia", "Fluid.virtual_mass"},  # the worst case; slow balls
    Theory.BASIN: {"Balls.start_speeds", "lag of the fluid",  # given by the axis; none of these fluids lags
                   "Friction.adherence",  # of balls that move
                   "PowerLaw.highest_rate", "TableShear.at_ball", "TableShear.rates"},  # they are sheared between the ends
    Theory.HELD: {"speed over time", "Fluid.viscosity",
                  "linear drag", "eccentric races", "Balls.inertia", "Fluid.virtual_mass", "unbalance"},
    Theory.ROTOR: {"Balls.diameter", "Balls.inertia", "Fluid.virtual_mass", "Fluid.viscosity", "Race.orbit_radius",
                   "Race.race_radius", "RubberFriction.breakaway_amplitude"},
    Theory.CAPABILITY: {"Balls.inertia", "Fluid.virtual_mass", "Fluid.viscosity"},
}  # fmt: skip


def alike(one: Any, other: Any) -> bool:
    size = np.nan_to_num(np.abs(one), posinf=0.0).max(initial=0.0)
    return one.shape == other.shape and np.allclose(one, other, rtol=1e-9, atol=1e-12 * size, equal_nan=True)


@pytest.mark.slow
@pytest.mark.parametrize("theory", STATEMENTS)
def test_a_changed_key_changes_a_statement_or_is_without_effect_or_is_said_to_be_ignored(theory: Theory) -> None:
    ask, moved, silent, asked = STATEMENTS[theory], set[str](), set[str](), Counter[tuple[str, str]]()
    for base in machines():
        try:
            before = ask(base)
        except QuestionError:
            assert not unknown(base, theory) or theory is not Theory.CAPABILITY
            continue
        if not np.isfinite(before).any():
            continue
        said = unknown(base, theory)
        for part, name, changed in variants(base):
            if (at := f"{part.__name__}.{name}") in moved:
                continue
            terms = declared_for(part, name)
            partly = any(term.names.get(theory, term.name) in said for term in terms)
            harmless = {at, *(term.name for term in terms)} & (SYMMETRIC | UNMOVED.get(theory, set()))
            if at not in silent and (partly or (harmless and any(theory in term.known for term in terms))):
                continue  # moved or not, it is right
            asked[base.rotor.kind, at] += 1
            if asked[base.rotor.kind, at] > 3 and at not in silent:
                continue  # without effect on three machines with such a rotor
            if not alike(before, ask(changed)):
                moved.add(at)
                partly = partly or any(term.name in unknown(changed, theory) for term in terms)
                assert partly or any(theory in term.known for term in terms), f"{at}: not declared known"
                continue
            if not (partly or harmless or any(theory in term.idle for term in terms)):
                silent.add(at)
    assert not silent - moved, "declared known, and without any effect"


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


BALLS = {"count": 2, "diameter": 0.01, "density": 7800.0}
KNOWN: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "linear drag": ({"drag": {"law": "viscous", "damping": 1e-3}}, {}),
    "fluid": ({"fluid": OIL, "drag": {"law": "cd_times_re", "cd_times_re": 60.0}}, {}),
    "eccentric races": ({"eccentricity": 2e-5, "eccentricity_angle": 1.0}, {}),
    "unequal balls": ({"race_radius": 0.085, "balls": [BALLS | {"count": 1}, {"mass": 0.0045, "diameter": 0.011}]}, {}),
    "points": ({"balls": [{"count": 2, "mass": 0.004, "motion": "point"}]}, {}),
    "rollers": ({"balls": [{"body": "roller", "count": 2, "diameter": 0.01, "length": 0.01, "density": 7800.0}]}, {}),
    "pendulums": ({"balls": [{"body": "pendulum", "count": 2, "mass": 0.004, "inertia": 1e-7}]}, {}),
    "unbalances": ({}, {"unbalances": [{"moment": 2e-4}, {"mass": 0.01, "radius": 0.02, "angle": 1.0}]}),
    "change of the unbalance": ({}, {"unbalances": [{"moment": 3e-4, "schedule": {"time": [1.0, 2.0], "factor": [0.2, 0.8]}}]}),
    "damping": ({}, {"rotor": {"kind": "planar", "mass": 10.0, "stiffness": 4e4, "damping_ratio": 0.2}}),
}  # fmt: skip


@pytest.mark.parametrize("term", KNOWN)
def test_steady_states_of_a_known_term_are_where_runs_settle(term: str) -> None:
    race, more = KNOWN[term]
    place = {"orbit_radius": 0.08} if "race_radius" not in race else {}
    entries = place | {"drag": {"law": "viscous", "damping": 1e-3}, "balls": [BALLS], "collisions": False}
    one = machine({**entries, **race}, rotor=more.get("rotor"), unbalances=more.get("unbalances", [{"moment": 3e-4}]))
    states = ab.stability.equilibria(one, 120.0)
    stable = states["ball_angle_in_rotor"].values[states["verdict"].values == "stable"]
    run = ab.simulate(one, duration=600.0, seed=3, mass_spread=0.0, progress=False)
    ended = run["ball_angle_in_rotor"].values[-1]
    apart = [np.abs(np.angle(np.exp(1j * (ended - angles)))).max() for angles in (*stable, *stable[:, ::-1])]
    assert min(apart) < 1e-6


def test_a_run_with_a_term_that_is_ignored_settles_elsewhere_and_the_statement_says_so() -> None:
    rubbing = machine(
        {
            "orbit_radius": 0.08,
            "drag": {"law": "viscous", "damping": 1e-3},
            "balls": [BALLS],
            "friction": {"rolling_resistance": 3e-3},
        }
    )
    states = ab.stability.equilibria(rubbing, 120.0)
    assert "ignores friction" in repr(states)
    run = ab.simulate(rubbing, duration=30.0, seed=3, progress=False)
    ended, turned = run["ball_angle_in_rotor"].values[-1], states["ball_angle_in_rotor"].values[0]
    assert np.abs(np.angle(np.exp(1j * (ended - turned)))).max() > 1e-2


class HeavyRotor(RotorModel):
    """A rotor model of one's own: a rigid rotor with a second mass."""

    kind: Literal["heavy"] = "heavy"
    body: RigidRotor = key("the rotor without it")
    more: Mass = key("fixed at the mass center")

    @property
    def supports(self) -> tuple[Support, ...]:
        return self.body.supports

    @property
    def inertia(self) -> float:
        return self.body.inertia

    @property
    def stiffness_proportional_damping(self) -> float:
        return float(self.body.stiffness_proportional_damping)


@matrices.register
def _heavy(rotor: HeavyRotor, gravity: float = 0.0) -> LateralModel:
    bare = matrices(rotor.body, gravity)
    return replace(bare, mass=bare.mass + rotor.more * np.diag([1.0, 0.0, 1.0, 0.0]))


def test_a_rotor_model_is_its_keys_and_its_matrices_and_every_theory_knows_it_and_it_is_drawn() -> None:
    plain = ab.example("two_plane_rotor")
    own = plain.model_copy(update={"rotor": HeavyRotor(body=plain.rotor, more=2.0)})
    heavier = ab.with_parameter(plain, "rotor.mass", plain.rotor.mass + 2.0)
    assert ab.rotor.critical_speeds(own)["critical_speed"].values == pytest.approx(
        ab.rotor.critical_speeds(heavier)["critical_speed"].values, rel=1e-12
    )
    assert all(unknown(own, theory) == unknown(plain, theory) for theory in Theory)
    assert [spring.place for spring in layout_of(own).springs] == [s.position for s in plain.rotor.supports]

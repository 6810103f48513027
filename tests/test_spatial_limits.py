"""Where the general equations must fall onto poorer models."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.references.spatial import joined, split
from tests.references.spatial_machines import rates, states_of, tilting

import autobalancer as ab
from autobalancer.api import simulate
from autobalancer.assembly.reduced_rotor import top_speed
from autobalancer.assembly.rotors import lateral_model
from autobalancer.assembly.rotors.critical import critical_speeds
from autobalancer.assembly.system import assemble
from autobalancer.errors import MachineError
from autobalancer.files.machine_file import load_machine
from autobalancer.machine import Machine, PlanarRotor

MACHINES = {
    path.stem: machine
    for path in sorted(Path("examples/machines").glob("*.toml"))
    if isinstance(machine := load_machine(path), Machine)
}
PLANAR = [
    name for name, m in MACHINES.items() if m.balancers and isinstance(m.rotor, PlanarRotor) and not assemble(m).general
]


@pytest.mark.parametrize("name", PLANAR)
@pytest.mark.parametrize("rotating", [True, False])
def test_the_general_equations_of_a_planar_rotor_are_the_planar_ones(name: str, rotating: bool) -> None:
    machine = MACHINES[name]
    planar = assemble(machine, rotating=rotating)
    general = assemble(machine, rotating=rotating, general=True)
    assert general.general
    assert not planar.general
    random = np.random.default_rng(1)
    for time in (0.0, 0.7):
        state = planar.state + random.normal(size=planar.state.size) * np.maximum(planar.scale, 1e-6)
        one, other = rates(planar, time, state), rates(general, time, state)
        assert np.all(np.isfinite(one))
        for group in (slice(0, 2), slice(2, 4), slice(4, 6), slice(6, None)):
            scale = np.abs(one[group]).max()
            np.testing.assert_allclose(other[group], one[group], rtol=0.0, atol=1e-13 * scale)


RACE: dict[str, Any] = {
    "orbit_radius": 0.1,
    "drag": {"law": "viscous", "damping": 1e-4},
    "balls": [{"count": 2, "mass": 4e-3, "diameter": 0.01, "start_angles": [1.0, -2.0]}],
}


def planar_and_rigid(*, race_at: float = 0.0, tilt: float = 0.0, **top: Any) -> tuple[Machine, Machine]:
    """The same machine as a planar rotor, and as a rigid one on symmetric supports."""
    common: dict[str, Any] = {
        "name": "one",
        "axis": "horizontal",
        "unbalances": [{"moment": 5e-4, "angle": 0.3}],
        "drive": {"kind": "torque", "torque": 6.0, "damping": 1e-3},
        "start": {"speed": 150.0, "deflection": [1e-4, -2e-4], "velocity": [0.02, 0.01]},
    } | top
    planar = Machine(
        **common,
        rotor={"mass": 5.0, "stiffness": [3e5, 3.6e5], "damping": [60.0, 80.0], "inertia": 0.03},
        balancers=[{"races": [RACE]}],
    )
    support = {"stiffness": [1.5e5, 1.8e5], "damping": [30.0, 40.0], "tilt_stiffness": tilt}
    rigid = Machine(
        **(common | {"unbalances": [common["unbalances"][0] | {"station": race_at}]}),
        rotor={
            "kind": "rigid",
            "mass": 5.0,
            "transverse_inertia": 0.05,
            "polar_inertia": 0.03,
            "supports": [{"position": -0.15, **support}, {"position": 0.15, **support}],
        },
        balancers=[{"station": race_at, "races": [RACE]}],
    )
    return planar, rigid


TIMES = np.linspace(0.0, 0.5, 26)


def test_a_rigid_rotor_with_its_race_at_the_mass_center_moves_like_a_planar_one() -> None:
    planar, rigid = planar_and_rigid()
    one, other = states_of(planar, TIMES), states_of(rigid, TIMES)
    n = one.shape[1]
    np.testing.assert_allclose(other[:, :2], one[:, :2], rtol=0.0, atol=1e-9 * np.abs(one[:, :2]).max())
    np.testing.assert_allclose(other[:, 4:n], one[:, 4:n], rtol=1e-9, atol=1e-9)
    assert np.abs(split(rigid, other)[:, 0, [1, 3]]).max() < 1e-15


def test_a_rigid_rotor_that_cannot_tilt_moves_like_a_planar_one_wherever_its_race_is() -> None:
    """The difference falls with the stiffness against tilting, and at least in inverse proportion."""
    start = {"speed": 150.0, "deflection": [1e-4, -2e-4]}
    planar, _ = planar_and_rigid(start=start)
    one, left = states_of(planar, TIMES), []
    for tilt in (1e6, 4e6):
        _, rigid = planar_and_rigid(race_at=0.06, tilt=tilt, start=start)
        other = states_of(rigid, TIMES, tolerance=1e-11)
        left.append(np.abs(other[:, :2] - one[:, :2]).max() / np.abs(one[:, :2]).max())
    assert left[0] < 1e-3
    assert left[1] < 0.3 * left[0]


@pytest.mark.parametrize("races", ["deflection", "full"])
def test_a_run_in_axes_of_the_rotor_is_that_in_axes_at_rest(races: str) -> None:
    machine = tilting(isotropic=True, tilting_races=races, drive={"kind": "torque", "torque": 8.0, "damping": 0.0})
    one, other = (states_of(machine, TIMES, rotating=rotating) for rotating in (True, False))
    for columns in ([0, 1], [2, 3], [4], [5], range(6, 10), range(10, 14), range(14, 16), range(16, 18)):
        scale = np.abs(other[:, columns]).max()
        np.testing.assert_allclose(one[:, columns], other[:, columns], rtol=0.0, atol=1e-9 * scale)


@pytest.mark.parametrize("share", [1e-4, 1e-2])
def test_balls_along_a_tilting_race_lower_the_conical_frequency_like_a_ring(share: float) -> None:
    """At 120 degrees from each other they add m eps^2/2 to the transverse inertia; else they add nothing to it."""
    alone, full = (conical_frequency(share, races) for races in ("deflection", "full"))
    ring = 0.5 * 5.0 * share * 0.1**2
    assert alone == pytest.approx(np.sqrt(2.0 * 1e5 * 0.1**2 / 0.004), rel=1e-9)
    assert full == pytest.approx(np.sqrt(2.0 * 1e5 * 0.1**2 / (0.004 + ring)), rel=1e-9)
    assert 1.0 - full / alone == pytest.approx(3.1 * share, rel=0.1)


def conical_frequency(share: float, races: str) -> float:
    """Frequency of tilting in one plane of a rotor at rest, balls held by drag that no force overcomes."""
    balls = [
        {
            "count": 3,
            "mass": 5.0 * share / 3,
            "motion": "point",
            "start_angles": [0.2, 0.2 + 2 * np.pi / 3, 0.2 + 4 * np.pi / 3],
        }
    ]
    support = {"stiffness": 1e5, "damping": 0.0}
    machine = Machine(
        name="conical",
        axis="vertical",
        gravity=0.0,
        rotor={
            "kind": "rigid",
            "mass": 5.0,
            "transverse_inertia": 0.004,
            "polar_inertia": 0.004,
            "supports": [{"position": -0.1, **support}, {"position": 0.1, **support}],
        },
        balancers=[{"station": 0.0, "races": [RACE | {"balls": balls}]}],
        tilting_races=races,
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}},
    )
    assembly = assemble(machine)
    size = 2 * 4
    places = [0, 1, 12, 13, 2, 3, 14, 15]
    matrix = np.zeros((size, size))
    for j, place in enumerate(places):
        state = assembly.state.copy()
        state[place] = 1e-6
        matrix[:, j] = rates(assembly, 0.0, state)[places] / 1e-6
    roots = np.linalg.eigvals(matrix)
    return float(np.sort(np.abs(roots.imag))[-1])


TABLE = {"speed": [50.0, 150.0, 400.0], "stiffness": [5e4, (9e4, 7e4), 1.5e5], "damping": [40.0, 20.0, 10.0]}


def tabled(profile: dict[str, Any], support: dict[str, Any]) -> Machine:
    rotor = tilting().rotor.model_dump(exclude_unset=True)
    rotor["supports"] = [rotor["supports"][0], {"position": 0.15, **support}]
    return tilting(rotor=rotor, drive={"kind": "speed", "profile": profile}, tilting_races="full")


@pytest.mark.parametrize(
    ("speed", "stiffness", "damping"),
    [(20.0, 5e4, 40.0), (100.0, (7e4, 6e4), 30.0), (150.0, (9e4, 7e4), 20.0), (275.0, (1.2e5, 1.1e5), 15.0)],
)
def test_supports_from_a_table_are_those_of_the_present_speed(speed: float, stiffness: Any, damping: float) -> None:
    profile = {"kind": "constant", "speed": speed}
    one = tabled(profile, {"table": TABLE})
    other = tabled(profile, {"stiffness": stiffness, "damping": damping})
    random = np.random.default_rng(3)
    first, second = assemble(one, rotating=False), assemble(other, rotating=False)
    # their modes differ, and so do the coordinates behind the first two
    q = np.concatenate(
        [random.normal(size=4) * [1e-3, 1e-2] * 2 if False else random.normal(size=4) * 1e-3, np.ones(5)]
    )
    v = np.concatenate([random.normal(size=4), [speed], random.normal(size=4) * 50.0])
    here = split(one, rates(first, 0.0, joined(one, q, v))[None])
    there = split(other, rates(second, 0.0, joined(other, q, v))[None])
    np.testing.assert_allclose(here, there, rtol=1e-9, atol=1e-9 * np.abs(there).max())


def test_a_run_beyond_its_tables_is_refused() -> None:
    machine = tabled({"kind": "ramp", "start": 0.0, "end": 410.0, "duration": 1.0}, {"table": TABLE})
    assert top_speed(machine) == 410.0
    with pytest.raises(MachineError, match=r"tables over the speed end at 400 rad/s.*up to 410 rad/s.*extend"):
        simulate(machine, duration=0.1)


def test_critical_speeds_of_a_run_are_those_of_the_rotor_with_its_balls() -> None:
    machine = tilting(isotropic=True)
    bare = critical_speeds(lateral_model(machine))
    loaded = assemble(machine).critical_speeds
    assert np.all(np.array(loaded) < bare)
    np.testing.assert_allclose(loaded, bare, rtol=0.01)


def test_check_says_that_weight_acts_on_balls_in_tilting_races() -> None:
    upright = ab.with_parameter(ab.example("two_plane_rotor"), "tilting_races", "full")
    assert any("acts along the axis" in text for text in ab.check(upright).warnings)
    for path, value in (("gravity", 0.0), ("tilting_races", "deflection")):
        assert not any("acts along" in text for text in ab.check(ab.with_parameter(upright, path, value)).warnings)

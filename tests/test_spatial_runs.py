"""Runs of rotors that tilt: starts, results, modes kept, and descriptions that are refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.references.pictures import film_of
from tests.references.spatial import Spatial, start, supports
from tests.references.spatial_machines import tilting
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.api import simulate
from autobalancer.assembly.rotors import lateral_model, reference, rows_at, rows_matrix, unbalance_load
from autobalancer.assembly.rotors.reduction import Reducer
from autobalancer.cli import app
from autobalancer.errors import MachineError
from autobalancer.machine import Machine
from autobalancer.simulation.record import SampleTimes

STILL = {"kind": "speed", "profile": {"kind": "constant", "speed": 0.0}}
TORQUE = {"kind": "torque", "torque": 8.0, "damping": 0.0}


def test_a_pulled_rotor_starts_in_the_shape_that_a_static_force_gives_it() -> None:
    machine = tilting()
    q, _ = start(machine)
    force = supports(machine, 0.0)[0] @ q[:4]
    # what holds it is one force at the first balancer: its moment is the force times the place
    np.testing.assert_allclose(force[[1, 3]], -0.07 * force[[0, 2]], rtol=1e-12)
    found = simulate(machine, duration=0.01, save=SampleTimes([0.0]))
    np.testing.assert_allclose(found.station_x.sel(station="lower"), 2e-4, rtol=1e-12)
    np.testing.assert_allclose(found.station_y.sel(station="lower"), -1e-4, rtol=1e-12)
    np.testing.assert_allclose(found.station_x.sel(station="upper"), q[0] + 0.09 * q[1], rtol=1e-12)
    np.testing.assert_allclose(found.station_y.sel(station="upper"), q[2] + 0.09 * q[3], rtol=1e-12)


def test_a_struck_rotor_turns_about_its_center_of_percussion() -> None:
    """A blow at z leaves the point at -J_t/(M z) where it is."""
    machine = tilting(start={"speed": 0.0, "velocity": [0.1, 0.0]}, balancers=tilting().balancers[:1])
    rest = -0.06 / (5.0 * -0.07)
    stations = [
        {"name": "lower", "position": -0.07},
        {"name": "upper", "position": 0.09},
        {"name": "rest", "position": rest},
    ]
    machine = Machine(
        **(
            machine.model_dump(exclude_unset=True)
            | {"stations": stations, "unbalances": [], "drive": STILL, "start": {"velocity": [0.1, 0.0]}}
        )
    )
    found = simulate(machine, duration=1e-5, tolerance=1e-12, save=SampleTimes([1e-5]))
    assert float(found.x[0]) == pytest.approx(1e-6, rel=1e-2)
    assert abs(float(found.station_x.sel(station="rest")[0])) < 1e-8


@pytest.mark.parametrize("frame", ["rotor", "space"])
def test_a_result_has_the_deflections_of_all_stations_in_space(frame: Any) -> None:
    machine = tilting(isotropic=True, drive=TORQUE)
    times = np.linspace(0.0, 0.3, 7)
    found = simulate(machine, duration=0.3, tolerance=1e-12, frame=frame, save=SampleTimes(times))
    expected = Spatial(machine).run(times)[:, 0]
    for name, z in (("upper", 0.09), ("lower", -0.07)):
        for values, at in ((found.station_x, 0), (found.station_y, 2)):
            place = expected[:, at] + z * expected[:, at + 1]
            np.testing.assert_allclose(values.sel(station=name), place, rtol=0.0, atol=1e-7 * np.abs(place).max())
    np.testing.assert_allclose(found.x, found.station_x.sel(station="lower"), rtol=1e-13)
    assert found.attrs["reference_station"] == "lower"
    assert found.attrs["modes_kept"] == found.attrs["modes_in_all"] == 2
    assert found.attrs["reduction_error"] == 0.0


def test_a_run_survives_the_way_to_the_disk(tmp_path: Path) -> None:
    found = simulate(tilting(), duration=0.1)
    ab.save_run(found, tmp_path / "run.nc")
    again = ab.load_run(tmp_path / "run.nc")
    assert list(again.station.values) == ["upper", "lower"]
    assert again.attrs["reference_station"] == "lower"
    np.testing.assert_array_equal(again.station_x, found.station_x)


def test_the_command_line_runs_draws_and_films_a_rotor_that_tilts(tmp_path: Path) -> None:
    runner = CliRunner()
    result = str(tmp_path / "run.nc")
    for command in (
        ["simulate", "examples/machines/rigid_rotor.toml", "--duration", "1 s", "--out", result],
        ["plot", result, "--out", str(tmp_path)],
        ["animate", result, "--out", str(tmp_path / "run.gif"), "--seconds", "0.4 s", "--fps", "5"],
    ):
        answer = runner.invoke(app, command)
        assert answer.exit_code == 0, answer.output
    assert film_of(tmp_path / "run.gif") == (2, pytest.approx(0.4), (960, 544))
    assert len(list(tmp_path.glob("*.png"))) >= 2


@pytest.mark.parametrize("name", ["upper", "lower"])
def test_the_error_of_a_reduction_bounds_what_it_leaves_out_of_an_unbalance_response(name: str) -> None:
    """With one pair of modes of two, at speeds between those at which it was found."""
    machine = tilting(isotropic=True, balancers=[])
    model = lateral_model(machine)
    front, places = reference(machine, model)[1], rows_matrix([rows_at(machine, model, name)])
    load = unbalance_load(machine, model)
    small = Reducer(model, front, places, 150.0, 1, isotropic=True).carrying(load)
    assert small.kept == 1
    assert 1e-3 < small.error < 1.0
    seen = model.both(places)
    pushed = np.concatenate([load, -1j * load])
    for speed in np.linspace(1.0, 149.0, 200):
        dynamic = model.stiffness_at(speed) + 1j * speed * (model.damping_at(speed) + speed * model.gyroscopic)
        dynamic = dynamic - speed**2 * model.mass
        whole = seen @ np.linalg.solve(dynamic, np.column_stack([seen.T, pushed]))
        basis = small.basis
        part = seen @ basis @ np.linalg.solve(basis.T @ dynamic @ basis, basis.T @ np.column_stack([seen.T, pushed]))
        assert np.linalg.norm(whole - part) <= 1.05 * small.error * np.linalg.norm(whole)


def test_too_few_modes_are_refused_by_name() -> None:
    machine = tilting()
    model = lateral_model(machine)
    front = reference(machine, model)[1]
    with pytest.raises(MachineError, match=r"rotor\.modes: given 0; at least 1 is needed"):
        Reducer(model, front, rows_matrix([front]), 200.0, 0, isotropic=True).carrying(unbalance_load(machine, model))


RACE = {
    "orbit_radius": 0.1,
    "drag": {"law": "viscous", "damping": 1e-4},
    "balls": [{"count": 1, "mass": 1e-3, "motion": "point"}],
}
RIGID = {
    "kind": "rigid",
    "mass": 5.0,
    "transverse_inertia": 0.06,
    "polar_inertia": 0.03,
    "supports": [{"position": -0.1, "stiffness": 1e5}, {"position": 0.1, "stiffness": 1e5}],
}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"unbalances": [{"moment": 1e-4, "station": "midle"}]}, r"unbalances.*no station is named 'midle'.*'disk'"),
        (
            {"balancers": [{"station": "midle", "races": [RACE]}]},
            r"balancers.*no station is named 'midle'; there is 'disk'",
        ),
        ({"stations": [{"name": "disk", "position": 0}] * 2}, r"'disk' is given twice"),
        ({"unbalances": [{"couple": 1e-5, "moment": 1e-4}]}, r"either 'moment'.*or 'couple'"),
        ({"rotor": RIGID | {"polar_inertia": 0.13}}, r"polar_inertia: given 0\.13.*twice.*0\.12"),
        (
            {"rotor": RIGID | {"supports": RIGID["supports"][:1]}},
            r"nothing supports the rotor against tilting.*two positions",
        ),
        ({"rotor": RIGID | {"supports": [{"position": 0.1}]}}, r"stiffness: missing"),
        (
            {"rotor": {"mass": 5.0, "stiffness": 1e5, "damping": 1.0}, "unbalances": [{"couple": 1e-5}]},
            r"a planar rotor does not tilt and feels no couple",
        ),
        (
            {
                "rotor": {"mass": 5.0, "stiffness": 1e5, "damping": 1.0},
                "unbalances": [{"moment": 1e-5, "station": 0.1}],
            },
            r"a planar rotor has one plane only",
        ),
    ],
)
def test_an_impossible_rotor_is_refused_with_the_place_named(change: dict[str, Any], words: str) -> None:
    data = {
        "name": "bad",
        "axis": "vertical",
        "rotor": RIGID,
        "stations": [{"name": "disk", "position": 0.02}],
        "drive": STILL,
    }
    with pytest.raises(ValueError, match=f"(?s){words}"):
        Machine(**(data | change))


def test_a_station_with_a_body_is_refused_on_a_rotor_of_one_body() -> None:
    data = tilting().model_dump(exclude_unset=True)
    data["stations"] = [*data["stations"], {"name": "third", "position": 0.0, "body": "disc"}]
    with pytest.raises(MachineError, match=r"stations\[3\].*body 'disc': a rigid rotor is one body"):
        simulate(Machine(**data), duration=0.01)

"""Asking for the flow in a race: geometry, choice of the model, refusals, result, picture and command."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np
import pytest
from tests.references.pictures import size_of
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.cli import app
from autobalancer.errors import MachineError, QuestionError
from autobalancer.files.machine_file import load_race_machine
from autobalancer.flow import solve
from autobalancer.flow.annulus import Annulus, annulus_of
from autobalancer.flow.annulus_problem import annulus_flow
from autobalancer.flow.relaxation import SpinUp, spin_up, wall_speed
from autobalancer.machine import Ramp, Table
from autobalancer.results.store import load_run, save_run

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
RIG = Annulus(69.3e-3, 83.1e-3, 20e-3, 76.95e-3, 715e-6, 970.0)


def test_balls_touch_the_outer_wall_of_the_annulus() -> None:
    """Spannan 2021, table 6.2: orbit 76.95 mm, ball 12.3 mm, width 13.8 mm, height 20 mm."""
    annulus = annulus_of(load_race_machine(MACHINES / "discoidal.toml"))
    assert annulus.outer == pytest.approx(76.95e-3 + 6.15e-3, rel=1e-12)
    assert annulus.inner == pytest.approx(83.1e-3 - 13.8e-3, rel=1e-12)
    assert (annulus.height, annulus.viscosity) == pytest.approx((20e-3, 20e-6))


@pytest.mark.parametrize(
    ("changed", "value", "says"),
    [
        ("width", 0.012, "negative"),
        ("width", None, "width: missing"),
        ("height", None, "height: missing"),
        ("width", 0.09, "inner wall"),
    ],
)
def test_a_chamber_that_is_no_annulus_is_refused(changed: str, value: float | None, says: str) -> None:
    machine = load_race_machine(MACHINES / "discoidal.toml")
    race = machine.balancers[0].races[0].model_copy(update={changed: value})
    balancer = machine.balancers[0].model_copy(update={"races": (race,)})
    with pytest.raises(MachineError, match=rf"(balancers\[1\].races\[1\])?.*({says}|does not fit)"):
        annulus_of(machine.model_copy(update={"balancers": (balancer,)}))


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"viscosity": 0.0}, "viscosity of 0"),
        ({"inner": 0.09}, "inner wall"),
        ({"orbit_radius": 0.05}, "orbit radius"),
        ({"height": -1.0}, "height"),
        ({"density": 0.0}, "density"),
    ],
)
def test_an_impossible_annulus_is_refused(wrong: dict[str, float], says: str) -> None:
    with pytest.raises(MachineError, match=says):
        replace(RIG, **wrong)


def test_a_grid_too_coarse_for_the_ekman_layers_is_refused_with_the_number_needed() -> None:
    """Layers of 0.1 mm on 20 mm."""
    thin = replace(RIG, viscosity=0.65e-6)
    with pytest.raises(
        QuestionError, match=r"given 12 in radial direction.*0\.104 mm thin.*take at least (\d+)"
    ) as found:
        annulus_flow(thin, 60.0, duration=1.0, model="chebyshev", points=(12, 16))
    least = int(str(found.value).split("take at least ")[1].split()[0])
    assert least > 12
    with pytest.raises(QuestionError, match="axial"):
        annulus_flow(thin, 60.0, duration=1.0, model="chebyshev", points=(max(least, 12), 12))


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ({"duration": 0.0}, "duration"),
        ({}, "duration: missing"),
        ({"duration": 1.0, "times": [2.0]}, "times"),
        ({"duration": 1.0, "model": "exact"}, "model"),
        ({"duration": 1.0, "samples": 1}, "samples"),
        ({"duration": 1.0, "error": 0.0}, "error"),
    ],
)
def test_a_question_without_sense_is_refused(options: dict[str, object], says: str) -> None:
    with pytest.raises(QuestionError, match=says):
        annulus_flow(RIG, 5.0, **options)  # type: ignore[arg-type]


def test_a_rotor_driven_by_a_torque_needs_a_speed() -> None:
    machine = load_race_machine(MACHINES / "discoidal.toml")
    machine = with_value_at(with_value_at(machine, "rotor.inertia", 0.1), "drive", {"kind": "torque", "torque": 1.0})
    with pytest.raises(QuestionError, match="torque"):
        annulus_flow(machine)
    assert annulus_flow(machine, 1e-3, duration=0.1, samples=5).attrs["model"] == "modes"


@pytest.mark.parametrize("aspect", [0.5, 1.5])
@pytest.mark.parametrize("ratio", [0.05, 0.3, 1.0])
def test_diffusion_alone_is_chosen_only_where_it_is_as_good_as_promised(aspect: float, ratio: float) -> None:
    """Impulsive start and ramp, rotor speed over the slowest decay rate from 0.05 to 1."""
    annulus = Annulus(0.083 - 0.02 * aspect, 0.083, 0.02, 0.083 - 0.008 * aspect, 100e-6, 950.0)
    speed, time = ratio * annulus.decay_rate, 1.0 / annulus.decay_rate
    for profile, initial in ((speed, 0.0), (Ramp(end=speed, duration=3.0 * time), None)):
        full = annulus_flow(annulus, profile, duration=5.0 * time, initial_speed=initial, model="chebyshev", error=1e-4)
        late = full["time"].values > 0.05 * time  # just after a jump a finite number of modes rings
        seen = float(np.abs(full["fluid_speed"] - full["diffusion_speed"]).values[late].max()) / speed
        promised = float(full.attrs["error_of_diffusion"])
        assert seen <= promised + 3e-4
        assert seen >= 0.1 * promised - 3e-4
        chosen = annulus_flow(annulus, profile, duration=5.0 * time, initial_speed=initial, error=0.01)
        assert chosen.attrs["model"] == ("modes" if promised <= 0.01 else "chebyshev")


def test_behind_a_slow_ramp_the_lag_is_that_of_the_closed_form() -> None:
    ramp = Ramp(end=0.1, duration=1.0)
    full = annulus_flow(RIG, ramp, duration=1.0, model="chebyshev", error=1e-5)
    lag = float(full["speed"][-1] - full["fluid_speed"][-1])
    assert lag == pytest.approx(float(full["speed"][-1] - full["diffusion_speed"][-1]), rel=1e-4)
    assert lag == pytest.approx(0.1 * 0.92113576 * 20e-6 / 715e-6, rel=1e-3)  # the lag scales with 1/nu
    assert full.attrs["model"] == "chebyshev"


def test_solid_rotation_needs_no_solver() -> None:
    flow = annulus_flow(RIG, 60.0, duration=1.0)
    assert flow.attrs["model"] == "modes"
    assert float(np.abs(flow["relative_velocity"]).max()) == 0.0
    assert math.isnan(flow.attrs["spin_up_time"])


def test_fields_hold_the_fluid_at_the_walls_and_are_kept_when_asked_for(tmp_path: Path) -> None:
    times = [0.0, 0.004, 0.02]
    for model in ("modes", "chebyshev"):
        flow = annulus_flow(RIG, 20.0, initial_speed=0.0, duration=0.04, times=times, model=model)  # type: ignore[arg-type]
        assert flow["moment"].values.tolist() == times
        swirl = flow["fluid_angular_velocity"].values[1:]
        for wall in (swirl[:, 0], swirl[:, -1], swirl[:, :, 0], swirl[:, :, -1]):
            assert np.abs(wall - 20.0).max() < 1e-9
        again = load_run(save_run(flow, tmp_path / f"{model}.nc"))
        assert np.array_equal(again["fluid_speed"].values, flow["fluid_speed"].values)
        for name in flow.variables:
            assert flow[name].attrs["units"]


def test_both_models_agree_on_a_slow_and_viscous_spin_up() -> None:
    full, diffusion = (
        annulus_flow(RIG, 3.0, initial_speed=0.0, duration=0.05, model=model, times=[0.02])  # type: ignore[arg-type]
        for model in ("chebyshev", "modes")
    )
    assert np.abs(diffusion["fluid_speed"] - full["fluid_speed"]).values[20:].max() < 2e-3 * 3.0
    assert diffusion.attrs["spin_up_time"] == pytest.approx(full.attrs["spin_up_time"], rel=5e-3)
    assert diffusion["fluid_angular_velocity"].interp(radius=0.076, height=0.01).item() == pytest.approx(
        full["fluid_angular_velocity"].interp(radius=0.076, height=0.01).item(), rel=0.02
    )


def test_the_table_for_the_balls_gives_back_the_fluid() -> None:
    flow = annulus_flow(RIG, Ramp(end=20.0, duration=0.1), duration=0.2)
    table = spin_up(flow)
    assert isinstance(table, SpinUp)
    assert table.at(flow["time"].values) == pytest.approx(flow["fluid_speed"].values)
    assert float(table.at(1e3)) == float(flow["fluid_speed"][-1])


def test_corners_of_a_profile_are_met_exactly() -> None:
    profile = Table(time=(0.0, 0.0137, 0.0291, 0.06), speed=(0.0, 4.0, 4.0, 0.0))
    assert wall_speed(profile).corners(0.05) == [0.0137, 0.0291]
    full = annulus_flow(RIG, profile, duration=0.06, model="chebyshev", error=1e-4)
    assert np.abs(full["fluid_speed"] - full["diffusion_speed"]).values.max() < 2e-3 * 4.0
    # a rotor that slows down is overtaken by its fluid
    assert float(full["fluid_speed"][-1] - full["speed"][-1]) > 0.0


def test_pictures_show_every_kind_of_result() -> None:
    for model in ("modes", "chebyshev"):
        flow = annulus_flow(RIG, 60.0, initial_speed=0.0, duration=0.05, times=[0.0, 0.005, 0.02], model=model)  # type: ignore[arg-type]
        figure = ab.plot.answer(flow, speed_unit="rad/s")
        assert len(figure.axes) == 5  # four panels and the scale of the colors
        labels = [text.get_text() for text in figure.axes[0].get_legend().get_texts()]
        assert labels == ["rotor", "fluid at the orbit", "diffusion alone"]
        ab.plot.answer(flow, "spin_up")
        assert len(ab.plot.answer(flow, "velocity_profiles", moments=[0.005]).axes[0].lines) == 3
        ab.plot.answer(flow, "secondary_flow", time=0.02)
        with pytest.raises(QuestionError, match=r"0, 0\.005, 0\.02"):
            ab.plot.answer(flow, "secondary_flow", time=0.03)


def test_the_command_prints_a_table_or_numbers_and_writes_files(tmp_path: Path) -> None:
    run = CliRunner()
    command = ["annulus-flow", str(MACHINES / "discoidal.toml"), "--speed", "30 rpm", "--initial-speed", "0 rpm"]
    command += ["--duration", "0.5 s", "--time", "0.1 s", "--points", "12x14", "--model", "chebyshev"]
    out = run.invoke(app, [*command, "--plot", str(tmp_path / "flow.png"), "--out", str(tmp_path / "flow.nc")])
    assert out.exit_code == 0, out.output
    assert "spin-up time" in out.output
    assert size_of(tmp_path / "flow.png") == (1440, 960)
    said = run.invoke(app, [*command, "--json"])
    numbers = json.loads(said.stdout)
    assert numbers["model"] == "chebyshev"
    assert numbers["points"] == [12, 14]
    assert len(numbers["fluid_speed"]) == 501
    assert run.invoke(app, [*command, "--points", "12"]).exit_code != 0


def test_thin_oil_in_a_fast_run_up_is_solved_and_says_how_certain_it_is() -> None:
    """5 mm^2/s, to 60 rad/s within a second: the layer at the inner wall breaks up."""
    thin = replace(RIG, viscosity=5e-6)
    flow = annulus_flow(thin, Ramp(end=60.0, duration=1.0), duration=1.2, samples=121)
    assert flow.attrs["model"] == "chebyshev"
    other = annulus_flow(thin, Ramp(end=60.0, duration=1.0), duration=1.2, samples=121, points=(40, 48))
    apart = float(np.abs(flow["fluid_speed"] - other["fluid_speed"]).max()) / 60.0
    assert 0.4 * apart < flow.attrs["uncertainty"] < 2.5 * apart
    steady = annulus_flow(replace(RIG, viscosity=100e-6), Ramp(end=60.0, duration=1.0), duration=1.2)
    assert steady.attrs["uncertainty"] == 0.0


def test_a_flow_that_would_take_long_is_refused_at_once_with_what_to_do() -> None:
    thin = replace(RIG, viscosity=0.3e-6)
    start = process_time()
    with pytest.raises(
        QuestionError, match=r"lag by about .* turbulent .* minutes; speed up more slowly.*'modes'.*'points'"
    ):
        annulus_flow(thin, Ramp(end=2000.0, duration=60.0), duration=80.0)
    assert process_time() - start < 5.0


def test_too_few_points_are_replaced_by_more_unless_they_were_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    thin, ramp = replace(RIG, viscosity=0.65e-6), Ramp(end=60.0, duration=1.0)
    monkeypatch.setattr(solve, "chosen_points", lambda *_: (30, 36))
    monkeypatch.setattr(solve, "EDDIES", 0.0)
    flow = annulus_flow(thin, ramp, duration=0.4, samples=51)
    assert flow.attrs["points"][0] > 30
    with pytest.raises(QuestionError, match="cannot continue past"):
        annulus_flow(thin, ramp, duration=0.4, points=(30, 36))

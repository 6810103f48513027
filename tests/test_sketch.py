"""The drawing of a machine before it runs."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.files.examples import rig
from autobalancer.sketch import chamber_layout, layout_of

MACHINES = Path(__file__).resolve().parent.parent / "examples" / "machines"
DRAWN = sorted(path.stem for path in MACHINES.glob("*.toml") if path.stem not in ("design", "equilibrium_angle"))

QUICK = (
    "discoidal",
    "two_plane_rotor",
    "pendulums",
    "liquid_ring",
    "deep_chamber",
    "chamber_cylinders",
    "resolved_balls",
)


@pytest.mark.parametrize("name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in DRAWN])
def test_every_sample_machine_is_drawn(name: str) -> None:
    figure = ab.plot.machine(MACHINES / f"{name}.toml")
    assert isinstance(figure, Figure)
    figure.draw_without_rendering()


@pytest.mark.parametrize("name", ["cfrp_rig", "discoidal_rig"])
def test_every_published_rig_is_drawn(name: str) -> None:
    ab.plot.machine(rig(name)).draw_without_rendering()


def test_the_body_of_a_rigid_rotor_has_its_mass_and_inertias() -> None:
    machine = ab.load_machine(MACHINES / "two_plane_rotor.toml")
    layout = layout_of(machine)
    body = max(layout.blocks, key=lambda block: block.radius)
    length, mass = body.end - body.start, machine.rotor.mass
    assert 0.5 * mass * body.radius**2 == pytest.approx(machine.rotor.polar_inertia)
    assert mass * (body.radius**2 / 4.0 + length**2 / 12.0) == pytest.approx(machine.rotor.transverse_inertia)
    assert body.start + body.end == pytest.approx(0.0)


def test_a_shaft_is_as_long_as_its_segments_and_balancers_are_at_their_stations() -> None:
    machine = rig("cfrp_rig")
    layout = layout_of(machine)
    segments = [block for block in layout.blocks if block.known]
    assert segments[-1].end == pytest.approx(machine.rotor.length)
    assert layout.planes == [{name: place for place, name in layout.stations}["annulus"]]
    material = machine.rotor.material
    volume = sum(math.pi * (b.radius**2 - b.bore**2) * (b.end - b.start) for b in segments)
    disks = sum(float(disk.mass) for disk in machine.rotor.disks)
    assert volume * float(material.density) + disks == pytest.approx(machine.rotor.mass)


def test_the_balls_of_a_chamber_are_to_scale() -> None:
    machine = ab.load_machine(MACHINES / "deep_chamber.toml")
    filling = chamber_layout(machine).fillings[0]
    group = machine.chambers[0].balls[0]
    assert group.count * group.density * 4.0 / 3.0 * math.pi * filling.ball_radius**3 == pytest.approx(1.0)
    assert filling.end - filling.start == pytest.approx(0.2)


def test_the_command_draws_a_machine_file_and_refuses_what_has_no_meaning_for_it(tmp_path: Path) -> None:
    made = tmp_path / "machine.png"
    found = CliRunner().invoke(app, ["plot", str(MACHINES / "discoidal.toml"), "--out", str(made)])
    assert found.exit_code == 0, found.output
    assert made.stat().st_size > 10_000
    wrong = CliRunner().invoke(app, ["plot", str(MACHINES / "discoidal.toml"), "--time", "1 s", "--out", str(made)])
    assert wrong.exit_code == 2
    assert "no meaning" in wrong.output

"""Pictures of rotors with several planes, of horizontal machines, of many balls: each thing is drawn where it belongs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.patches import FancyArrowPatch
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.assembly.quantities import with_value_at
from autobalancer.cli.main import app
from autobalancer.machine import Machine
from autobalancer.plots.run.history import ball_looks, planes_of, static_part
from autobalancer.plots.run.race_and_orbit import Vector, vectors_of
from autobalancer.plots.style import label_level, label_point, labels_of, picture, stacked
from autobalancer.results.drawn import Motion, races_of
from autobalancer.simulation.record import Envelope, LastRevolutions, Samples

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
SAVE = (Samples(601), Envelope(200), LastRevolutions(4))


@pytest.fixture(scope="module")
def two() -> xr.Dataset:
    return ab.simulate(MACHINES / "two_plane_rotor.toml", duration=6.0, save=SAVE)


@pytest.fixture(scope="module")
def drum() -> xr.Dataset:
    """A horizontal machine with eight balls of 33 g in two races on 12 kN/m, above its critical speed."""
    ball = {"count": 4, "mass": 0.033, "diameter": 0.02}
    races = [
        {"orbit_radius": radius, "drag": {"law": "viscous", "damping": 5e-3}, "balls": [ball]} for radius in (0.23, 0.2)
    ]
    machine = Machine(
        name="drum",
        axis="horizontal",
        rotor={"mass": 25.0, "stiffness": 12e3, "damping": 200.0},
        unbalances=[{"moment": 0.02}],
        balancers=[{"races": races}],
        drive={"kind": "speed", "profile": {"kind": "constant", "speed": 120.0}},
    )
    return ab.simulate(machine, duration=6.0, save=SAVE)


def vectors(run: xr.Dataset, plane: int) -> list[Vector]:
    return vectors_of(races_of(run), Motion(run).at(run.time.values[-1:]), planes_of(run), plane)


def words(figure: Figure, panel: int) -> str:
    axes = figure.axes[panel]
    legend = axes.get_legend()
    keys = [] if legend is None else [text.get_text() for text in legend.get_texts()]
    return " | ".join([axes.get_title("left"), *(text.get_text() for text in axes.texts), *keys])


def test_the_balls_of_a_plane_are_drawn_against_the_unbalance_of_this_plane(two: xr.Dataset) -> None:
    state = ab.stability.equilibria(MACHINES / "two_plane_rotor.toml", float(two.speed[-1]))
    needed = state.required_moment.values * np.exp(1j * state.required_moment_angle.values)
    for plane in (0, 1):
        *_, unbalance, balls, resultant = vectors(two, plane)
        assert unbalance.value == pytest.approx(-needed[plane], rel=1e-6)
        assert balls.value == pytest.approx(needed[plane], rel=1e-2)
        assert abs(resultant.value) < 0.01 * abs(needed[plane])
    figure = ab.plot.race(two)
    assert "lower balancer" in words(figure, 0)
    assert "unbalance in this plane 33.4 g mm" in words(figure, 0)
    assert "upper balancer" in words(figure, 1)
    assert "unbalance in this plane 82.7 g mm" in words(figure, 1)


def test_a_couple_unbalance_is_a_pair_of_opposite_vectors_its_positive_one_at_greater_z(two: xr.Dataset) -> None:
    lower, upper = vectors(two, 0)[0], vectors(two, 1)[0]
    assert lower.dashed
    assert upper.value == pytest.approx(1e-5 / 0.25 * np.exp(1j * np.deg2rad(60.0)))
    assert lower.value == -upper.value
    without = with_value_at(ab.load_machine(MACHINES / "two_plane_rotor.toml"), "unbalances[2].couple", 0.0)
    alone = ab.simulate(without, duration=0.05, save=Samples(11))
    change = vectors(two, 1)[1].value - vectors(alone, 1)[0].value
    assert change == pytest.approx(upper.value, rel=1e-6)


def test_each_plane_shows_its_own_deflection(two: xr.Dataset) -> None:
    shown = Motion(two).at(np.array([0.2])).plane_deflection_in_rotor[0]
    assert abs(shown[0]) != pytest.approx(abs(shown[1]), rel=0.1)
    figure = ab.plot.race(two, time=0.2)
    for plane in (0, 1):
        assert f"plane deflected {1e6 * abs(shown[plane]):.3g} µm" in words(figure, plane)


def test_a_run_up_of_two_planes_has_the_angles_of_each_and_the_deflection_of_both(two: xr.Dataset) -> None:
    figure = ab.plot.run_up(two)
    assert len(figure.axes) == 4
    labels = [str(line.get_label()) for line in figure.axes[1].get_lines()]
    assert {"greatest, lower balancer", "upper balancer"} <= set(labels)
    upper = next(line for line in figure.axes[1].get_lines() if line.get_label() == "upper balancer")
    assert np.asarray(upper.get_ydata())[-1] == pytest.approx(float(np.hypot(two.plane_x, two.plane_y)[-1, 1]))
    for panel, balls, plane in ((2, {"ball 1", "ball 2"}, 0), (3, {"ball 3", "ball 4"}, 1)):
        lines = {str(line.get_label()): np.asarray(line.get_ydata()) for line in figure.axes[panel].get_lines()}
        assert {name for name in lines if name.startswith("ball")} == balls
        angle = np.rad2deg(two.plane_unbalance_angle_in_rotor.values[-1, plane])
        assert lines["unbalance"][-1] == pytest.approx(angle)


def test_the_orbit_of_each_plane_has_its_panel_and_one_scale(two: xr.Dataset) -> None:
    figure = ab.plot.orbit(two, start=0.5, end=0.8)
    assert [panel.get_title("left") for panel in figure.axes] == ["lower balancer", "upper balancer"]
    assert figure.axes[0].get_xlim() == figure.axes[1].get_xlim()
    assert len(ab.plot.orbit(two, place="upper balancer").axes) == 1
    with pytest.raises(ab.errors.QuestionError, match="'lower balancer', 'upper balancer'"):
        ab.plot.orbit(two, place="middle")


def test_the_orbit_of_a_quiet_plane_has_a_scale_of_its_own(two: xr.Dataset) -> None:
    figure = ab.plot.orbit(two)  # in the end the upper plane is far better balanced
    quiet, loud = figure.axes[1], figure.axes[0]
    size = 1e9 * np.hypot(two["turn_place_x"].values, two["turn_place_y"].values).max(axis=0).min()
    larger = loud.get_xlim()[1] / quiet.get_xlim()[1]
    assert larger >= 5.0
    assert quiet.get_title("left") == f"upper balancer, drawn {larger:g} times larger"
    assert size < quiet.get_xlim()[1] < 5.0 * size
    assert "(nm)" in quiet.get_xlabel()


def tips(figure: Figure, panel: int) -> list[complex]:
    """Ends of the arrows of unbalance and balls, mm on the page."""
    drawn = [patch for patch in figure.axes[panel].patches if isinstance(patch, FancyArrowPatch)]
    return [complex(*patch.get_path().vertices[2]) for patch in drawn]


def test_arrows_of_a_quiet_plane_are_longer_by_the_factor_that_its_panel_gives() -> None:
    near = with_value_at(ab.load_machine(MACHINES / "two_plane_rotor.toml"), "unbalances[1].station", "-92 mm")
    near = with_value_at(near, "unbalances[2].couple", "1e-6 kg*m^2")
    run = ab.simulate(near, duration=0.3, save=(Samples(31),))
    figure = ab.plot.race(run)
    note = next(line for line in words(figure, 1).splitlines() if "arrows" in line)
    longer = float(note.split("arrows ")[1].split()[0])
    assert longer >= 2.0
    assert "times as long as for lower balancer" in note
    assert "arrows" not in words(figure, 0)
    sizes = [max(abs(vector.value) for vector in vectors(run, plane)) for plane in (0, 1)]
    loud, quiet = (max(map(abs, tips(figure, panel))) for panel in (0, 1))
    assert quiet / loud == pytest.approx(longer * sizes[1] / sizes[0], rel=0.05)  # heads have one size
    alone = ab.plot.race(run, balancer=2)
    assert "arrows" not in words(alone, 0)
    assert max(map(abs, tips(alone, 0))) == pytest.approx(loud, rel=0.01)


def test_keys_of_the_race_fit_into_their_panel(two: xr.Dataset) -> None:
    figure = ab.plot.race(two.assign(couple_unbalance=0.0 * two.couple_unbalance))
    figure.draw_without_rendering()
    left, right = (axes.get_legend().get_window_extent() for axes in figure.axes)
    assert left.x1 < right.x0 - 5.0
    wide = max(axes.get_window_extent().width for axes in figure.axes)
    assert wide > 0.9 * 0.5 * figure.bbox.width  # keys that are too wide make the races small


def test_the_command_draws_the_orbit_of_one_place_alone(two: xr.Dataset, tmp_path: Path) -> None:
    ab.save_run(two, tmp_path / "two.nc")
    drawn = {}
    for place in ("", "upper balancer"):
        out = tmp_path / f"orbit{len(drawn)}.png"
        answer = CliRunner().invoke(
            app, ["plot", str(tmp_path / "two.nc"), "--kind", "orbit", "--out", str(out), "--place", place]
        )
        assert answer.exit_code == 0
        drawn[place] = imread(out)
    assert drawn["upper balancer"].shape[1] < 0.7 * drawn[""].shape[1]  # one panel in place of two
    other = CliRunner().invoke(app, ["plot", str(tmp_path / "two.nc"), "--out", str(tmp_path), "--place", "middle"])
    assert other.exit_code == 2
    assert "the run has 'lower balancer', 'upper balancer'" in other.stderr


def test_pictures_of_a_horizontal_machine_tell_vibration_from_static_deflection(drum: xr.Dataset) -> None:
    static = 8 * 0.033 * 9.80665 / 12e3
    figure = ab.plot.orbit(drum)
    assert f"y = −{1e6 * static:.0f} µm" in words(figure, 0)
    assert figure.axes[0].get_xlim()[1] * 1e-6 < 0.5 * static
    assert f"static deflection of {1e6 * static:.0f} µm at −90°" in words(ab.plot.race(drum), 0)
    panel = ab.plot.run_up(drum).axes[1]
    vibration = next(line for line in panel.get_lines() if str(line.get_label()).startswith("vibration about"))
    z = drum.x.values + 1j * drum.y.values
    last = np.abs(z + 1j * static)[-1]
    assert np.asarray(vibration.get_ydata())[-1] == pytest.approx(last, abs=1e-3 * static)


def test_more_balls_than_colors_have_one_color_for_each_race(drum: xr.Dataset) -> None:
    looks = ball_looks(drum)
    assert [ball.label for ball in looks if ball.label != "_"] == ["balls 1 to 4, race 1", "balls 5 to 8, race 2"]
    assert len({ball.color for ball in looks}) == 8


def test_numbers_of_balls_are_on_the_balls_of_their_race(drum: xr.Dataset) -> None:
    figure = ab.plot.race(drum)
    places = {text.get_text(): text.get_position() for text in figure.axes[0].texts}
    angle = drum.ball_angle_in_rotor.values[-1]
    for ball in range(8):
        expected = 1e3 * float(drum.orbit_radius[ball]) * np.exp(1j * angle[ball])
        assert complex(*places[str(ball + 1)]) == pytest.approx(expected)


def test_a_vibration_that_is_none_is_a_dot_with_a_number(two: xr.Dataset) -> None:
    still = two.drop_dims("turn").assign({name: 1e-14 * two[name] for name in ("x", "y", "plane_x", "plane_y")})
    figure = ab.plot.orbit(still.drop_vars(["station_x", "station_y"]))
    assert "< 0.01 nm" in words(figure, 0)
    assert all(np.size(line.get_xdata()) == 1 for line in figure.axes[0].get_lines())


def test_labels_of_close_levels_and_of_points_do_not_cover_one_another() -> None:
    figure = picture(5.0, 3.0)
    axes = figure.subplots()
    axes.set(xlim=(0.0, 1.0), ylim=(0.0, 100.0))
    for level in (40.0, 41.0, 41.5, 80.0):
        label_level(axes, f"critical speed {level:g} rpm", level)
    for place in (0.3, 0.31, 0.32):
        label_point(axes, f"crossing at {place:g}", place, 20.0)
    figure.canvas.draw()
    boxes = labels_of(axes).placed
    assert len(boxes) == 7
    for i, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[:i])
        assert axes.get_window_extent().containsx(one.x0)
        assert axes.get_window_extent().containsy(one.y1)


def test_stacks_stand_at_or_above_their_places_and_below_the_edge() -> None:
    assert stacked(np.array([0.0, 10.0]), 5.0, 90.0).tolist() == [0.0, 10.0]
    assert stacked(np.array([8.0, 10.0, 11.0]), 5.0, 90.0).tolist() == [11.0, 16.0, 21.0]
    assert stacked(np.array([88.0, 89.0]), 5.0, 90.0).tolist() == [85.0, 90.0]


def test_the_run_up_shows_the_machine_without_balancing_beside_it(drum: xr.Dataset) -> None:
    panel = ab.plot.run_up(drum).axes[1]
    reference = next(line for line in panel.get_lines() if line.get_label() == "without balancing")
    assert panel.get_ylabel() == "deflection"  # logarithmic: each tick has its unit
    assert np.asarray(reference.get_ydata()) == pytest.approx(float(drum.vibration_without_balls[0]))
    held = ab.simulate(ab.load_machine(MACHINES / "two_plane_rotor.toml"), duration=0.2, hold_balls=True, save=SAVE)
    whole = next(
        line for line in ab.plot.run_up(held, held=held).axes[1].get_lines() if line.get_label() == "without balancing"
    )
    assert np.asarray(whole.get_ydata()) == pytest.approx(1e6 * held.envelope_high.values)


def test_without_balancing_at_the_end_of_a_ramp_is_a_mark_that_can_be_seen() -> None:
    ramp = {"kind": "ramp", "start": 900.0, "end": 1100.0, "duration": 2.0}
    machine = ab.with_parameter(ab.example("discoidal"), "drive.profile", ramp)
    panel = ab.plot.run_up(ab.simulate(machine, duration=2.0, progress=False)).axes[1]
    (mark,) = (line for line in panel.get_lines() if line.get_marker() == "_")
    assert mark.get_markersize() > 10.0
    words = [label.text.get_text() for label in labels_of(panel).entries]
    assert any("without balancing at the last speed" in text for text in words)


def test_the_end_of_a_part_of_a_run_is_named_by_its_time(two: xr.Dataset) -> None:
    end = float(two.attrs["end_time"])
    for until, when in ((end, "at the end"), (0.75 * end, f"at {0.75 * end - 0.015:.4g} s")):
        texts = [label.text.get_text() for label in labels_of(ab.plot.run_up(two, end=until).axes[1]).entries]
        assert any(when in text for text in texts)
        assert any("at the end" in text for text in texts) == (until == end)


def test_a_whirl_that_grows_has_no_static_part() -> None:
    time = np.linspace(0.0, 1.0, 2001)
    angle = 2.0 * np.pi * 25.0 * time
    run = xr.Dataset(attrs={"axis": "horizontal", "static_load": "weight"})
    whirl = 1e-3 * np.exp(16.0 * (time - 1.0) + 1j * angle)
    assert static_part(run, time, angle, whirl, 1.0) == 0.0
    still = -1e-3j + 1e-4 * np.exp(1j * angle)
    assert static_part(run, time, angle, still, 1.0) == pytest.approx(-1e-3j, rel=1e-9)

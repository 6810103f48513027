"""Pictures: what is drawn is what the result says."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from PIL import Image
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.errors import QuestionError
from autobalancer.plots.run.history import BallLook, CriticalSpeeds, Curve, Deflections, History
from autobalancer.plots.run.run_up import deflection_panel, speed_panel
from autobalancer.plots.style import UNBALANCE, labels_of, picture, save_picture, slipping, wrapped
from autobalancer.results.display_units import length_axis, length_text, round_down, speed_axis
from autobalancer.results.drawn import Motion, races_of
from autobalancer.simulation.record import Envelope, LastRevolutions, Samples, SampleTimes

MACHINES = Path(__file__).parents[1] / "examples" / "machines"


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return ab.simulate(
        MACHINES / "stall_and_release.toml", save=(Samples(801), Envelope(400), LastRevolutions(4, per_revolution=36))
    )


def lines(figure: Figure, panel: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {str(line.get_label()): (line.get_xdata(), line.get_ydata()) for line in figure.axes[panel].get_lines()}


def test_the_speed_panel_has_rotor_and_balls_in_the_unit_of_the_axis(run: xr.Dataset) -> None:
    figure = ab.plot.run_up(run, speed_unit="rpm")
    drawn = lines(figure, 0)
    assert np.allclose(drawn["rotor"][1], run.speed.values * 30.0 / np.pi)
    assert np.allclose(drawn["ball 2"][1], run.ball_speed_in_space.values[:, 1] * 30.0 / np.pi)
    assert "(rpm)" in figure.axes[0].get_ylabel()
    assert "(rad/s)" in ab.plot.run_up(run, speed_unit="rad/s").axes[0].get_ylabel()


def test_rounding_of_a_steady_speed_is_not_enlarged() -> None:
    """A ball that is held at the speed of the rotor lies on its line."""
    time, speed = np.linspace(0.0, 1.0, 9), np.full(9, 40.0)
    balls = (speed + 1e-11 * np.sin(9.0 * time))[:, None]
    axes = picture(4.0, 3.0).subplots()
    look = BallLook("black", "ball")
    speed_panel(
        axes, History(time, speed, balls, balls, np.zeros((9, 0))), CriticalSpeeds([]), speed_axis("rad/s"), [look]
    )
    low, high = axes.get_ylim()
    assert high - low > 1.0
    assert low < 40.0 < high


def test_the_deflection_panel_shades_the_envelope(run: xr.Dataset) -> None:
    figure = ab.plot.run_up(run, deflection_unit="um")
    panel = figure.axes[1]
    assert np.allclose(lines(figure, 1)["greatest"][1], run.envelope_high.values * 1e6)
    corners = panel.collections[0].get_paths()[0].vertices
    assert corners[:, 1].max() == pytest.approx(float(run.envelope_high.max()) * 1e6)
    at = np.isclose(corners[:, 0], float(run.envelope_time[200]))
    assert corners[at, 1].min() == pytest.approx(float(run.envelope_low[200]) * 1e6)
    assert "(µm)" in panel.get_ylabel()


def test_ball_angles_stay_within_half_a_turn_and_mean_the_same(run: xr.Dataset) -> None:
    time, angle = run.time.values, run.ball_angle_in_rotor.values[:, 0]
    when, degrees = wrapped(time, angle)
    assert np.nanmax(np.abs(degrees)) <= 180.0
    kept = np.isin(when, time) & np.isfinite(degrees)
    original = np.rad2deg(angle[np.searchsorted(time, when[kept])])
    assert np.allclose((degrees[kept] - original + 180.0) % 360.0, 180.0)
    assert (np.diff(when) >= 0.0).all()


def test_no_line_runs_across_the_axis_at_a_wrap() -> None:
    for angle in (np.array([3.0, 3.3, 3.0]), np.array([0.0, 20.0, -15.0]), np.array([-3.0, -3.5])):
        _, degrees = wrapped(np.arange(float(angle.size)), angle)
        gaps = np.flatnonzero(np.isnan(degrees))
        assert gaps.size == np.abs(np.diff(np.floor((angle + np.pi) / (2 * np.pi)))).sum()
        for left, right in zip(degrees[gaps - 1], degrees[gaps + 1], strict=True):
            assert left == -right
            assert abs(left) == 180.0
    time, degrees = wrapped(np.array([0.0, 1.0]), np.array([3.0, 3.3]))
    assert time[1] == pytest.approx((np.pi - 3.0) / 0.3)
    assert degrees == pytest.approx([np.rad2deg(3.0), 180.0, np.nan, -180.0, np.rad2deg(3.3) - 360.0], nan_ok=True)


def test_a_ball_that_slips_fast_is_pale_and_hides_no_slow_one(run: xr.Dataset) -> None:
    fast = slipping(run.time.values, run.ball_angle_in_rotor.values[:, 0], 20.0)
    assert fast[(run.time > 10.5) & (run.time < 11.5)].all()
    assert not fast[run.time > 13.0].any()
    drawn = lines(ab.plot.run_up(run), 2)
    when, degrees = drawn["ball 1"]
    assert np.isnan(degrees[(when > 10.5) & (when < 11.5)]).all()


def test_unbalance_and_its_opposite_are_marked(run: xr.Dataset) -> None:
    drawn = lines(ab.plot.run_up(run), 2)
    assert np.allclose(drawn["unbalance"][1], 0.0)
    assert np.allclose(np.abs(drawn["opposite"][1]), 180.0)


def test_critical_speeds_of_the_run_are_drawn_where_they_are_passed(run: xr.Dataset) -> None:
    figure = ab.plot.run_up(run.assign_attrs(critical_speeds=[250.0]), speed_unit="rad/s")
    assert any(np.allclose(line.get_ydata(), 250.0) for line in figure.axes[0].get_lines())
    passed = np.interp(250.0, run.speed.values[:400], run.time.values[:400])
    assert any(np.allclose(line.get_xdata(), passed, atol=1e-6) for line in figure.axes[1].get_lines())
    bare = ab.plot.run_up(run.drop_attrs(), speed_unit="rad/s")
    assert not any(np.allclose(line.get_ydata(), 250.0) for line in bare.axes[0].get_lines())


def test_a_run_with_an_envelope_only_shows_the_same_speeds(run: xr.Dataset) -> None:
    only = run.drop_dims(["time", "turn"])
    figure = ab.plot.run_up(only, speed_unit="rad/s")
    time, speed = lines(figure, 0)["rotor"]
    assert len(figure.axes) == 3
    assert np.allclose(np.interp(time, run.time, run.speed), speed, rtol=1e-3)
    time, speed = lines(figure, 0)["ball 1"]
    assert speed[(time > 10.0) & (time < 11.0)] == pytest.approx(248.0, rel=0.01)


def test_a_run_with_samples_only_shows_the_sampled_deflection(run: xr.Dataset) -> None:
    figure = ab.plot.run_up(run.drop_dims(["bin", "turn"]), deflection_unit="m")
    assert np.array_equal(lines(figure, 1)["deflection"][1], run.deflection.values)


def test_a_rotor_without_balls_has_no_panel_of_angles(run: xr.Dataset) -> None:
    bare = run.isel(ball=slice(0, 0))
    assert len(ab.plot.run_up(bare).axes) == 2
    with pytest.raises(QuestionError, match="no balls"):
        ab.plot.race(bare)


def test_a_part_of_the_run_is_drawn_alone(run: xr.Dataset) -> None:
    figure = ab.plot.run_up(run, start=5.0, end=6.0)
    time = lines(figure, 0)["rotor"][0]
    assert time.min() >= 5.0 - 1e-9
    assert time.max() <= 6.0 + 1e-9
    with pytest.raises(QuestionError, match="0 s to 20 s"):
        ab.plot.run_up(run, start=5.0, end=21.0)


def test_what_cannot_be_drawn_says_what_to_save(run: xr.Dataset) -> None:
    nothing = run.drop_dims(["time", "bin", "turn"])
    for question in (ab.plot.run_up, ab.plot.race, ab.plot.orbit):
        with pytest.raises(QuestionError, match="save"):
            question(nothing)
    with pytest.raises(QuestionError, match="must be 'rpm', 'rad/s'"):
        ab.plot.run_up(run, speed_unit="rps")
    with pytest.raises(QuestionError, match="must be 'm', 'mm', 'um' or 'nm'"):
        ab.plot.run_up(run, deflection_unit="inch")


def test_the_race_shows_balls_to_scale_at_their_angles(run: xr.Dataset) -> None:
    time = 6.9
    figure = ab.plot.race(run, time=time)
    diameter = float(run.ball_diameter[0]) * 1e3
    circles = [patch for patch in figure.axes[0].patches if isinstance(patch, Circle)]
    balls = [circle for circle in circles if circle.get_radius() == pytest.approx(0.5 * diameter)]
    angles = sorted(float(np.arctan2(ball.center[1], ball.center[0])) for ball in balls)
    expected = Motion(run).at(np.array([time])).ball_angle_in_rotor[0]
    assert angles == pytest.approx(sorted(np.angle(np.exp(1j * expected))))
    assert all(np.hypot(*ball.center) == pytest.approx(100.0) for ball in balls)
    with pytest.raises(QuestionError, match="0 s to 20 s"):
        ab.plot.race(run, time=25.0)
    with pytest.raises(QuestionError, match="given 2; the run has 1"):
        ab.plot.race(run, balancer=2)


def test_the_arrows_of_the_race_add_up_to_the_resultant(run: xr.Dataset) -> None:
    resultant = races_of(run).resultant(Motion(run).at(run.time.values))
    assert np.allclose(np.abs(resultant), run.residual_unbalance.values, rtol=1e-9, atol=1e-15)
    labels = [text.get_text() for text in ab.plot.race(run).axes[0].get_legend().get_texts()]
    assert labels[:2] == ["unbalance 500 g mm", "balls 499 g mm"]
    assert labels[2].startswith(f"resultant {1e6 * float(run.residual_unbalance[-1]):.3g}")
    # while balls stall they move in the rotor: the same sum is that of a moment and balances nothing
    stalled = int(np.argmax(np.abs(run.ball_speed_in_space.values[:, 0] - run.speed.values)))
    axes = ab.plot.race(run, time=float(run.time[stalled])).axes[0]
    assert axes.get_legend().get_texts()[2].get_text().startswith("resultant now ")
    assert [text for text in axes.texts if "they do not balance it" in text.get_text()]


def test_the_resultant_counts_the_balls_of_an_eccentric_race(tmp_path: Path) -> None:
    text = (MACHINES / "discoidal.toml").read_text(encoding="utf-8")
    (tmp_path / "m.toml").write_text(text.replace("width =", 'eccentricity = "1 mm"\nwidth =', 1), encoding="utf-8")
    run = ab.simulate(tmp_path / "m.toml", duration=5.0, save=Samples(11))
    resultant = races_of(run).resultant(Motion(run).at(run.time.values))
    assert np.allclose(np.abs(resultant), run.residual_unbalance.values, rtol=1e-9)


def test_an_eccentric_race_says_how_much_larger_it_is_drawn(run: xr.Dataset) -> None:
    shifted = run.assign_coords(race_center_x=("ball", [3e-5, 3e-5]), race_center_y=("ball", [0.0, 0.0]))
    words = " ".join(text.get_text() for text in ab.plot.race(shifted).axes[0].texts)
    assert "eccentricity 30 µm at 0°, drawn 200 times larger" in words


def test_the_orbit_is_the_last_revolutions_in_the_chosen_frame(run: xr.Dataset) -> None:
    figure = ab.plot.orbit(run, deflection_unit="nm")
    x, y = lines(figure, 0)["rotor center"]
    assert np.allclose(x[::8], run.turn_x.values * 1e9, atol=1e-6)
    assert np.allclose(y[::8], run.turn_y.values * 1e9, atol=1e-6)
    assert "in space (nm)" in figure.axes[0].get_xlabel()
    assert figure.axes[0].get_aspect() == 1.0
    turned = lines(ab.plot.orbit(run, deflection_unit="nm", frame="rotor"), 0)["rotor center"]
    z = (run.turn_x.values + 1j * run.turn_y.values) * np.exp(-1j * run.turn_rotor_angle.values) * 1e9
    assert np.allclose((turned[0] + 1j * turned[1])[::8], z)


def test_stroboscopic_samples_are_points_not_an_orbit(run: xr.Dataset) -> None:
    drawn = lines(ab.plot.orbit(run, start=15.0, end=16.0), 0)
    assert "rotor center" not in drawn
    assert any(label.startswith("samples, 0.5") for label in drawn)


def test_the_motion_between_samples_is_that_of_a_finer_run() -> None:
    coarse = ab.simulate(MACHINES / "stall_and_release.toml", duration=12.0, save=Samples(2401))
    between = np.arange(400, 2380, 7) * 0.005 + 0.0027
    fine = ab.simulate(MACHINES / "stall_and_release.toml", duration=12.0, save=SampleTimes(list(between)))
    moments = Motion(coarse).at(between)
    assert np.abs(moments.rotor_angle - fine.rotor_angle.values).max() < 1e-4
    assert np.abs(moments.ball_angle_in_rotor - fine.ball_angle_in_rotor.values).max() < 1e-3
    error = np.abs(
        moments.deflection_in_rotor * np.exp(1j * moments.rotor_angle) - (fine.x.values + 1j * fine.y.values)
    )
    assert error.max() < 0.01 * float(fine.deflection.max())


def test_units_of_axes_suit_the_size() -> None:
    assert [length_axis(None, size).sign for size in (2.0, 2e-3, 2e-6, 2e-9, 0.0)] == ["m", "mm", "µm", "nm", "nm"]
    assert speed_axis("Hz").factor * 2.0 * np.pi == pytest.approx(1.0)
    assert [length_text(size) for size in (1.333e-3, 8.62e-9, 0.0, 1e-14)] == ["1.33 mm", "8.62 nm", "0", "< 0.01 nm"]
    assert [round_down(value) for value in (1.0, 1.99, 2.0, 49.0, 0.7)] == [1.0, 1.0, 2.0, 20.0, 0.5]


def test_pictures_are_saved_by_extension(run: xr.Dataset, tmp_path: Path) -> None:
    figure = ab.plot.race(run)
    begins = {"png": b"\x89PNG\r\n", "svg": b"<?xml", "pdf": b"%PDF"}
    for kind, begin in begins.items():
        path = save_picture(figure, tmp_path / "new" / f"race.{kind}", dpi=50)
        assert path.read_bytes().startswith(begin)
    with Image.open(tmp_path / "new" / "race.png") as picture:
        assert picture.size == tuple((50.0 * figure.get_size_inches()).astype(int))
    with pytest.raises(QuestionError, match=r"\.png, \.svg or \.pdf"):
        save_picture(figure, tmp_path / "race.bmp")


def test_drawing_changes_no_global_setting_and_needs_no_pyplot(run: xr.Dataset) -> None:
    with matplotlib.rc_context({"font.size": 7.0, "axes.grid": False}):
        before = dict(matplotlib.rcParams)
        figure = ab.plot.run_up(run)
        assert dict(matplotlib.rcParams) == before
    assert figure._repr_png_().startswith(b"\x89PNG")  # type: ignore[attr-defined]
    assert to_hex(figure.axes[2].get_lines()[-3].get_color()) != UNBALANCE.lower()


def test_the_command_line_writes_one_picture_or_all(run: xr.Dataset, tmp_path: Path) -> None:
    result, runner = ab.save_run(run, tmp_path / "stall.nc"), CliRunner()
    answer = runner.invoke(app, ["plot", str(result), "--out", str(tmp_path / "pictures")], catch_exceptions=False)
    assert answer.exit_code == 0
    names = ["stall_orbit.png", "stall_race.png", "stall_run_up.png"]
    assert sorted(path.name for path in (tmp_path / "pictures").iterdir()) == names
    requested = ["plot", str(result), "--kind", "impacts", "--out", str(tmp_path / "impacts.png")]
    assert runner.invoke(app, requested).exit_code == 0
    one = ["plot", str(result), "--kind", "race", "--time", "7 s", "--out", str(tmp_path / "race.svg")]
    assert runner.invoke(app, one).exit_code == 0
    assert (tmp_path / "race.svg").read_bytes().startswith(b"<?xml")
    for wrong in (["--kind", "pie"], ["--format", "bmp"], ["--time", "7 kg"], ["--out", "all.png"]):
        assert runner.invoke(app, ["plot", str(result), *wrong]).exit_code == 2


@pytest.mark.parametrize("level", [40.0, 54.7, 70.0, 95.0])
def test_labels_of_close_levels_stand_apart_and_no_line_crosses_one(level: float) -> None:
    time = np.linspace(0.0, 20.0, 400)
    high = 100.0 + 827.0 * np.exp(-3.0 * time)
    without = Curve("", time, np.full(time.size, level * 1e-6))
    figure = picture(8.0, 2.6)
    axes = figure.subplots()
    deflections = Deflections(time, high * 1e-6, high * 1e-6, False, without=without)
    deflection_panel(axes, deflections, length_axis("um", 0.0))
    axes.set_xlim(0.0, 20.0)
    figure.draw_without_rendering()
    labels = labels_of(axes)
    boxes = labels.placed
    assert len(boxes) == 3
    for i, box in enumerate(boxes):
        assert not any(box.padded(1.0).overlaps(other) for other in boxes[:i])
        assert axes.get_window_extent().padded(1.0).containsx(box.x1)
        for joint in labels.joints:
            (x0, y0), (x1, y1) = joint.get_xydata()
            inner = np.linspace(0.02, 0.98, 50)
            inside = box.padded(-1.0)
            assert not any(inside.contains(x0 + s * (x1 - x0), y0 + s * (y1 - y0)) for s in inner)


def test_a_measured_run_without_rotor_angle_has_an_orbit(run: xr.Dataset) -> None:
    first, last = float(run.turn_time[0]), float(run.turn_time[-1])
    time = np.linspace(first, last, 200)
    around = 1e-4 * np.exp(1j * 500.0 * time)
    measured = xr.Dataset(
        {"speed": ("time", np.full(200, 500.0)), "x": ("time", around.real), "y": ("time", around.imag)}, {"time": time}
    )
    x, y = lines(ab.plot.orbit(measured, start=first, deflection_unit="um"), 0)["rotor center"]
    assert np.hypot(x, y) == pytest.approx(100.0, rel=1e-3)


def test_the_race_of_resolved_balls_is_drawn_from_wall_to_wall() -> None:
    """The inner wall of a race of 20 mm is 20 mm within the outer one, at the orbit radius and half a ball."""
    run = ab.simulate(ab.example("resolved_balls"), duration=0.01)
    width = 1e3 * ab.example("resolved_balls").balancers[0].races[0].width
    radii = [patch.radius for patch in ab.plot.race(run).axes[0].patches if isinstance(patch, Circle)]
    outer = 76.95 + 0.5 * 12.3
    assert any(abs(radius - outer) < 1e-9 for radius in radii)
    assert any(abs(radius - (outer - width)) < 1e-9 for radius in radii)

"""Pictures and films of a deep chamber show what the run says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from PIL import Image
from tests.references.chamber_runs import BALL, CHAMBER, MACHINE, chamber_run

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.plots.chamber_view import Camera, poses_of
from autobalancer.results.archive import Archive
from autobalancer.results.chamber_measures import ChamberShape, chambers_of
from autobalancer.results.unconstrained_body import pakula_body
from autobalancer.studies.chamber_study import optimal_means, over_seeds, pick_up_borders

RUN = chamber_run(2.5)


def drawn(figure: Figure) -> None:
    figure.canvas.draw()


def test_a_camera_on_the_axis_sees_y_to_the_right_and_z_up() -> None:
    point = np.array([3.0, 1.0, 2.0])
    np.testing.assert_allclose(Camera(0.0, 0.0).seen(point), [1.0, 2.0, 3.0], atol=1e-15)
    np.testing.assert_allclose(Camera(90.0, 0.0).seen(point), [-3.0, 2.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(Camera(0.0, 90.0).seen(point), [1.0, -3.0, 2.0], atol=1e-15)


@pytest.mark.parametrize(("azimuth", "elevation"), [(35.0, 20.0), (-120.0, -40.0), (200.0, 85.0)])
def test_the_axes_of_a_camera_are_a_right_handed_frame(azimuth: float, elevation: float) -> None:
    axes = Camera(azimuth, elevation).axes()
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_poses_between_samples_lie_between_them() -> None:
    shapes = [ChamberShape(CHAMBER, 0.2, place=0.5)]
    times = np.array([0.0, 1.0005, 2.5])
    poses = poses_of(RUN, times, in_rotor=False, chambers=shapes, scale=2.0, heavy=0.3)
    middle = RUN["ball_position"].values[1000:1002].mean(axis=0) + np.array([0.5, 0.0, 0.0])
    np.testing.assert_allclose(poses.balls[1], middle, atol=1e-12)
    np.testing.assert_allclose(poses.balls[2], RUN["ball_position"].values[-1] + [0.5, 0.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(poses.body[2], 2.0 * RUN["body_position"].values[-1], atol=1e-15)
    standing = poses_of(RUN, np.array([2.2, 2.4]), in_rotor=True, chambers=shapes, scale=1.0, heavy=0.3)
    np.testing.assert_allclose(standing.balls[0], standing.balls[1], atol=1e-5)
    assert standing.heavy.tolist() == [0.3, 0.3]


def test_chambers_without_a_description_reach_as_far_as_their_balls() -> None:
    (shape,) = chambers_of(RUN)
    assert shape.radius == pytest.approx(CHAMBER, rel=1e-3)
    assert shape.depth == pytest.approx(2.0 * (0.03 + BALL), rel=1e-3)


def test_balls_opposite_to_the_unbalance_are_drawn_there() -> None:
    figure = ab.plot.chamber_arrangement(RUN, [0.0, 2.5])
    drawn(figure)
    unrolled = figure.axes[3]
    balls = [each for each in unrolled.collections if isinstance(each, EllipseCollection)][1]
    angle = np.sort(np.asarray(balls.get_offsets())[:, 0])
    np.testing.assert_allclose(angle, np.rad2deg([2.6, 3.0, 3.4]), atol=0.1)


@pytest.mark.parametrize("picture", ["history", "energy", "collisions", "bearings", "reactions"])
def test_every_history_can_be_drawn(picture: str) -> None:
    figure = ab.plot.answer(RUN, picture)
    drawn(figure)
    assert figure.axes[-1].get_xlabel() == "time (s)"


def test_the_stack_of_energies_reaches_the_work_of_the_motor() -> None:
    figure = ab.plot.answer(RUN, "energy")
    stack = figure.axes[0].collections
    top = stack[-1].get_paths()[0].vertices[:, 1].max()
    assert top == pytest.approx(RUN["work_motor"].values.max(), rel=1e-2)


def test_the_loose_body_is_drawn_beside_the_reactions() -> None:
    figure = ab.plot.answer(RUN, "reactions", body=pakula_body(0.3), until=1.5)
    drawn(figure)
    assert len(figure.axes) == 6


def test_a_film_has_its_frames_and_its_size(tmp_path: Path) -> None:
    from imageio_ffmpeg import count_frames_and_secs, read_frames

    seen: list[int] = []
    path = ab.animate(
        RUN, tmp_path / "a.mp4", duration=0.4, fps=10, start=1.0, width=480, progress=lambda done, _: seen.append(done)
    )
    assert count_frames_and_secs(str(path))[0] == 4
    assert seen == [1, 2, 3, 4]
    reader = read_frames(str(path))
    size = next(reader)["size"]
    assert size == (480, 272)
    picture = np.frombuffer(next(reader), np.uint8)
    assert picture.std() > 10.0
    reader.close()


def test_the_mark_of_the_unbalance_is_a_radius_seen_along_the_axis_and_a_point_seen_along_itself(
    tmp_path: Path,
) -> None:
    """It points along y; the view is 80 % of the height of the film and 8 % wider than the chamber."""
    lengths = []
    for azimuth in (0.0, 90.0):
        path = ab.animate(
            RUN, tmp_path / "a.gif", duration=0.2, fps=10, width=640, frame="rotor", azimuth=azimuth, elevation=0.0
        )
        with Image.open(path) as film:
            pixels = np.asarray(film.convert("RGB")).astype(int)
        height, width, _ = pixels.shape
        view = pixels[height // 8 : 3 * height // 4, : width // 2]  # without panels and legend
        mark = np.abs(view - [213, 94, 0]).max(axis=2) < 60
        lengths.append(np.ptp(np.flatnonzero(mark.any(axis=0))))
    dot = lengths[1]
    assert 3 <= dot <= 12
    assert lengths[0] - dot == pytest.approx(0.98 * 0.8 * height / 2.16, abs=3.0)


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        ({"start": -1.0}, "the samples go from 0 s to 2.5 s"),
        ({"frame": "moon"}, "frame: given 'moon'"),
        ({"fps": 0}, "fps: given 0"),
        ({"elevation": 100.0}, "elevation: given 100"),
        ({"width": 10}, "width: given 10"),
        ({"duration": 0.0}, "duration: given 0"),
        ({"deflection_scale": -2.0}, "deflection_scale: given -2"),
    ],
)
def test_a_film_that_makes_no_sense_is_refused(wrong: dict[str, object], told: str, tmp_path: Path) -> None:
    with pytest.raises(QuestionError, match=told):
        ab.animate(RUN, tmp_path / "a.mp4", **wrong)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_arrangements_outside_the_run_are_refused() -> None:
    with pytest.raises(QuestionError, match="times: given"):
        ab.plot.chamber_arrangement(RUN, [9.0])
    with pytest.raises(QuestionError, match="chamber: given 2; the machine has 1"):
        ab.plot.chamber_arrangement(RUN, chamber=2)


def study() -> xr.Dataset:
    values = np.array([[[9e-4, 2e-5, 1e-5], [8e-4, 1e-5, np.nan]], [[3e-5, 4e-5, 5e-5], [2e-5, 3e-5, 6e-5]]])
    coords = {"layers": ["deep", "single"], "friction": [0.3, 0.5], "balls": [3, 8, 20]}
    return xr.Dataset({"vertical_amplitude": (("layers", "friction", "balls"), values)}, coords)


def test_numbers_of_balls_are_whole_on_their_axis_even_if_there_is_one() -> None:
    figure = ab.plot.answer(study().sel(balls=[3]))
    for panel in figure.axes:
        assert all(tick == round(tick) for tick in panel.get_xticks())
    drawn(figure)


def test_studies_and_catalogues_can_be_drawn(tmp_path: Path) -> None:
    drawn(ab.plot.answer(study()))
    means = optimal_means(study())
    np.testing.assert_allclose(means["vertical_amplitude"], [[1.5e-5, 1e-5], [3.5e-5, 2.5e-5]])
    assert means["runs"].values.tolist() == [[2, 1], [2, 2]]
    drawn(ab.plot.answer(means))
    drawn(ab.plot.answer(ab.chamber.step_size([4.0], [1e-4, 1e-5], stiffness_over_mass=1e10, phases=20)))
    archive = Archive(tmp_path)
    for balls in (3, 8):
        archive.start(f"n{balls}", MACHINE, {"balls": balls, "friction": 0.5}, {}).end(
            "finished", {}, {"a": 0.1 * balls}
        )
    figure = ab.plot.answer(archive.runs(), x="balls", y="a", by="friction")
    drawn(figure)
    np.testing.assert_allclose(figure.axes[0].lines[0].get_ydata(), [0.3, 0.8])
    with pytest.raises(QuestionError, match="catalogue: given 'b'; must be 'a'"):
        ab.plot.answer(archive.runs(), x="balls", y="b")
    with pytest.raises(QuestionError, match="is a text"):
        ab.plot.answer(archive.runs(), x="balls", y="state")
    with pytest.raises(QuestionError, match="no number of balls from 30 to 40"):
        optimal_means(study(), {"deep": (30, 40)})


def seeded() -> xr.Dataset:
    """Two fillings of each: amplitudes 1 and 3, carried from friction 0.5 and 8 balls on, in one filling from 3 balls on."""
    coords = {"layers": ["deep"], "friction": [0.3, 0.5], "balls": [3, 8, 20], "seed": [0, 1]}
    dims = ("layers", "friction", "balls", "seed")
    amplitude = np.broadcast_to(np.array([1e-5, 3e-5]), (1, 2, 3, 2)).copy()
    amplitude[0, 0, 0, 1] = np.nan
    carried = np.zeros((1, 2, 3, 2))
    carried[0, 1, 1:] = 1.0
    carried[0, 1, 0, 1] = 1.0
    return xr.Dataset({"vertical_amplitude": (dims, amplitude), "share_carried": (dims, carried)}, coords)


def test_means_over_seeds_leave_out_what_failed_and_say_how_far_runs_lie_apart() -> None:
    found = over_seeds(seeded())
    np.testing.assert_allclose(found["vertical_amplitude"][0], [[1e-5, 2e-5, 2e-5], [2e-5, 2e-5, 2e-5]])
    spread = found["vertical_amplitude_spread"].values[0]
    assert np.isnan(spread[0, 0])
    np.testing.assert_allclose(spread.ravel()[1:], np.sqrt(2.0) * 1e-5)
    assert found["runs"].values.tolist() == [[[1, 2, 2], [2, 2, 2]]]
    means = optimal_means(seeded(), {"deep": (8, 20)})
    np.testing.assert_allclose(means["vertical_amplitude"], [[2e-5, 2e-5]])
    np.testing.assert_allclose(means["vertical_amplitude_spread"], [[np.sqrt(2.0) * 1e-5] * 2])
    assert means["runs"].values.tolist() == [[4, 4]]


def test_balls_are_carried_from_a_least_friction_and_number_on() -> None:
    found = pick_up_borders(seeded())
    np.testing.assert_array_equal(found["least_friction"], [[np.nan, 0.5, 0.5]])
    np.testing.assert_array_equal(found["least_balls"], [[np.nan, 8.0]])
    assert pick_up_borders(seeded(), 0.5)["least_balls"].values.tolist()[0][1] == 3.0
    with pytest.raises(QuestionError, match="share: given 2"):
        pick_up_borders(seeded(), 2.0)


def test_curves_have_bars_from_the_least_to_the_greatest_filling() -> None:
    figure = ab.plot.answer(seeded())
    drawn(figure)
    (_, _, (bars,)) = figure.axes[0].containers[1]
    np.testing.assert_allclose(np.array(bars.get_segments())[0][:, 1], [10.0, 30.0])
    figure = ab.plot.answer(seeded(), "carried")
    drawn(figure)
    assert [line.get_label() for line in figure.axes[0].containers] == ["3 balls", "8 balls", "20 balls"]
    np.testing.assert_allclose(figure.axes[0].containers[0][0].get_ydata(), [0.0, 50.0])


def test_the_unbalance_of_a_chamber_is_in_a_unit_that_needs_few_digits_and_angles_are_within_half_a_turn() -> None:
    figure = ab.plot.chamber_run(RUN)
    speed, _, angles, left = figure.axes
    assert left.get_ylabel() in ("unbalance (g mm)", "unbalance (kg mm)")
    assert max(abs(tick) for tick in left.get_yticks()) < 2e4
    dots = np.concatenate([np.asarray(line.get_ydata()) for line in angles.get_lines() if line.get_marker() == "."])
    assert dots.min() >= -180.0
    assert dots.max() <= 180.0
    drawn(figure)
    shown = ab.plot.chamber_run(RUN.assign_attrs(critical_speeds=[float(RUN["speed"].max())])).axes[0]
    assert len(shown.get_lines()) == len(speed.get_lines()) + 1


def test_a_picture_of_an_archive_has_units_whole_numbers_of_balls_and_a_title(tmp_path: Path) -> None:
    archive = Archive(tmp_path)
    for balls in (7, 8):
        archive.start(f"n{balls}", MACHINE, {"balls": balls}, {}).end(
            "finished", {}, {"vertical_amplitude": 1e-5 * balls}
        )
    table = archive.runs()
    table["vertical_amplitude"].attrs["units"] = "m"
    figure = ab.plot.answer(table, x="balls", y="vertical_amplitude")
    drawn(figure)
    panel = figure.axes[0]
    assert panel.get_ylabel() == "vertical amplitude (µm)"
    np.testing.assert_allclose(panel.lines[0].get_ydata(), [70.0, 80.0])
    assert all(float(tick).is_integer() for tick in panel.get_xticks())
    assert figure.get_suptitle().startswith("Runs of")

"""Films: as many frames as asked for, and the machine in them where the result says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from imageio_ffmpeg import count_frames_and_secs
from PIL import Image, ImageSequence
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.errors import QuestionError
from autobalancer.plots.animation import Scene, _frame_times
from autobalancer.plots.film_frames import size_words
from autobalancer.plots.style import labels_of, look
from autobalancer.results.display_units import SPEED_UNITS
from autobalancer.results.drawn import Motion, races_of
from autobalancer.simulation.record import Envelope, Samples

MACHINE = Path(__file__).parents[1] / "examples" / "machines" / "stall_and_release.toml"


@pytest.fixture(scope="module")
def run() -> xr.Dataset:
    return ab.simulate(MACHINE, duration=9.0, save=(Samples(901), Envelope(200)))


def scene_of(run: xr.Dataset, times: np.ndarray, *, turns: bool = False, scale: float = 10.0) -> Scene:
    moments = Motion(run).at(times)
    with look():
        return Scene(
            run,
            moments,
            moments,
            races_of(run),
            in_space=turns,
            per_frame=1,
            magnification=scale,
            unit=SPEED_UNITS["rpm"],
            caption="",
            width=480,
        )


def test_an_mp4_has_the_frames_and_the_length_asked_for(run: xr.Dataset, tmp_path: Path) -> None:
    path = ab.animate(run, tmp_path / "new" / "film.mp4", duration=0.6, fps=20, width=320)
    frames, seconds = count_frames_and_secs(str(path))
    assert frames == 12
    assert seconds == pytest.approx(0.6, abs=0.05)
    assert sorted(file.name for file in path.parent.iterdir()) == ["film.mp4"]


def test_a_gif_has_the_frames_and_the_length_asked_for(run: xr.Dataset, tmp_path: Path) -> None:
    calls: list[tuple[int, int]] = []
    path = ab.animate(
        run, tmp_path / "film.gif", duration=0.5, fps=30, width=320, progress=lambda *now: calls.append(now)
    )
    with Image.open(path) as film:
        assert film.n_frames == 15
        assert film.convert("RGB").getpixel((2, 2)) == (255, 255, 255)
        lengths = [frame.info["duration"] for frame in ImageSequence.Iterator(film)]
    assert sum(lengths) == 500  # 30 frames a second do not fit the hundredths of a GIF; the whole film does
    assert calls == [(k, 15) for k in range(1, 16)]


def test_frames_lie_on_the_samples_where_these_are_denser(run: xr.Dataset) -> None:
    times = _frame_times(run.time.values, None, None, 25)
    assert np.isin(times, run.time.values).all()
    assert np.allclose(np.diff(times), 9.0 / 24, atol=0.01)
    slow = _frame_times(run.time.values, 7.0, 7.1, 101)
    assert np.allclose(np.diff(slow), 0.001)


def test_the_film_places_center_and_balls_where_the_run_has_them(run: xr.Dataset) -> None:
    times = run.time.values[690:700]
    scene = scene_of(run, times, turns=True)
    scene.frame(5)
    now = run.isel(time=695)
    shift = complex(*scene.views[0].placed.transform((0.0, 0.0)))
    assert shift == pytest.approx(complex(now.x, now.y) * 10.0 / 0.1)
    for i, ball in enumerate(scene.views[0].balls):
        place = complex(*scene.views[0].placed.transform(ball.center)) - shift
        angle = float(now.ball_angle_in_rotor[i] + now.rotor_angle)
        assert place == pytest.approx(np.exp(1j * angle))
    assert scene.cursors[0].get_xdata()[0] == times[5]
    assert f"{times[5]:.2f} s" in scene.text.get_text()


def test_in_its_own_frame_the_rotor_does_not_turn_and_balls_leave_a_trail(run: xr.Dataset) -> None:
    times = run.time.values[840:880:4]
    scene = scene_of(run, times)
    scene.frame(3)
    axis = scene.views[0].placed.transform((1.0, 0.0)) - scene.views[0].placed.transform((0.0, 0.0))
    assert axis == pytest.approx([1.0, 0.0])
    x, y = scene.views[0].trails[0].get_data()
    swept = np.unwrap(np.arctan2(y, x))
    angle = run.ball_angle_in_rotor.values[[848, 852], 0]
    assert swept[-1] - swept[0] == pytest.approx(angle[0] - angle[1])


def test_consecutive_frames_differ_and_equal_frames_are_equal(run: xr.Dataset) -> None:
    scene = scene_of(run, run.time.values[600:700:10])
    first = scene.frame(2)
    assert first.shape == (272, 480, 3)
    assert (scene.frame(3) != first).any()
    assert (scene.frame(2) == first).all()  # nothing of a frame stays behind


def test_a_rotor_without_balls_makes_a_film(run: xr.Dataset, tmp_path: Path) -> None:
    path = ab.animate(
        run.isel(ball=slice(0, 0)), tmp_path / "bare.mp4", start=7.0, end=7.1, duration=0.2, frame="space", width=320
    )
    assert count_frames_and_secs(str(path))[0] == 5


def test_a_film_that_makes_no_sense_is_refused(run: xr.Dataset, tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    with pytest.raises(QuestionError, match=r"\.mp4 or \.gif"):
        ab.animate(run, tmp_path / "film.avi")
    for wrong, words in (
        ({"end": 12.0}, "0 s to 9 s"),
        ({"duration": 0.01}, "2 to 100000"),
        ({"fps": 0}, "between 1 and 100"),
        ({"width": 10}, "320"),
        ({"deflection_scale": -1.0}, "greater than zero"),
        ({"frame": "moon"}, "'rotor' or 'space'"),
        ({"speed_unit": "mph"}, "rpm"),
    ):
        with pytest.raises(QuestionError, match=words):
            ab.animate(run, film, **wrong)
    with pytest.raises(QuestionError, match="save"):
        ab.animate(run.drop_dims("time"), film)
    assert not list(tmp_path.iterdir())


def test_a_film_that_breaks_off_leaves_the_old_one(run: xr.Dataset, tmp_path: Path) -> None:
    for name in ("old.mp4", "old.gif"):
        film = tmp_path / name
        film.write_bytes(b"old")

        def stop(done: int, total: int) -> None:
            if done == 3:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            ab.animate(run, film, duration=1.0, width=320, progress=stop)
        assert film.read_bytes() == b"old"
    assert len(list(tmp_path.iterdir())) == 2


def test_the_command_line_makes_a_film(run: xr.Dataset, tmp_path: Path) -> None:
    result = ab.save_run(run, tmp_path / "stall.nc")
    options = ["--start", "7 s", "--end", "7200 ms", "--seconds", "0.4 s", "--frame", "space", "--width", "320"]
    answer = CliRunner().invoke(app, ["animate", str(result), *options], catch_exceptions=False)
    assert answer.exit_code == 0
    assert count_frames_and_secs(str(tmp_path / "stall.mp4"))[0] == 10
    assert CliRunner().invoke(app, ["animate", str(result), "--seconds", "4 mm"]).exit_code == 2


def test_a_film_of_two_planes_has_a_disc_for_each_and_shows_the_axis_tilt() -> None:
    run = ab.simulate(MACHINE.with_name("two_plane_rotor.toml"), duration=0.5, save=(Samples(201), Envelope(50)))
    scene = scene_of(run, run.time.values[20:60])
    scene.frame(3)
    assert [len(view.balls) for view in scene.views] == [2, 2]
    for plane, view in enumerate(scene.views):
        z = complex(*view.placed.transform((0.0, 0.0))) * 0.05 / 10.0  # orbit radius 50 mm, drawn ten times larger
        assert z == pytest.approx(complex(Motion(run).plane_deflection_in_rotor[23, plane]), rel=1e-6)
        heavy = complex(*(float(values[1]) for values in view.heavy_line.get_data()))
        angle = float(run.plane_unbalance_angle_in_rotor[23, plane])
        assert np.angle(heavy) == pytest.approx(angle)
    assert scene.axis is not None
    right, up = scene.axis.line.get_data()
    lower, upper = Motion(run).plane_deflection_in_rotor[23] * 10.0 / 0.05
    assert np.diff(up)[0] == pytest.approx((upper - lower).imag - 0.3 * (upper - lower).real)
    assert np.asarray(right).size == 2


def test_the_cursor_of_a_film_passes_behind_its_labels(run: xr.Dataset) -> None:
    scene = scene_of(run, run.time.values[600:700:10])
    scene.frame(2)
    assert max(map(scene.moving.index, scene.cursors)) < min(
        scene.moving.index(labels_of(panel)) for panel in scene.figure.axes[-2:]
    )
    boxes = labels_of(scene.figure.axes[-1]).placed
    assert boxes
    assert not any(one.overlaps(other) for i, one in enumerate(boxes) for other in boxes[:i])


@pytest.mark.parametrize(
    ("scale", "words"),
    [(20.0, "drawn 20 times larger"), (1.0, "to scale"), (0.5, "at half size"), (0.2, "at 1/5 of its size")],
)
def test_a_caption_says_how_large_the_deflection_is_drawn(scale: float, words: str) -> None:
    assert size_words("deflection", scale).endswith(words)

"""Films of a race: drawn from known motions, and read back. Motions are made up here, so that every truth is known."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.typing import NDArray
from reproductions.standing import standing
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError, ResultError
from autobalancer.measurement.film import drawn as scene
from autobalancer.measurement.film.drawn import Camera, scenery
from autobalancer.measurement.film.optics import calibrate, camera_of, homography, in_space, mapped, sampled
from autobalancer.measurement.film.setup import FilmSetup, Mark, save_film_setup
from autobalancer.measurement.film.track import matched

Floats = NDArray[np.float64]
ORBIT, DIAMETER, SPEED = 0.08, 0.0125, 60.0
CONTACT = 2.0 * np.arcsin(0.5 * DIAMETER / ORBIT)
TIME = np.linspace(0.0, 0.4, 1601)


def made_up(angles: Floats, deflection: float = 0.0) -> xr.Dataset:
    """A run with these ball angles in the rotor, (time, balls), whose rotor whirls with the unbalance."""
    turn = SPEED * TIME
    balls = angles.shape[1]
    both = ("time", "ball")
    return xr.Dataset(
        {
            "speed": ("time", np.full(TIME.size, SPEED)),
            "rotor_angle": ("time", turn),
            "x": ("time", deflection * np.cos(turn + 0.7)),
            "y": ("time", deflection * np.sin(turn + 0.7)),
            "ball_angle_in_rotor": (both, angles),
            "ball_speed_in_rotor": (both, np.gradient(angles, TIME, axis=0)),
            "orbit_radius": ("ball", np.full(balls, ORBIT)),
            "ball_diameter": ("ball", np.full(balls, DIAMETER)),
        },
        {"time": TIME},
    )


def setup_of(run: xr.Dataset, camera: Camera, **more: Any) -> FilmSetup:
    """What a person would know: true places of marks, their pixels to within some pixels."""
    here, view = scenery(run), camera.view()
    off = np.random.default_rng(1).normal(0.0, 2.0, (len(here.frame_marks), 2))
    shown = here.rotor_marks if camera.turning else here.frame_marks
    marks = [
        Mark(mark.place, mark.radius, tuple(view.pixels(in_space(mark.z, 0.0)) + away))
        for mark, away in zip(shown, off, strict=False)
    ]
    rest = {"camera": "turning"} if camera.turning else {"rotor_marks": here.rotor_marks}
    known = {
        "orbit_radius": ORBIT,
        "ball_diameter": DIAMETER,
        "balls": run.sizes["ball"],
        "ball_height": 0.5 * DIAMETER,
    }
    return FilmSetup(**{**known, "marks": marks, **rest, **more})


def six() -> Floats:
    """Six balls; number 3 runs into number 4, which is at rest, and hands its speed on."""
    angles = np.tile(np.radians([0.0, 40.0, 80.0, 130.0, 200.0, 290.0]), (TIME.size, 1))
    gap = angles[0, 3] - angles[0, 2] - CONTACT
    hit = gap / 4.0
    angles[:, 2] += 4.0 * np.minimum(TIME, hit)
    angles[:, 3] += 4.0 * np.maximum(TIME - hit, 0.0)
    angles[:, 4] += 0.15 * np.sin(20.0 * TIME)
    angles[:, 5] -= 1.5 * TIME
    return angles


def errors(found: xr.Dataset, run: xr.Dataset) -> Floats:
    """Deviations of angles from the truth in degrees, (pictures, balls); each ball of the film is one of the run."""
    true = np.column_stack([np.interp(found["time"], TIME, row) for row in run["ball_angle_in_rotor"].values.T])
    got = found["ball_angle"].values
    away = np.degrees(np.angle(np.exp(1j * (got[:, :, None] - true[:, None, :]))))
    partner = [int(np.nanmedian(np.abs(away[:3, i]), axis=0).argmin()) for i in range(got.shape[1])]
    assert sorted(partner) == list(range(got.shape[1]))
    return np.column_stack([away[:, i, j] for i, j in enumerate(partner)])


@pytest.fixture(scope="module")
def oblique() -> tuple[xr.Dataset, ab.measure.Film, FilmSetup, xr.Dataset]:
    run = made_up(six(), deflection=0.8e-3)
    camera = Camera.above(0.115, tilt="30 deg", width=720, height=540, distortion=(-0.3,))
    exposure = ab.measure.Exposure(frame_rate=200.0, time="0.2 ms", noise=0.012, gradient=(0.15, -0.1), lost=0.04)
    film = ab.measure.render_film(run, camera=camera, exposure=exposure, end=0.26, seed=5)
    setup = setup_of(run, camera, distortion=1)
    return run, film, setup, ab.measure.track_balls(film, setup, first_speed=SPEED)


def test_where_no_pixel_is_seen_the_picture_is_that_of_a_corner() -> None:
    picture = np.full((4, 6), 7, np.uint8)
    assert sampled(picture, np.array([[np.nan, 1.0], [np.inf, -np.inf], [2.5, 1.5]])) == pytest.approx(7.0)


def test_angles_of_six_balls_seen_obliquely_are_true_within_two_tenths_of_a_degree(oblique: tuple[Any, ...]) -> None:
    run, _, _, found = oblique
    away = errors(found, run)
    seen = found["seen"].values
    assert seen.mean() > 0.9
    assert np.abs(away[seen]).max() < 0.2
    assert np.sqrt((away[seen] ** 2).mean()) < 0.04


def test_stated_deviations_are_those_of_the_errors(oblique: tuple[Any, ...]) -> None:
    run, _, _, found = oblique
    pull = errors(found, run) / np.degrees(found["ball_angle_deviation"].values)
    assert 0.6 < np.sqrt(np.nanmean(pull**2)) < 1.6
    assert 0.90 < np.nanmean(np.abs(pull[np.isfinite(pull)]) < 1.96) <= 1.0
    assert "doubt" not in dict(found.facts())


def test_small_balls_in_coarse_noisy_pictures_have_larger_deviations_that_are_those_of_their_errors() -> None:
    angles = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 12)
    rests = [standing([angle], 0.077, 0.011, 100.0, turned) for turned, angle in enumerate(angles)]
    camera = ab.measure.film_camera(rests[0], tilt="10 deg", width=320, height=240)
    exposure = ab.measure.Exposure(time=0.0, noise=0.02)
    pictures = [
        next(iter(ab.measure.render_film(one, camera=camera, exposure=exposure, end=2e-4, seed=number)))
        for number, one in enumerate(rests)
    ]
    found = ab.measure.track_balls(np.array(pictures), ab.measure.film_setup(rests[0], camera), frame_rate=240)
    assert found["seen"].values.all()  # a lone ball may have gone anywhere from one picture to the next
    off = np.angle(np.exp(1j * (found["ball_angle"].values[:, 0] - angles)))
    pull = off / found["ball_angle_deviation"].values[:, 0]
    assert 0.5 < np.sqrt((pull**2).mean()) < 1.6


def test_balls_that_are_not_where_they_were_expected_are_named_and_too_many_refused() -> None:
    near, far = (standing(both, 0.077, 0.02, 100.0) for both in ([0.0, 2.0], [1.0, 3.2]))
    camera = ab.measure.film_camera(near, width=320, height=240)
    exposure = ab.measure.Exposure(time=0.0, noise=0.01)
    pictures = np.array(
        [
            next(iter(ab.measure.render_film(one, camera=camera, exposure=exposure, end=2e-4, seed=number)))
            for number, one in enumerate((near, near, near, far, far, far))
        ]
    )
    setup = ab.measure.film_setup(near, camera)
    faults = [str(fault) for fault in ab.measure.track_balls(pictures[:4], setup, frame_rate=240)["fault"].values]
    assert [bool(fault) for fault in faults] == [False, False, False, True]
    assert "too far from where they were expected" in faults[3]
    with pytest.raises(QuestionError, match=r"3 of 4 pictures are of no use.*too far from where they were expected"):
        ab.measure.track_balls(pictures[2:], setup, frame_rate=240)


def test_deflection_and_angle_of_the_rotor_are_read_from_its_marks(oblique: tuple[Any, ...]) -> None:
    run, _, _, found = oblique
    good = np.isfinite(found["rotor_angle"].values)
    turn = np.interp(found["time"], TIME, run["rotor_angle"])
    assert np.degrees(np.abs(found["rotor_angle"].values - turn)[good]).max() < 0.03
    assert np.abs(found["x"].values - np.interp(found["time"], TIME, run["x"]))[good].max() < 2e-5


def test_lost_pictures_are_said_and_never_become_angles(oblique: tuple[Any, ...]) -> None:
    _, film, _, found = oblique
    black = film.pictures.reshape(film.time.size, -1).max(axis=1) == 0
    assert black.any()
    assert (found["fault"].values[black] == "dark").all()
    assert not found["seen"].values[black].any()
    assert np.isnan(found["ball_angle"].values[black]).all()


def test_the_impact_of_two_balls_is_found_with_its_time_and_speed(oblique: tuple[Any, ...]) -> None:
    _, _, _, found = oblique
    truth = (np.radians(50.0) - CONTACT) / 4.0
    assert found.sizes["impact"] == 1
    assert abs(float(found["impact_time"][0]) - truth) < 2e-3
    assert abs(float(found["impact_speed"][0]) - 4.0 * ORBIT) < 0.03
    assert int(found["impact_partner"][0]) - int(found["impact_ball"][0]) == 1


def test_speeds_follow_from_neighboring_pictures_but_not_across_an_impact(oblique: tuple[Any, ...]) -> None:
    found = oblique[3]
    hit = found["impact_time"].values[0]
    hitting = int(found["impact_ball"][0])
    rate = found["ball_speed"].sel(ball=hitting)
    before = rate.where((found["time"] > 0.02) & (found["time"] < hit), drop=True).values
    after = rate.where((found["time"] > hit + 0.005) & (found["time"] < 0.24), drop=True).values
    assert np.nanmax(np.abs(before - 4.0)) < 0.25
    assert np.nanmax(np.abs(after)) < 0.25


def test_a_film_keeps_its_kind_in_a_file(oblique: tuple[Any, ...], tmp_path: Path) -> None:
    _, _, _, found = oblique
    ab.save_run(found, tmp_path / "film.nc")
    again = ab.load_run(tmp_path / "film.nc")
    assert again.attrs["answer"] == "BallFilm"
    assert "impacts" in repr(again)
    assert "with a fault" in repr(again)


def test_polished_balls_that_mirror_a_lamp_have_deviations_as_large_as_their_errors_and_a_note(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, value in (("AMBIENT", scene.FLOOR), ("DIFFUSE", 0.0), ("GLOSS", 3.0), ("SHARP", 12.0)):
        monkeypatch.setattr(scene, name, value)  # a saturated disc beside the middle of a ball as dark as its race
    run, camera = made_up(six()), Camera.above(0.115, width=480, height=360, turning=True)
    exposure = ab.measure.Exposure(frame_rate=50.0, time=1e-5, noise=0.01)
    film = ab.measure.render_film(run, camera=camera, exposure=exposure, end=0.2)
    found = ab.measure.track_balls(film, setup_of(run, camera), first_ball_speed=0.0)
    away, deviation = errors(found, run), np.degrees(found["ball_angle_deviation"].values)
    good = np.isfinite(away)
    assert np.sqrt((away[good] ** 2).mean()) > 0.5, "a mirror that is as good as an outline proves nothing"
    assert (np.abs(away[good]) < 1.96 * deviation[good]).mean() >= 0.93
    assert any("polished" in text for text in found.remarks())


def test_a_camera_that_turns_with_the_rotor_sees_the_same_angles() -> None:
    run = made_up(six()[:, 2:])
    camera = Camera.above(0.11, tilt="20 deg", width=640, height=480, turning=True)
    four = [Mark((0.05 * np.cos(a), 0.05 * np.sin(a)), 0.003) for a in (0.0, 1.3, 2.9, 4.6)]
    film = ab.measure.render_film(
        run, camera=camera, exposure=ab.measure.Exposure(frame_rate=100.0), end=0.12, rotor_marks=four
    )
    pixels = camera.view().pixels(in_space([mark.z for mark in four], 0.0))
    marks = [Mark(mark.place, mark.radius, tuple(at)) for mark, at in zip(four, pixels, strict=True)]
    setup = FilmSetup(ORBIT, DIAMETER, 4, marks, ball_height=0.5 * DIAMETER, camera="turning")
    found = ab.measure.track_balls(film, setup)
    assert np.abs(errors(found, run)).max() < 0.15
    assert np.isnan(found["speed"].values).all(), "no tacho, so no speed"


def test_balls_of_few_pixels_have_larger_deviations_which_are_those_of_their_errors() -> None:
    run, deviations = made_up(six()), []
    for width in (640, 240):
        camera = Camera.above(0.115, width=width, height=3 * width // 4, turning=True)
        exposure = ab.measure.Exposure(frame_rate=50.0, time=1e-5, noise=0.01)
        film = ab.measure.render_film(run, camera=camera, exposure=exposure, end=0.25)
        found = ab.measure.track_balls(film, setup_of(run, camera), first_ball_speed=0.0)
        pull = errors(found, run) / np.degrees(found["ball_angle_deviation"].values)
        assert 0.6 < np.sqrt((pull**2).mean()) < 1.4
        deviations.append(float(found["ball_angle_deviation"].median()))
    assert deviations[1] > 2.8 * deviations[0]  # more than in proportion to the pixel, 2.67


def test_balls_that_move_too_far_between_pictures_are_not_lost_silently() -> None:
    angles = np.radians([0.0, 120.0]) + np.outer(TIME, [-40.0, -40.0])
    run, camera = made_up(angles), Camera.above(0.115, width=320, height=240, turning=True)
    film = ab.measure.render_film(run, camera=camera, exposure=ab.measure.Exposure(frame_rate=60.0, time=1e-5), end=0.2)
    setup = setup_of(run, camera)
    with pytest.raises(QuestionError, match=r"picture 2 at 0.0166.* expected.* first_ball_speed"):
        ab.measure.track_balls(film, setup)
    found = ab.measure.track_balls(film, setup, first_ball_speed="-40 rad/s")
    assert np.abs(errors(found, run)).max() < 0.3


def test_a_stroboscope_takes_one_picture_a_turn_with_the_rotor_always_at_the_same_angle() -> None:
    run = made_up(six())
    exposure = ab.measure.Exposure(frame_rate=1000.0, time=1e-5, stroboscope="turn", noise=0.0)
    camera = Camera.above(0.12, width=320, height=240)
    film = ab.measure.render_film(run, camera=camera, exposure=exposure)
    assert np.allclose(np.diff(film.time), 2.0 * np.pi / SPEED)
    assert np.allclose(np.angle(np.exp(1j * film.rotor_angle)), 0.0, atol=1e-6)


def test_a_rotor_that_a_stroboscope_holds_still_is_doubted_unless_its_speed_is_given() -> None:
    turn = 2.0 * np.pi / 100.0
    rests = [standing([0.5, 2.0], 0.077, 0.02, 100.0, 1e-3 * number) for number in range(3)]
    camera = ab.measure.film_camera(rests[0], width=320, height=240)
    exposure = ab.measure.Exposure(time=0.0, noise=0.01)
    pictures = np.array(
        [
            next(iter(ab.measure.render_film(one, camera=camera, exposure=exposure, end=2e-4, seed=number)))
            for number, one in enumerate(rests)
        ]
    )
    setup = ab.measure.film_setup(rests[0], camera)
    still = ab.measure.track_balls(pictures, setup, time=turn * np.arange(3))
    assert "give first_speed" in dict(still.facts())["doubt"]
    told = ab.measure.track_balls(pictures, setup, time=turn * np.arange(3), first_speed="955 rpm")
    assert "doubt" not in dict(told.facts())
    assert float(told["speed"].mean()) == pytest.approx(100.0, rel=0.01)


# the plane in the picture ------------------------------------------------------------------------------------------------


def corners() -> tuple[Floats, Floats]:
    places = np.array([[0.1, 0.0], [0.02, 0.09], [-0.1, 0.03], [-0.03, -0.1], [0.07, -0.06]])
    view = Camera.above(0.12, tilt="35 deg").view()
    return places, view.pixels(in_space(places[:, 0] + 1j * places[:, 1], 0.0))


def test_a_homography_maps_marks_to_their_pixels_and_lines_to_lines() -> None:
    places, pixels = corners()
    h = homography(places, pixels)
    assert np.allclose(mapped(h, places), pixels, atol=1e-8)
    middle = mapped(h, 0.5 * (places[0] + places[1]))
    side, part = pixels[1] - pixels[0], middle - pixels[0]
    assert abs(side[0] * part[1] - side[1] * part[0]) < 1e-6 * float(side @ side)


def test_a_lens_that_bends_lines_is_fitted_unasked_and_with_four_marks_is_part_of_the_deviations() -> None:
    places, _ = corners()
    z, random = places[:, 0] + 1j * places[:, 1], np.random.default_rng(3)
    balls, size = 0.08 * np.exp(2j * np.pi * np.arange(24) / 24), (1280, 720)
    camera = Camera.above(0.12, tilt="35 deg", distance="0.45 m", distortion=(-0.25,))
    seen = camera.view().pixels(in_space(balls, 0.006))
    held = {}
    for count, terms in ((5, {}), (4, {}), (4, {"distortion": 0})):
        hits = []
        for _ in range(6):
            pixels = camera.view().pixels(in_space(z[:count], 0.0)) + random.normal(0.0, 0.03, (count, 2))
            marks = [Mark((one.real, one.imag), 0.003, tuple(at)) for one, at in zip(z, pixels, strict=False)]
            known: dict[str, Any] = {"marks_exact": True, "pixel_deviation": 0.03, **terms}
            setup = FilmSetup(0.08, 0.012, 3, marks, ball_height=0.006, **known)
            found = camera_of(np.zeros(size[::-1], np.uint8), setup)
            got = found.view.places(seen, 0.006)
            away = np.angle((got[:, 0] + 1j * got[:, 1]) / balls)
            hits.append(np.abs(away) < 1.96 * found.angle_deviation(balls, 0.006, 0j))
        held[count, len(terms)] = np.mean(hits)
    assert held[5, 0] >= 0.9
    assert held[4, 0] >= 0.93
    assert held[4, 1] < 0.5


def test_the_homography_is_that_of_opencv() -> None:
    cv2 = pytest.importorskip("cv2")
    places, pixels = corners()
    noisy = pixels + np.random.default_rng(0).normal(0.0, 0.3, pixels.shape)
    peer, _ = cv2.findHomography(places, noisy[:], 0)
    own = homography(places, noisy)
    assert np.abs(mapped(own, places) - mapped(peer, places)).max() < 0.3, "both fit, with other weights of the noise"
    exact, _ = cv2.findHomography(places[:4], pixels[:4], 0)
    assert np.allclose(mapped(homography(places[:4], pixels[:4]), places), mapped(exact, places), atol=1e-3)


def test_distorted_pixels_are_those_of_opencv() -> None:
    cv2 = pytest.importorskip("cv2")
    camera = Camera.above(0.12, tilt="25 deg", distortion=(-0.25, 0.1))
    view = camera.view()
    points = in_space(np.array([0.1 + 0.02j, -0.05 + 0.08j, -0.09j]), 0.004)
    matrix = np.array([[view.focal_length, 0, view.middle[0]], [0, view.focal_length, view.middle[1]], [0, 0, 1.0]])
    turn, _ = cv2.Rodrigues(view.turn)
    peer, _ = cv2.projectPoints(points, turn, -view.turn @ view.position, matrix, np.array([-0.25, 0.1, 0.0, 0.0]))
    assert np.allclose(view.pixels(points), peer[:, 0], atol=1e-6)
    assert np.allclose(view.places(peer[:, 0], 0.004), points[:, :2], atol=1e-9)


def test_an_oblique_view_shows_the_focal_length_and_a_straight_one_says_that_it_does_not() -> None:
    camera = Camera.above(0.12, tilt="30 deg")
    places = 0.1 * np.exp(1j * np.arange(0.2, 6.0, 0.9))
    pixels = camera.view().pixels(in_space(places, 0.0))
    oblique = calibrate(places, pixels, (1280, 720))
    assert abs(oblique.view.focal_length / camera.focal_length - 1.0) < 1e-3
    straight = Camera.above(0.12)
    unsure = calibrate(places, straight.view().pixels(in_space(places, 0.0)), (1280, 720))
    assert unsure.covariance[6, 6] > 100.0 * oblique.covariance[6, 6]


# who is who --------------------------------------------------------------------------------------------------------------


def test_of_balls_that_touch_the_order_tells_who_is_who() -> None:
    expected = np.radians([10.0, 20.0, 100.0, 350.0])
    found = matched(expected, np.sort(np.radians([12.0, 21.0, 97.0, -8.0])), 0.05)
    assert found.find.tolist() == [1, 2, 3, 0]
    assert found.margin > 9.0


def test_a_ball_that_is_not_seen_takes_no_other_ones_place() -> None:
    expected = np.radians([10.0, 50.0, 100.0])
    assert matched(expected, np.radians([11.0, 101.0]), 0.05).find.tolist() == [0, -1, 1]


# photographs -------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def photograph() -> tuple[NDArray[np.uint8], FilmSetup, Camera, Floats]:
    """Two balls at the angles of run 1 at 4000 rpm in figure 10 of Rodrigues et al., seen obliquely past a bearing."""
    angles = np.radians([51.5, -75.6])
    run = made_up(np.tile(angles, (TIME.size, 1)))
    camera = Camera.above(0.12, tilt="35 deg", width=800, height=600, turning=True)
    film = ab.measure.render_film(run, camera=camera, exposure=ab.measure.Exposure(noise=0.02), end=0.001)
    return film.pictures[0], ab.measure.film_setup(run, camera), camera, angles


def test_a_photograph_from_the_side_gives_the_angles_of_its_balls(photograph: tuple[Any, ...], tmp_path: Path) -> None:
    picture, setup, _, angles = photograph
    found = ab.measure.photographed_angles(picture, setup)
    away = found["ball_angle"].values - np.sort(angles)
    assert np.degrees(np.abs(away)).max() < 0.15
    image = pytest.importorskip("PIL.Image")
    image.fromarray(picture).save(tmp_path / "photo.png")
    save_film_setup(setup, tmp_path / "setup.toml")
    again = ab.measure.photographed_angles(tmp_path / "photo.png", ab.measure.load_film_setup(tmp_path / "setup.toml"))
    assert np.allclose(again["ball_angle"], found["ball_angle"], atol=1e-6)
    asked = ["measure", "balls", str(tmp_path / "photo.png"), "--setup", str(tmp_path / "setup.toml")]
    kept = tmp_path / "angles.nc"
    answer = CliRunner().invoke(app, [*asked, "--out", str(kept)])
    assert answer.exit_code == 0, answer.output
    assert np.allclose(xr.load_dataset(kept)["ball_angle"], found["ball_angle"], atol=1e-6)
    refused = CliRunner().invoke(app, [*asked, "--frame-rate", "240 Hz"])
    assert "is a photograph" in " ".join(refused.output.split())


def test_clicked_balls_have_the_deviation_of_the_hand(photograph: tuple[Any, ...]) -> None:
    picture, setup, camera, angles = photograph
    exact = camera.view().pixels(in_space(ORBIT * np.exp(1j * angles), 0.5 * DIAMETER))
    hand = np.random.default_rng(2)
    pulls = []
    for _ in range(24):
        found = ab.measure.photographed_angles(picture, setup, clicked=exact + hand.normal(0.0, 1.0, (2, 2)))
        pulls.append((found["ball_angle"].values - np.sort(angles)) / found["ball_angle_deviation"].values)
    assert 0.7 < np.std(pulls) < 1.3  # of 48 pulls: 10 %, three times
    with pytest.raises(QuestionError, match="at one place"):
        ab.measure.photographed_angles(picture, setup, clicked=[exact[0], exact[0] + 1.0])
    with pytest.raises(QuestionError, match="beside the orbit"):
        ab.measure.photographed_angles(picture, setup, clicked=exact + np.array([[0.0, 0.0], [60.0, 0.0]]))


def test_a_histogram_counts_the_last_angles_and_knows_which_are_near_an_edge(photograph: tuple[Any, ...]) -> None:
    picture, setup, _, _ = photograph
    found = ab.measure.photographed_angles(picture, setup)
    counted = ab.measure.rest_histogram([found] * 3, bins=12)
    assert counted["count"].values.sum() == 6
    assert counted["count"].values[2] == 3, "51.5 degrees lie in the bin about 60"
    edge = float(found["ball_angle"][1])
    near = ab.measure.rest_histogram([found] * 3, bins=12, reference=edge - np.pi / 12.0)
    assert counted["count_deviation"].values.sum() == 0.0
    assert near["count_deviation"].values.sum() > 0.5


def test_pictures_of_films_are_drawn(oblique: tuple[Any, ...], photograph: tuple[Any, ...]) -> None:
    _, film, setup, found = oblique
    assert len(ab.plot.answer(found).axes) == 2
    seen = ab.measure.rectified_picture(film, setup, 2)
    assert np.hypot(seen["ball_x"], seen["ball_y"]).values == pytest.approx(ORBIT, abs=1.5e-3)
    assert len(ab.plot.answer(seen).axes[0].patches) == 7
    rest = ab.measure.rest_histogram([ab.measure.photographed_angles(*photograph[:2])])
    assert ab.plot.answer(rest, unbalance=0.0).axes[0].name == "polar"


# what cannot be ----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def short() -> tuple[ab.measure.Film, Callable[..., FilmSetup]]:
    run = made_up(six())
    camera = Camera.above(0.11, width=480, height=360)
    film = ab.measure.render_film(run, camera=camera, exposure=ab.measure.Exposure(frame_rate=200.0), end=0.05)
    return film, lambda **more: setup_of(run, camera, **more)


def test_rendering_and_tracking_say_how_far_they_are(short: tuple[Any, ...]) -> None:
    _, setup = short
    camera, told = Camera.above(0.11, width=480, height=360), []
    exposure = ab.measure.Exposure(frame_rate=200.0)
    run = made_up(six())
    film = ab.measure.render_film(
        run, camera=camera, exposure=exposure, end=0.02, progress=lambda *now: told.append(now)
    )
    ab.measure.track_balls(film, setup(), progress=lambda *now: told.append(now))
    assert told == [(0, 4), (1, 4), (2, 4), (3, 4), (1, 4), (2, 4), (3, 4), (4, 4)]


def test_a_camera_at_rest_without_marks_on_the_rotor_needs_a_tacho(short: tuple[Any, ...]) -> None:
    film, setup = short
    with pytest.raises(QuestionError, match="no marks on the rotor and no rotor_angle"):
        ab.measure.track_balls(film, setup(rotor_marks=()))
    found = ab.measure.track_balls(film, setup(rotor_marks=()), rotor_angle=film.rotor_angle)
    assert np.abs(errors(found, made_up(six()))).max() < 0.15


@pytest.mark.parametrize(("balls", "words"), [(5, "given 5 balls; 6 are seen"), (7, "given 7 balls; 6 are seen")])
def test_another_number_of_balls_is_refused(short: tuple[Any, ...], balls: int, words: str) -> None:
    film, setup = short
    with pytest.raises(QuestionError, match=words):
        ab.measure.track_balls(film, setup(balls=balls))


def test_a_film_without_marks_is_refused_with_the_mark_that_is_not_there(short: tuple[Any, ...]) -> None:
    film, setup = short
    given = setup()
    marks = [Mark(one.place, one.radius, (60.0 + 5.0 * k, 60.0 + 4.0 * (k % 2))) for k, one in enumerate(given.marks)]
    with pytest.raises(QuestionError, match="mark 1: no spot within"):
        ab.measure.track_balls(film, setup(marks=marks))


@pytest.mark.parametrize(("factor", "word"), [(0.0, "dark"), (60.0, "saturated")])
def test_dark_and_saturated_films_are_refused(short: tuple[Any, ...], factor: float, word: str) -> None:
    film, setup = short
    wrong = np.clip(film.pictures * factor, 0, 255).astype(np.uint8)
    with pytest.raises(QuestionError, match=word):
        ab.measure.track_balls(wrong, setup(), frame_rate=200.0)


def test_a_picture_with_a_hidden_ball_says_so_and_keeps_the_others(short: tuple[Any, ...]) -> None:
    film, setup = short
    pictures = film.pictures.copy()
    camera = Camera.above(0.11, width=480, height=360).view()
    place = ORBIT * np.exp(1j * (np.interp(film.time[6], TIME, six()[:, 2]) + film.rotor_angle[6]))
    column, row = camera.pixels(in_space(place, 0.5 * DIAMETER)).round().astype(int)
    pictures[6, row - 16 : row + 17, column - 16 : column + 17] = 56
    hidden = ab.measure.track_balls(pictures, setup(), time=film.time)
    assert hidden["fault"].values[6] == "5 of 6 balls seen"
    assert hidden["seen"].values[6].sum() == 5
    assert not np.isfinite(errors(hidden, made_up(six()))[6]).all()
    assert np.isfinite(errors(hidden, made_up(six()))[:6]).all()
    assert not hidden["seen"].values[6].all()
    assert hidden["seen"].values[7].all()


def test_marks_on_a_line_and_patterns_that_look_the_same_are_refused() -> None:
    with pytest.raises(QuestionError, match="all within 1000 m"):
        Mark((2e3, 0.0), 0.003, (10.0, 10.0))
    places = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [3.0, 0.0]])
    with pytest.raises(QuestionError, match="lie on a line"):
        homography(places, places)
    third = [Mark((0.05 * np.cos(a), 0.05 * np.sin(a)), 0.003, (1.0, 1.0)) for a in 2.0 * np.pi / 3.0 * np.arange(3)]
    with pytest.raises(QuestionError, match="look the same after 120 degrees"):
        FilmSetup(ORBIT, DIAMETER, 6, [*third, third[0]], third)


def test_a_file_that_is_no_film_is_refused(short: tuple[Any, ...], tmp_path: Path) -> None:
    _, setup = short
    (tmp_path / "no.mp4").write_bytes(b"this is no film" * 100)
    with pytest.raises(ResultError, match="cannot be read as a film"):
        ab.measure.track_balls(tmp_path / "no.mp4", setup())
    with pytest.raises(ResultError, match="no such file"):
        ab.measure.track_balls(tmp_path / "missing.mp4", setup())


def test_a_film_does_not_write_its_set_up_over_a_machine_of_the_same_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("autobalancer.measure.render_film", None)  # refused before
    ab.save_run(made_up(np.zeros((TIME.size, 1))), tmp_path / "race.nc")
    machine = tmp_path / "race.toml"
    machine.write_text('name = "mine"\n')
    words = ["measure", "film", str(tmp_path / "race.nc"), "--out", str(tmp_path / "race.mp4")]
    answer = CliRunner().invoke(app, words)
    assert isinstance(answer.exception, QuestionError) or answer.exit_code == 2
    assert "race.toml: is there and no set-up of a film" in " ".join(f"{answer.exception}{answer.stderr}".split())
    assert machine.read_text() == 'name = "mine"\n'

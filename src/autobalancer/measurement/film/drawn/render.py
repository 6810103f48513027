"""A film of a simulated race as a camera would see it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.drawn.camera import Camera, Exposure
from autobalancer.measurement.film.drawn.scene import LIGHT, Painter, Sizes, Things
from autobalancer.measurement.film.drawn.shutter import instants_of, picture_times
from autobalancer.measurement.film.marks import Mark, places_of
from autobalancer.measurement.film.video import Film, Gray, write_film
from autobalancer.patience import Progress, shows_progress, silent
from autobalancer.random_numbers import generator
from autobalancer.results.drawn.motion import Motion, Races, races_of
from autobalancer.results.given import Given, given_race_run
from autobalancer.units import argument, optional_argument

Floats = NDArray[np.float64]
ROTOR_MARKS, FRAME_MARKS = (
    (0.0, 70.0, 160.0, 235.0, 290.0),
    (20.0, 75.0, 140.0, 200.0, 265.0, 320.0),
)  # degrees; no two patterns alike
MOST = 20_000  # pictures


class Scenery(NamedTuple):
    """One race of a run with its marks."""

    motion: Motion
    races: Races
    balls: NDArray[np.intp]
    sizes: Sizes
    rotor_marks: tuple[Mark, ...]
    frame_marks: tuple[Mark, ...]

    def at(self, time: Floats, turning: bool) -> list[Things]:
        """Where everything is at some times, seen by a camera at rest or by one that turns with the rotor."""
        moments, races = self.motion.at(time), self.races.of(self.balls)
        turn = np.exp(1j * moments.rotor_angle)
        radius = races.orbit_radius - moments.ball_inside[:, self.balls]
        balls = races.center + radius * np.exp(1j * moments.ball_angle_in_rotor[:, self.balls])
        moved = moments.plane_deflection_in_rotor[:, int(races.plane[0])] * turn
        on_rotor, at_rest = places_of(self.rotor_marks), places_of(self.frame_marks)
        if turning:
            light = [_turned(LIGHT, -angle) for angle in moments.rotor_angle]
            frame = (at_rest - moved[:, None]) / turn[:, None]
            return [Things(0j, balls[k], on_rotor, frame[k], light[k]) for k in range(time.size)]
        return [
            Things(complex(moved[k]), moved[k] + turn[k] * balls[k], moved[k] + turn[k] * on_rotor, at_rest, LIGHT)
            for k in range(time.size)
        ]


def scenery(
    run: Given,
    race: int = 1,
    rotor_marks: Sequence[Mark] | None = None,
    frame_marks: Sequence[Mark] | None = None,
    ball_height: float | str | None = None,
) -> Scenery:
    """One race of a run with marks; by default five on the rotor and six around it, and balls that lie on their plane.

    Raises
    ------
    QuestionError
        If the run has no such race, or its balls have no diameter.
    """
    found = given_race_run(run, "measure.render_film")
    races = races_of(found)
    places = sorted(set(zip(races.balancer.tolist(), races.race.tolist(), strict=True)))
    if not 1 <= race <= len(places):
        raise QuestionError(f"race: given {race}; the run has {len(places)} races with balls, counted from 1")
    balls = np.flatnonzero((races.balancer == places[race - 1][0]) & (races.race == places[race - 1][1]))
    orbit, ball = float(races.orbit_radius[balls[0]]), 0.5 * float(races.ball_diameter[balls[0]])
    if not (ball > 0.0 and orbit > ball):
        raise QuestionError(
            f"race {race}: orbit radius {orbit:g} m, ball diameter {2.0 * ball:g} m; balls in a film need a diameter: give it in "
            "the machine"
        )
    spot = max(0.35 * ball, 0.035 * orbit)
    disc = orbit + 2.4 * ball
    if rotor_marks is None:
        rotor_marks = [_mark(0.62 * (orbit - ball), angle, spot) for angle in ROTOR_MARKS]
    if frame_marks is None:
        frame_marks = [_mark(disc + 2.2 * spot, angle, spot) for angle in FRAME_MARKS]
    height = ball if ball_height is None else argument("ball_height", ball_height, "m")
    on, around = (float(marks[0].radius) if marks else spot for marks in (rotor_marks, frame_marks))
    sizes = Sizes(orbit, ball, height, disc, on, around)
    return Scenery(Motion(found), races, balls, sizes, tuple(rotor_marks), tuple(frame_marks))


@shows_progress
def render_film(
    run: Given,
    path: str | Path | None = None,
    *,
    camera: Camera | None = None,
    exposure: Exposure | None = None,
    start: float | str | None = None,
    end: float | str | None = None,
    race: int = 1,
    rotor_marks: Sequence[Mark] | None = None,
    frame_marks: Sequence[Mark] | None = None,
    ball_height: float | str | None = None,
    seed: int = 0,
    progress: Progress | Literal[False] | None = None,
) -> Film:
    """Film a race of a run as a camera would see it.

    Parameters
    ----------
    run
        Of balls in races, with samples over time, or the path of its file.
    path
        Of the MP4 file; without one the pictures are an array in memory.
    camera
        By default one straight above, at rest.
    exposure
        Frame rate, shutter or stroboscope, light and noise.
    start, end
        Time in the run, s or texts; by default all samples.
    race
        Which race, counted from 1 over all balancers.
    rotor_marks, frame_marks
        Round marks on the rotor (in its frame) and on what stands still.
    ball_height
        Of the centers of the balls above the plane of the marks, m or a text; by default a ball radius.
    seed
        Of the noise and of lost pictures.
    progress
        Called with (pictures, their number). ``None`` shows a bar where a person is looking, ``False`` none.

    Returns
    -------
    Film
        With the time and the true rotor angle of each picture. Lost pictures are black.

    Raises
    ------
    QuestionError
        If the run has no samples or no such race, or the film would have no pictures or more than 20 000.
    """
    camera_, exposure_ = camera, exposure or Exposure()
    here = scenery(run, race, rotor_marks, frame_marks, ball_height)
    first, last = here.motion.time[0], here.motion.time[-1]
    begin, stop = optional_argument("start", start, "s"), optional_argument("end", end, "s")
    begin, stop = first if begin is None else begin, last if stop is None else stop
    if not first - 1e-9 <= begin < stop <= last + 1e-9:
        raise QuestionError(
            f"start, end: given {begin:g} s to {stop:g} s; the samples go from {first:g} s to {last:g} s"
        )
    lit = 0.5 * float(exposure_.time)
    time = picture_times(here.motion, max(begin, first + lit), min(stop, last - lit), exposure_)
    if not 1 <= time.size <= MOST:
        raise QuestionError(f"film: {time.size} pictures from {begin:g} s to {stop:g} s; 1 to {MOST} are possible")
    if camera_ is None:
        camera_ = Camera.above(1.2 * here.sizes.disc)
    angle = here.motion.at(time).rotor_angle
    pictures = _pictures(here, camera_, exposure_, time, seed, progress if callable(progress) else silent)
    if path is None:
        return Film(np.array(list(pictures)), time, angle)
    return Film(write_film(path, pictures, exposure_.frame_rate), time, angle)


def _pictures(
    here: Scenery, camera: Camera, exposure: Exposure, time: Floats, seed: int, progress: Progress
) -> Iterator[Gray]:
    painter = Painter(camera.view(), camera.width, camera.height, here.sizes)
    random = generator(seed)
    lost = random.random(time.size) < exposure.lost
    side = np.linspace(-1.0, 1.0, camera.width, dtype=np.float32) * np.float32(exposure.gradient[0])
    down = np.linspace(-1.0, 1.0, camera.height, dtype=np.float32) * np.float32(exposure.gradient[1])
    light = np.float32(255.0 * exposure.brightness) * (1.0 + side[None, :] + down[:, None])
    for k, moment in enumerate(time):
        progress(k, time.size)
        if lost[k]:
            yield np.zeros((camera.height, camera.width), np.uint8)
            continue
        instants = instants_of(here.motion, float(moment), exposure, here.sizes.orbit / painter.pixel)
        seen = here.at(instants, camera.turning)
        ground = painter.ground(sum(one.center for one in seen) / len(seen))
        total = np.zeros_like(ground)
        for things in seen:
            picture = ground.copy()
            painter.add(picture, things)
            total += picture
        total *= light / np.float32(len(seen))
        if exposure.noise:
            total += np.float32(255.0 * exposure.noise) * random.standard_normal(total.shape, dtype=np.float32)
        yield np.clip(total + 0.5, 0.0, 255.0).astype(np.uint8)


def _mark(radius: float, degrees: float, spot: float) -> Mark:
    z = radius * np.exp(1j * np.radians(degrees))
    return Mark((float(z.real), float(z.imag)), spot)


def _turned(vector: Floats, angle: float) -> Floats:
    z = complex(vector[0], vector[1]) * np.exp(1j * angle)
    return np.array([z.real, z.imag, vector[2]])

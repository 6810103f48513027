"""A film of a simulated race: camera, shutter and scene."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.arrays import Complexes, Floats
from autobalancer.errors import QuestionError
from autobalancer.measurement.film.optics import View, in_space, looking
from autobalancer.measurement.film.photograph import Film, Gray, write_film
from autobalancer.measurement.film.setup import FilmSetup, Mark, places_of
from autobalancer.progress import Progress, shows_progress, silent
from autobalancer.random_numbers import generator
from autobalancer.results.drawn import Motion, Races, races_of
from autobalancer.results.run_argument import RunArgument, load_race_run
from autobalancer.units import argument, field_arguments, optional_argument

# A film of a simulated race as a camera would see it.


# How a rotor with a race, balls and marks looks through a camera: brightness of pixels, drawn analytically.
#
# Edges are exact to a small part of a pixel: a pixel on an edge has as much of both sides as it covers.


Singles = NDArray[np.float32]

PLATE, DISC, HUB, FLOOR, MARK = 0.16, 0.46, 0.30, 0.22, 0.93  # brightness of what is flat
AMBIENT, DIFFUSE, GLOSS, SHARP = 0.30, 0.48, 0.75, 30.0  # of balls
LIGHT = np.array([0.35, 0.45, 0.82]) / np.linalg.norm([0.35, 0.45, 0.82])
STEPS = 4096  # of the table of brightness over the radius


class Scene(NamedTuple):
    """Where everything is at one instant, in the frame of the camera, m."""

    center: complex  # of the rotor
    balls: Complexes
    rotor_marks: Complexes
    frame_marks: Complexes
    light: NDArray[np.float64]


class Sizes(NamedTuple):
    """What does not change, m."""

    orbit: float
    ball: float  # radius
    ball_height: float  # of its center above the marks
    disc: float
    rotor_mark: float
    frame_mark: float


class Painter:
    """Draws instants of one scene through one view."""

    def __init__(self, view: View, width: int, height: int, sizes: Sizes) -> None:
        self.view, self.sizes = view, sizes
        columns, rows = np.meshgrid(np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64))
        rays = view.rays(np.stack([columns, rows], axis=-1))
        self.rays = np.ascontiguousarray(np.moveaxis(rays, -1, 0), np.float32)
        reach = np.where(rays[..., 2] < -1e-3, -view.position[2] / np.minimum(rays[..., 2], -1e-3), 1e3)
        self.x = (view.position[0] + reach * rays[..., 0]).astype(np.float32)
        self.y = (view.position[1] + reach * rays[..., 1]).astype(np.float32)
        self.pixel = float(np.linalg.norm(view.position)) / view.focal_length  # m in one pixel
        self._far = 1.3 * sizes.disc
        self._table = self._profile()
        self._ground: tuple[complex, Singles] | None = None

    def _profile(self) -> Singles:
        """Brightness over the radius, with edges as wide as a pixel."""
        s, radius = self.sizes, np.linspace(0.0, self._far, STEPS)
        level = np.full(STEPS, HUB)
        wide = 1.15 * s.ball
        edges = ((0.3 * s.orbit, DISC), (s.orbit - wide, FLOOR), (s.orbit + wide, DISC), (s.disc, PLATE))
        before = HUB
        for edge, after in edges:
            level += (after - before) * np.clip((radius - edge) / self.pixel + 0.5, 0.0, 1.0)
            before = after
        return level.astype(np.float32)

    def ground(self, center: complex) -> Singles:
        """Plate, disc and race without marks and balls; kept while the rotor does not move."""
        if self._ground is None or abs(self._ground[0] - center) > 0.005 * self.pixel:
            dx, dy = self.x - np.float32(center.real), self.y - np.float32(center.imag)
            radius = np.sqrt(dx * dx + dy * dy)
            place = np.minimum(radius * np.float32((STEPS - 1) / self._far), np.float32(STEPS - 1.001))
            low = place.astype(np.int32)
            share = place - low
            self._ground = (center, self._table[low] * (1.0 - share) + self._table[low + 1] * share)
        return self._ground[1]

    def add(self, picture: Singles, things: Scene) -> None:
        """Draw marks and balls into a picture of the ground."""
        for places, radius in (
            (things.frame_marks, self.sizes.frame_mark),
            (things.rotor_marks, self.sizes.rotor_mark),
        ):
            for mark in places:
                self._mark(picture, complex(mark), radius)
        height = self.sizes.ball_height
        points = in_space(things.balls, height)
        far = np.linalg.norm(points - self.view.position, axis=-1)
        for number in np.argsort(-far):  # the nearest last
            self._ball(picture, points[number], float(far[number]), things.light)

    def _patch(self, point: NDArray[np.float64], radius: float, picture: Singles) -> tuple[slice, slice]:
        column, row = self.view.pixels(point)
        reach = 1.3 * radius * self.view.focal_length / float(np.linalg.norm(point - self.view.position)) + 3.0
        rows = slice(max(0, int(row - reach)), max(0, min(picture.shape[0], int(row + reach) + 2)))
        return rows, slice(max(0, int(column - reach)), max(0, min(picture.shape[1], int(column + reach) + 2)))

    def _mark(self, picture: Singles, place: complex, radius: float) -> None:
        part = self._patch(in_space(place, 0.0), radius, picture)
        away = np.hypot(self.x[part] - np.float32(place.real), self.y[part] - np.float32(place.imag))
        cover = np.clip((radius - away) / self.pixel + 0.5, 0.0, 1.0)
        picture[part] += cover * (MARK - picture[part])

    def _ball(self, picture: Singles, point: NDArray[np.float64], far: float, light: NDArray[np.float64]) -> None:
        """A shaded ball with its highlight: rays that pass within its radius hit it."""
        radius = self.sizes.ball
        part = self._patch(point, radius, picture)
        ray = self.rays[(slice(None), *part)]
        away = (point - self.view.position).astype(np.float32)
        along = np.tensordot(away, ray, axes=1)
        squared = np.maximum(np.float32(far) ** 2 - along * along, 0.0)
        cover = np.clip((radius - np.sqrt(squared)) * (self.view.focal_length / far) + 0.5, 0.0, 1.0)
        depth = along - np.sqrt(np.maximum(radius**2 - squared, 0.0))
        normal = (ray * depth - away[:, None, None]) / np.float32(radius)
        half = light - away / far
        half /= np.linalg.norm(half)
        lit = np.maximum(np.tensordot(light.astype(np.float32), normal, axes=1), 0.0)
        shine = np.maximum(np.tensordot(half.astype(np.float32), normal, axes=1), 0.0) ** SHARP
        picture[part] += cover * (AMBIENT + DIFFUSE * lit + GLOSS * shine - picture[part])


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

    def at(self, time: Floats, turning: bool) -> list[Scene]:
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
            return [Scene(0j, balls[k], on_rotor, frame[k], light[k]) for k in range(time.size)]
        return [
            Scene(complex(moved[k]), moved[k] + turn[k] * balls[k], moved[k] + turn[k] * on_rotor, at_rest, LIGHT)
            for k in range(time.size)
        ]


def scenery(
    run: RunArgument,
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
    scenery = load_race_run(run, "measure.render_film")
    races = races_of(scenery)
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
    return Scenery(Motion(scenery), races, balls, sizes, tuple(rotor_marks), tuple(frame_marks))


@shows_progress
def render_film(
    run: RunArgument,
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
    # the shutter is open around each instant, so the first and last pictures keep half of that
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
    return Mark(place=(z.real, z.imag), radius=spot)


def _turned(vector: Floats, angle: float) -> Floats:
    z = complex(vector[0], vector[1]) * np.exp(1j * angle)
    return np.array([z.real, z.imag, vector[2]])


# When pictures are taken, and at which instants the light of one picture falls.


STEP = 0.7  # pixels between instants
MOST_INSTANTS = 64  # instants of one flash


def picture_times(motion: Motion, start: float, end: float, exposure: Exposure) -> Floats:
    """Middle of the light of each picture, s.

    Raises
    ------
    QuestionError
        If a stroboscope that follows the rotor has no turn.
    """
    if exposure.stroboscope != "turn":
        step = 1.0 / exposure.frame_rate
        return np.asarray(start + step * np.arange(int(np.floor((end - start) / step * (1.0 + 1e-12))) + 1))
    rotor = motion.at(np.linspace(start, end, 2)).rotor_angle / (2.0 * np.pi)
    passed = np.arange(np.ceil(rotor[0]), np.floor(rotor[1]) + 1.0)
    # when the rotor passes angles (rad), by bisection, which no shape of a run-up can mislead
    angles = 2.0 * np.pi * passed
    low, high = np.full(angles.size, start), np.full(angles.size, end)
    for _ in range(60):
        middle = 0.5 * (low + high)
        before = motion.at(middle).rotor_angle < angles
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    flashes = np.asarray(0.5 * (low + high))
    kept: list[float] = []
    for flash in flashes:
        if not kept or flash - kept[-1] >= (1.0 - 1e-6) / exposure.frame_rate:
            kept.append(float(flash))
    if not kept:
        raise QuestionError(f"stroboscope: the rotor makes no full turn from {start:g} s to {end:g} s")
    return np.array(kept)


def instants_of(motion: Motion, moment: float, exposure: Exposure, pixels: float) -> Floats:
    """Instants whose mean is one picture; ``pixels`` is the orbit radius in the picture."""
    first, last = float(motion.time[0]), float(motion.time[-1])
    lit = float(exposure.time)
    if isinstance(exposure.stroboscope, int | float):
        half = 0.5 / exposure.frame_rate
        rate = float(exposure.stroboscope)
        number = np.arange(np.ceil((moment - half) * rate), np.ceil((moment + half) * rate))
        middles = number / rate if number.size else np.array([moment])
        lit = min(lit, 1.0 / rate)
    else:
        middles = np.array([moment])
    at = motion.at(np.clip([moment], first, last))
    way = lit * pixels * (abs(float(at.speed[0])) + float(np.abs(motion.ball_slip).max(initial=0.0)))
    count = int(np.clip(np.ceil(way / STEP), 1, max(1, MOST_INSTANTS // middles.size)))
    within = lit * ((np.arange(count) + 0.5) / count - 0.5)
    return np.clip((middles[:, None] + within).ravel(), first, last)


# What films a simulated race: where the camera stands, and how it takes pictures.


@dataclass(frozen=True)
class Camera:
    """A camera above a rotor; the z axis points towards it, so that the rotor turns counterclockwise.

    Parameters
    ----------
    position, look_at
        Points of space, m: x, y in the plane of the marks and z above it.
    focal_length
        In pixels: width of the picture over twice the tangent of half the angle of view.
    width, height
        Of the picture, pixels.
    roll
        Rotation of the picture about the axis of the lens, rad or a text.
    distortion
        One or two radial terms.
    turning
        Whether the camera is fixed to the rotor and turns with it.

    Raises
    ------
    QuestionError
        If such a camera sees nothing.
    """

    position: tuple[float, float, float]
    focal_length: float
    look_at: tuple[float, float, float] = (0.0, 0.0, 0.0)
    width: int = 1280
    height: int = 720
    roll: float | str = 0.0
    distortion: tuple[float, ...] = ()
    turning: bool = False

    def __post_init__(self) -> None:
        field_arguments(self, roll="rad")
        if not (np.isfinite([*self.position, *self.look_at]).all() and self.position[2] > self.look_at[2]):
            raise QuestionError(f"camera: at {self.position} m; z must be above the point at which it looks")
        if not (math.isfinite(self.focal_length) and self.focal_length > 0.0):
            raise QuestionError(f"focal_length: given {self.focal_length}; must be greater than zero pixels")
        if not (64 <= self.width <= 7680 and 64 <= self.height <= 4320):
            raise QuestionError(f"width, height: given {self.width} x {self.height}; 64 x 64 to 7680 x 4320 pixels")
        if self.width % 2 or self.height % 2:
            raise QuestionError(f"width, height: given {self.width} x {self.height}; films have even numbers of pixels")
        if len(self.distortion) > 2:
            raise QuestionError(f"distortion: given {len(self.distortion)} terms; one or two radial terms are possible")

    @classmethod
    def above(
        cls,
        radius: float | str,
        *,
        tilt: float | str = 0.0,
        distance: float | str = 0.0,
        width: int = 1280,
        height: int = 720,
        distortion: tuple[float, ...] = (),
        turning: bool = False,
    ) -> Camera:
        """A camera that sees a circle about the axis in full, from the side of -y by ``tilt`` from the axis.

        Parameters
        ----------
        radius
            Of the circle, m or a text.
        tilt
            Angle between the lens and the axis of the rotor, rad or a text.
        distance
            From the middle of the circle; by default eight times the radius.
        width, height, distortion, turning
            As of the camera.

        Raises
        ------
        QuestionError
            If the tilt is 80 degrees or more.
        """
        reach, angle = argument("radius", radius, "m"), argument("tilt", tilt, "rad")
        away = argument("distance", distance, "m") or 8.0 * reach
        if not (0.0 <= angle < math.radians(80.0) and 0.0 < reach < away):
            raise QuestionError(
                f"camera: tilt {math.degrees(angle):g} degrees, {away:g} m from a circle of radius {reach:g} m; the tilt must be "
                "from 0 to below 80 degrees, and the camera outside of the circle"
            )
        near = away - reach * math.sin(angle)
        focal_length = 0.49 * min(width, height) * near / reach
        place = (0.0, -away * math.sin(angle), away * math.cos(angle))
        return cls(place, focal_length, width=width, height=height, distortion=distortion, turning=turning)

    def view(self) -> View:
        """Its projection."""
        k1, k2 = (*self.distortion, 0.0, 0.0)[:2]
        return View(
            looking(self.position, self.look_at, float(self.roll)),
            np.array(self.position, np.float64),
            float(self.focal_length),
            (0.5 * (self.width - 1), 0.5 * (self.height - 1)),
            (float(k1), float(k2)),
        )


@dataclass(frozen=True)
class Exposure:
    """When and how pictures are taken.

    Parameters
    ----------
    frame_rate
        Pictures a second, in Hz or a text such as ``"240 Hz"`` (turns play no part here: 240 Hz are 240 pictures a second).
    time
        How long the shutter is open, or a flash lasts, s or a text.
    stroboscope
        "" for a shutter; "turn" for one flash and one picture each time the zero mark passes the x axis (every second, third ...
        turn where the camera is slower than the rotor); a number for flashes of a lamp with this rate, in Hz: then the shutter is
        open all the time, and a picture has all flashes that fall into it.
    brightness
        Gain of the camera: 1 shows white as nearly full.
    gradient
        Change of the light from the middle to the right and to the lower edge, as a share.
    noise
        Standard deviation of a pixel, share of full scale.
    lost
        Share of the pictures that are lost, at random; they are black in the film.

    Raises
    ------
    QuestionError
        If one of them is not possible.
    """

    frame_rate: float = 240.0
    time: float | str = 2e-4
    stroboscope: str | float = ""
    brightness: float = 1.0
    gradient: tuple[float, float] = (0.0, 0.0)
    noise: float = 0.01
    lost: float = 0.0

    def __post_init__(self) -> None:
        field_arguments(self, time="s")
        if not (math.isfinite(self.frame_rate) and 0.0 < self.frame_rate <= 1e6):
            raise QuestionError(f"frame_rate: given {self.frame_rate}; must be above 0 and up to 1e6 pictures a second")
        if not 0.0 <= float(self.time) * self.frame_rate <= 1.0 + 1e-9:
            raise QuestionError(
                f"exposure time: given {self.time:g} s at {self.frame_rate:g} pictures a second; a picture has "
                f"{1.0 / self.frame_rate:g} s at most"
            )
        lamp = isinstance(self.stroboscope, int | float) and 0.0 < self.stroboscope <= 1e5
        if not lamp and self.stroboscope not in ("", "turn"):
            raise QuestionError(
                f"stroboscope: given {self.stroboscope!r}; must be 'turn', a rate up to 1e5 Hz, or '' for a shutter"
            )
        if not (0.0 <= self.noise <= 1.0 and 0.0 <= self.lost < 1.0 and self.brightness > 0.0):
            raise QuestionError(
                f"noise {self.noise:g}, lost {self.lost:g}, brightness {self.brightness:g}: noise is from 0 to 1, lost from 0 to "
                "below 1, brightness above 0"
            )


# The camera and the set-up of such a film.


def film_camera(
    run: RunArgument,
    *,
    tilt: float | str = 0.0,
    width: int = 1280,
    height: int = 720,
    distortion: tuple[float, ...] = (),
    turning: bool = False,
    race: int = 1,
) -> Camera:
    """A camera that sees a race of a run with its marks in full.

    Parameters
    ----------
    run
        Of balls in races, or the path of its file.
    tilt
        Angle between the lens and the axis of the rotor, rad or a text.
    width, height
        Of the picture, pixels.
    distortion
        One or two radial terms.
    turning
        Whether the camera turns with the rotor.
    race
        Which race, counted from 1 over all balancers.

    Raises
    ------
    QuestionError
        If the run has no such race, or the camera is not possible.
    """
    reach = 1.2 * scenery(run, race).sizes.disc
    return Camera.above(reach, tilt=tilt, width=width, height=height, distortion=distortion, turning=turning)


def film_setup(run: RunArgument, camera: Camera, *, race: int = 1) -> FilmSetup:
    """The set-up of a film that ``render_film`` makes of a run with this camera and the usual marks.

    Parameters
    ----------
    run, camera
        As given to ``render_film``.
    race
        Which race, counted from 1 over all balancers.

    Raises
    ------
    QuestionError
        As :func:`~autobalancer.measure.render_film`.
    """
    here, view = scenery(run, race), camera.view()
    shown = here.rotor_marks if camera.turning else here.frame_marks
    marks = []
    for mark in shown:
        column, row = view.pixels(in_space(mark.z, 0.0))
        marks.append(Mark(place=mark.place, radius=mark.radius, pixel=(round(float(column), 1), round(float(row), 1))))
    return FilmSetup(
        orbit_radius=here.sizes.orbit,
        ball_diameter=2.0 * here.sizes.ball,
        balls=len(here.balls),
        marks=tuple(marks),
        rotor_marks=() if camera.turning else here.rotor_marks,
        ball_height=here.sizes.ball_height,
        camera="turning" if camera.turning else "rest",
        distortion=max(1, len(camera.distortion)),
    )

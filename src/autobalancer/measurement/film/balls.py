"""Where the balls are in one picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autobalancer.measurement.film.optics import ANYWHERE, Outline, View, ball_outlines, in_space, located, sampled
from autobalancer.measurement.film.setup import FilmSetup

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]
Gray = NDArray[np.uint8]
POINTS = 56
LEAST = 0.3  # share of the edge of a ball that must be seen
SIDE = 0.5  # of the edge only what faces along the race within 60 degrees counts: beside it are the walls
MIRRORS = 0.05  # share of finds that fit no ball, from which on it is said
CLOSER = 0.6  # of the contact angle: two finds so near each other are one ball


class Seen(NamedTuple):
    """Balls of one picture, in the order of their angles."""

    place: Complexes  # m, of the centers in space
    deviation: Floats  # m, along the race
    height: Floats  # of the peaks of the search, of 255


class BallSearch:
    """Looks for balls of equal look in a race."""

    def __init__(self, view: View, setup: FilmSetup, background: Background) -> None:
        self.view, self.setup = view, setup
        pixel = view.focal_length / float(np.linalg.norm(view.position))
        self.steps = steps_around(setup.orbit_radius * pixel)
        around = setup.orbit_radius * np.exp(2j * np.pi * np.arange(self.steps) / self.steps)
        self.circle = circle(ball_outlines(view, around, setup.ball_height, 0.5 * setup.ball_diameter, 24))
        self.background = background
        self.dark = False  # balls darker than the race

    def candidates(self, picture: Gray, most: int, center: complex) -> tuple[Floats, Floats]:
        """Angles in space about the middle of the race, and heights, of the highest peaks."""
        there, here = self.view.pixels(in_space(np.array([center, 0j]), self.setup.ball_height))
        score = self.circle.scores(picture, there - here)
        return peaks(-score if self.dark else score, 0.75 * self.setup.contact_angle, most)

    def found(self, picture: Gray, angles: Floats, heights: Floats, center: complex, noise: float) -> Seen:
        """The balls near these angles, by their edges; an edge behind or beside a ball that touches does not count."""
        place = center + self.setup.orbit_radius * np.exp(1j * angles)
        radius, height = 0.5 * self.setup.ball_diameter, self.setup.ball_height

        def behind(pixels: Floats) -> Floats:
            return self.background.at(pixels, center)

        covariance, share = np.zeros((len(place), 2, 2)), np.zeros(len(place))
        for turn in range(3):
            outline = ball_outlines(self.view, place, height, radius, POINTS)
            usable = _free(outline.edge, self.view.pixels(in_space(place, height)))
            slope = self._slope(place, center)
            usable &= (
                np.abs(np.einsum("tpi,ti->tp", outline.outwards, slope)) > SIDE * np.linalg.norm(slope, axis=1)[:, None]
            )
            edge = located(picture, outline, rises=True, noise=noise, usable=usable, behind=behind)
            pixels = self.view.pixels(in_space(place, height)) + edge.shift
            moved = self.view.places(pixels, height)
            place = moved[:, 0] + 1j * moved[:, 1]
            covariance, share = edge.covariance, edge.share
            if turn == 0:  # from the search they are off by up to some pixels along the race, never across
                place = center + self.setup.orbit_radius * np.exp(1j * np.angle(place - center))
        slope = self._slope(place, center)
        size = (slope**2).sum(axis=1)
        deviation = np.sqrt(np.einsum("ti,tij,tj->t", slope, covariance, slope)) / size
        off = np.abs(np.abs(place - center) - self.setup.orbit_radius)
        kept = np.flatnonzero((share >= LEAST) & (off < 0.4 * self.setup.ball_diameter))
        kept = kept[np.argsort(np.angle(place[kept] - center), kind="stable")]
        kept = _apart(kept, place, heights, center, CLOSER * self.setup.contact_angle)
        return Seen(place[kept], deviation[kept], heights[kept])

    def _slope(self, place: Complexes, center: complex) -> Floats:
        """Pixels for each meter along the race."""
        away, height = place - center, self.setup.ball_height
        ahead = place + 1e-5 * 1j * away / np.abs(away)
        return np.asarray(
            (self.view.pixels(in_space(ahead, height)) - self.view.pixels(in_space(place, height))) / 1e-5
        )


def mirror_warning(deviation: Floats, setup: FilmSetup) -> str:
    """What to do where edges fit no ball of the known size; ``deviation`` (rad) is that of all angles."""
    anywhere = 0.99 * ANYWHERE * 0.5 * setup.ball_diameter / setup.orbit_radius
    share = float((deviation[np.isfinite(deviation)] >= anywhere).mean()) if np.isfinite(deviation).any() else 0.0
    if share < MIRRORS:
        return ""
    return (
        f"in {100.0 * share:.0f} % of the finds the edges do not fit a ball of diameter {setup.ball_diameter:g} m, so its angle "
        "is known to a part of its radius only; polished balls mirror the room: make them dull or light them from all sides, and "
        "check ball_diameter and ball_height"
    )


def _free(edge: Floats, centers: Floats) -> NDArray[np.bool_]:
    """Points of outlines that are nearer to the middle of their own ball than to that of any other, by some pixels."""
    if len(centers) < 2:
        return np.ones(edge.shape[:2], np.bool_)
    far = np.linalg.norm(edge[:, :, None, :] - centers, axis=-1)
    own = np.take_along_axis(far, np.arange(len(centers))[:, None, None], axis=2)[..., 0]
    others = np.where(np.eye(len(centers), dtype=np.bool_)[:, None, :], np.inf, far).min(axis=-1)
    return np.asarray(others > own + np.minimum(3.0, 0.3 * own))


def _apart(
    kept: NDArray[np.intp], place: Complexes, heights: Floats, center: complex, least: float
) -> NDArray[np.intp]:
    """Of finds at one place the one with the higher peak."""
    chosen: list[int] = []
    for one in kept[np.argsort(-heights[kept], kind="stable")]:
        if all(abs(np.angle((place[one] - center) / (place[other] - center))) >= least for other in chosen):
            chosen.append(int(one))
    return np.array([one for one in kept if one in chosen], np.intp)


# How the race looks without balls: the same all around the axis but for the light, which changes slowly around it.


ANGLES = 180
REACH = 3.0  # ball radii inside and outside of the orbit
WAVES = 2  # of the light around the axis


class Background:
    """Brightness of the race over the radius, the median around the axis, times the light over the angle."""

    def __init__(self, view: View, setup: FilmSetup, pictures: Sequence[Gray], centers: Sequence[complex]) -> None:
        self.view = view
        pixel = float(np.linalg.norm(view.position)) / view.focal_length
        half = 0.5 * REACH * setup.ball_diameter
        count = int(np.clip(2.0 * half / (0.4 * pixel), 8, 400))
        self.radius = np.linspace(
            max(setup.orbit_radius - half, 0.02 * setup.orbit_radius), setup.orbit_radius + half, count
        )
        angle = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
        circles = self.radius[:, None] * np.exp(1j * angle)
        seen = np.array(
            [
                sampled(picture, view.pixels(in_space(at + circles, 0.0)))
                for picture, at in zip(pictures, centers, strict=True)
            ]
        )
        level = np.median(seen, axis=(0, 2))
        waves = _waves(angle)
        share = np.median(seen, axis=0) / np.maximum(level, 1.0)[:, None]
        self.light = np.linalg.lstsq(waves, np.median(share, axis=0), rcond=None)[0]
        light = waves @ self.light
        self.level = np.median(seen / np.maximum(light, 0.1), axis=(0, 2))

    def at(self, pixels: Floats, center: complex) -> Floats:
        """Brightness of pixels (..., 2), of 255, if no ball were there."""
        place = self.view.places(pixels)
        z = place[..., 0] + 1j * place[..., 1] - center
        return np.asarray(np.interp(np.abs(z), self.radius, self.level) * (_waves(np.angle(z)) @ self.light))


def _waves(angle: Floats) -> Floats:
    rows = [np.ones_like(angle)]
    for k in range(1, WAVES + 1):
        rows += [np.cos(k * angle), np.sin(k * angle)]
    return np.stack(rows, axis=-1)


# Round things on a circle, looked for all around it: where a ring of their size separates light from dark.


SEARCH_POINTS = 24  # of a ring
AWAY = 1.6  # pixels inside and outside of the edge


class Circle(NamedTuple):
    """Rings all around a circle, at equal steps from angle zero."""

    inner: NDArray[np.float64]
    outer: NDArray[np.float64]

    def scores(self, picture: Gray, shift: Floats | float = 0.0) -> Floats:
        """Mean step from outside to inside of each ring, all shifted by some pixels, of 255, less that without things."""
        step = sampled(picture, self.inner + shift) - sampled(picture, self.outer + shift)
        score = step.mean(axis=-1).astype(np.float64)
        return np.asarray(score - np.median(score))


def circle(outline: Outline, away: float = AWAY) -> Circle:
    """Rings from the outlines of a thing at all places of a circle, so many pixels inside and outside."""
    return Circle(outline.beside(-away), outline.beside(away))


def steps_around(radius_in_pixels: float) -> int:
    """Number of places on a circle, a little more than a pixel apart."""
    return int(np.clip(2.0 * np.pi * radius_in_pixels / 1.2, 240, 2400))


def peaks(score: Floats, apart: float, most: int) -> tuple[Floats, Floats]:
    """Angles (rad) and heights of the highest peaks at least ``apart`` (rad) from each other, the highest first."""
    count = score.size
    top = (score >= np.roll(score, 1)) & (score > np.roll(score, -1))
    places = np.flatnonzero(top)
    places = places[np.argsort(-score[places], kind="stable")]
    kept: list[int] = []
    step = 2.0 * np.pi / count
    for place in places:
        gaps = [abs((place - other + count // 2) % count - count // 2) * step for other in kept]
        if all(gap >= apart for gap in gaps):
            kept.append(int(place))
        if len(kept) == most:
            break
    at = np.array(kept, np.intp)
    before, here, after = score[at - 1], score[at], score[(at + 1) % count]
    bend = np.minimum(before - 2.0 * here + after, -1e-12)
    return np.asarray((at + np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) * step), np.asarray(here)

"""One picture of a film seen from straight above, with the balls that were found."""

from __future__ import annotations

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.measurement.film.edges import sampled
from autobalancer.measurement.film.optics.view import in_space
from autobalancer.measurement.film.pictures import FIRST, Reader
from autobalancer.measurement.film.setup import FilmSetup
from autobalancer.measurement.film.video import Film, Gray
from autobalancer.results.answers.labeled import Labeled
from autobalancer.results.provenance import provenance

SIZE = 600  # pixels of the rectified picture


def rectified_picture(film: Film, setup: FilmSetup, number: int) -> Labeled:
    """A picture in the plane of the ball centers, to see whether marks, race and balls are where they should be.

    Parameters
    ----------
    film
        With its pictures.
    setup
        Race, marks and camera.
    number
        Of the picture, from 1.

    Returns
    -------
    Labeled
        Dataset over ``y`` and ``x`` (m): ``brightness`` (of 255); over ``ball`` the places ``ball_x``, ``ball_y`` found in it.

    Raises
    ------
    QuestionError
        If there is no such picture, or the film cannot be evaluated.
    """
    first: list[Gray] = []
    picture = None
    for k, one in enumerate(film, 1):
        if len(first) < FIRST:
            first.append(one)
        if k == number:
            picture = one
        if k >= number and len(first) == FIRST:
            break
    if picture is None:
        raise QuestionError(f"picture: given {number}; the film has fewer, counted from 1")
    reader = Reader(first, setup)
    _, seen, fault = reader.read(picture, setup.balls, None)
    reach = 1.15 * max([setup.orbit + setup.diameter, *(abs(mark.z) for mark in setup.marks)])
    side = np.linspace(-reach, reach, SIZE)
    pixels = reader.calibration.view.pixels(in_space(side[None, :] + 1j * side[:, None], setup.height))
    data = xr.Dataset(
        {
            "brightness": (("y", "x"), sampled(picture, pixels), {"long_name": "brightness", "units": ""}),
            "ball_x": ("ball", seen.place.real, {"long_name": "place of a ball along x", "units": "m"}),
            "ball_y": ("ball", seen.place.imag, {"long_name": "place of a ball along y", "units": "m"}),
        },
        {"x": ("x", side, {"units": "m"}), "y": ("y", side, {"units": "m"})},
        {
            "title": f"picture {number} rectified" + (f": {fault}" if fault else ""),
            "orbit_radius": setup.orbit,
            "ball_diameter": setup.diameter,
            **provenance(),
        },
    )
    return Labeled.of(data)

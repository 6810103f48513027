"""What was found in a film as one dataset, under the names of runs."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.measurement.film.balls import mirror_warning
from autobalancer.measurement.film.follow import Followed
from autobalancer.measurement.film.happenings import Contacts
from autobalancer.measurement.film.labels import labeled
from autobalancer.measurement.film.pictures import Pictures
from autobalancer.measurement.film.rotor import RotorPlace
from autobalancer.measurement.film.setup import FilmSetup
from autobalancer.results.answers.ball_film import BallFilm
from autobalancer.results.provenance import provenance

Floats = NDArray[np.float64]
UNSURE = 9.0  # least margin of an identity, in squares of deviations


def ball_film(
    time: Floats,
    rotor_angle: Floats,
    speed: Floats,
    rotor: list[RotorPlace],
    followed: Followed,
    rates: tuple[Floats, Floats],
    hits: Contacts,
    events: list[tuple[float, str]],
    faults: list[str],
    found: Pictures,
    setup: FilmSetup,
) -> BallFilm:
    """The dataset of :func:`~autobalancer.measurement.film.track.track_balls`."""
    both = ("time", "ball")
    center = np.array([place.center for place in rotor])
    moved = bool(setup.rotor_marks) and len(setup.rotor_marks) > 1 and setup.camera == "rest"
    seen = np.isfinite(followed.angle)
    data = xr.Dataset(
        {
            "ball_angle": (both, followed.angle),
            "ball_angle_deviation": (both, followed.deviation),
            "ball_speed": (both, rates[0]),
            "ball_speed_deviation": (both, rates[1]),
            "seen": (both, seen),
            "identity_margin": ("time", followed.margin),
            "fault": ("time", np.array(faults, dtype=object).astype(str)),
            "rotor_angle": ("time", rotor_angle),
            "speed": ("time", speed),
            "impact_speed": ("impact", hits.speed),
            "impact_ball": ("impact", hits.ball),
            "impact_partner": ("impact", hits.partner),
            "event_name": ("event", np.array([name for _, name in events], dtype=object).astype(str)),
        },
        {
            "time": time,
            "ball": np.arange(1, setup.balls + 1),
            "impact_time": ("impact", hits.time),
            "event_time": ("event", np.array([at for at, _ in events], np.float64)),
            "orbit_radius": ("ball", np.full(setup.balls, setup.orbit)),
            "ball_diameter": ("ball", np.full(setup.balls, setup.diameter)),
        },
    )
    if moved:
        angle = np.array([place.angle for place in rotor])
        known = np.where(np.isfinite(angle), center, np.nan)
        data["x"], data["y"] = ("time", known.real), ("time", known.imag)
    labeled(data)
    margin = followed.margin[np.isfinite(followed.margin)]
    data.attrs.update(
        title="balls in a film",
        camera=setup.camera,
        mark_residual=found.calibration.residual,
        focal_length=found.calibration.view.focal_length,
        distortion=list(found.calibration.view.distortion),
        noise=found.noise,
        warnings=mirror_warning(followed.deviation, setup),
        unsure_identities=int((margin < UNSURE).sum()),
        **provenance(),
    )
    return BallFilm.of(data)

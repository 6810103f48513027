"""Film set-ups as TOML files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.text import read_toml
from autobalancer.machine.part import unknown_key
from autobalancer.measurement.film.drawn import Camera, scenery
from autobalancer.measurement.film.optics import in_space
from autobalancer.measurement.film.setup import FilmSetup, Mark
from autobalancer.results.run_argument import Given
from autobalancer.safe_file import as_path, write_text_safely

KEYS = (
    "orbit_radius", "ball_diameter", "balls", "ball_height", "camera", "focal_length", "distortion", "race_center",
    "marks_exact", "pixel_deviation", "marks", "rotor_marks",
)  # fmt: skip
OF_MARKS = ("place", "radius", "pixel")


def load_film_setup(path: str | Path) -> FilmSetup:
    """Read a set-up from a TOML file.

    Parameters
    ----------
    path
        With the keys of :class:`~autobalancer.measure.FilmSetup`; ``[[marks]]`` and ``[[rotor_marks]]`` have ``place``,
        ``radius`` and ``pixel``.

    Raises
    ------
    QuestionError
        If the file, a key or a value is wrong; the message names it.
    """
    path = as_path(path)
    data = read_toml(path)
    for key in data:
        if key not in KEYS:
            raise QuestionError(f"{path}: {key}: {unknown_key(key, KEYS)}")
    for key in ("orbit_radius", "ball_diameter", "balls", "marks"):
        if key not in data:
            raise QuestionError(f"{path}: {key} is missing; it has no default")
    try:
        for kind in ("marks", "rotor_marks"):
            data[kind] = [_mark(entry, f"{kind}[{n}]") for n, entry in enumerate(data.get(kind, []), 1)]
        return FilmSetup(**data)
    except AutobalancerError as reason:
        raise QuestionError(f"{path}: {reason}") from None
    except (TypeError, ValueError) as reason:
        raise QuestionError(f"{path}: a value has the wrong form: {reason}") from None


def _mark(entry: Any, where: str) -> Mark:
    if not isinstance(entry, dict):
        raise QuestionError(f"{where}: must be a table with place, radius and pixel")
    for key in entry:
        if key not in OF_MARKS:
            raise QuestionError(f"{where}.{key}: {unknown_key(key, OF_MARKS)}")
    for key in ("place", "radius"):
        if key not in entry:
            raise QuestionError(f"{where}: {key} is missing; it has no default")
    pixel = entry.get("pixel")
    place = entry["place"]
    if len(place) != 2 or (pixel is not None and len(pixel) != 2):
        raise QuestionError(f"{where}: place is [x, y], pixel is [column, row]")
    return Mark((place[0], place[1]), entry["radius"], None if pixel is None else (float(pixel[0]), float(pixel[1])))


def film_camera(
    run: Given,
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


def film_setup(run: Given, camera: Camera, *, race: int = 1) -> FilmSetup:
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
        marks.append(Mark(mark.place, mark.radius, (round(float(column), 1), round(float(row), 1))))
    return FilmSetup(
        here.sizes.orbit,
        2.0 * here.sizes.ball,
        len(here.balls),
        marks,
        () if camera.turning else here.rotor_marks,
        here.sizes.ball_height,
        "turning" if camera.turning else "rest",
        distortion=max(1, len(camera.distortion)),
    )


def save_film_setup(setup: FilmSetup, path: str | Path) -> Path:
    """Write a set-up as a TOML file that :func:`load_film_setup` reads.

    Parameters
    ----------
    setup
        To be written.
    path
        Of the file.

    Raises
    ------
    ResultError
        If the file cannot be written.
    """
    import tomli_w

    data: dict[str, Any] = {
        "orbit_radius": setup.orbit,
        "ball_diameter": setup.diameter,
        "balls": setup.balls,
        "ball_height": setup.height,
        "camera": setup.camera,
        "distortion": setup.distortion if isinstance(setup.distortion, int) else [float(k) for k in setup.distortion],
        "race_center": [float(c) for c in setup.race_center],
        "marks_exact": setup.marks_exact,
        "pixel_deviation": setup.pixel_deviation,
        "marks": [_table(mark) for mark in setup.marks],
        "rotor_marks": [_table(mark) for mark in setup.rotor_marks],
    }
    if setup.focal_length is not None:
        data["focal_length"] = float(setup.focal_length)
    return write_text_safely(path, tomli_w.dumps(data))


def _table(mark: Mark) -> dict[str, Any]:
    at = {} if mark.pixel is None else {"pixel": [float(c) for c in mark.pixel]}
    return {"place": [mark.z.real, mark.z.imag], "radius": float(mark.radius), **at}

"""Film set-ups as TOML files."""

from __future__ import annotations

from pathlib import Path

from autobalancer.files.machine_file import part_text
from autobalancer.files.text_files import faults_of, read_toml
from autobalancer.measurement.film.drawn import Camera, scenery
from autobalancer.measurement.film.optics import in_space
from autobalancer.measurement.film.setup import FilmSetup, Mark
from autobalancer.results.run_argument import RunArgument
from autobalancer.safe_file import as_path, write_text_safely


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
    with faults_of(str(path)):
        return FilmSetup(**read_toml(path))


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
    return write_text_safely(path, part_text(setup))

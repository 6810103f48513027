"""Ball angles from one photograph, and where balls come to rest in many."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, ResultError
from autobalancer.measurement.film.balls import BallsInPicture, Reader, mirror_warning
from autobalancer.measurement.film.optics import Calibration, camera_of
from autobalancer.measurement.film.setup import FilmSetup, labeled
from autobalancer.results.answers.answer import Labeled, provenance
from autobalancer.safe_file import as_path, not_to_read, write_safely

Gray = NDArray[np.uint8]
LIGHT = (0.299, 0.587, 0.114)  # of red, green and blue, as films have it


def photographed_angles(
    photograph: str | Path | ArrayLike, setup: FilmSetup, *, clicked: ArrayLike | None = None
) -> Labeled:
    """Angles of the balls in the rotor from one photograph, as Rodrigues et al. (2011), section 6.2, read them.

    Parameters
    ----------
    photograph
        Path of a picture (PNG, JPEG), or an array (rows, columns) or (rows, columns, 3) of 8 bits.
    setup
        With ``marks`` on the rotor, whose places count from its zero mark.
    clicked
        Pixels (column, row) of the ball centers as a person gives them, (balls, 2), with ``setup.pixel_deviation``; by default
        the balls are found.

    Returns
    -------
    Labeled
        Dataset over ``ball``: ``ball_angle`` (rad, in the rotor, increasing) and ``ball_angle_deviation`` (one standard
        deviation).

    Raises
    ------
    QuestionError
        If marks or balls are not found, their number is another one, two are at one place, or one is not in the race.
    ResultError
        If the picture cannot be read.
    """
    picture = _gray(photograph)
    if clicked is None:
        turning = setup.model_copy(update={"camera": "turning", "rotor_marks": ()})
        reader = Reader([picture], turning)
        _, seen, fault = reader.read(picture, setup.balls, None)
        if fault or seen.place.size != setup.balls:
            raise QuestionError(f"photograph: {fault or f'{seen.place.size} of {setup.balls} balls seen'}")
        camera = reader.calibration
    else:
        camera = camera_of(picture, setup)
        seen = _clicked(np.asarray(clicked, np.float64), camera, setup)
    middle = complex(*setup.race_center)
    angle = np.angle(seen.place - middle)
    spread = np.hypot(
        seen.deviation / setup.orbit_radius, camera.angle_deviation(seen.place, setup.ball_height, middle)
    )
    order = np.argsort(angle, kind="stable")
    data = xr.Dataset(
        {"ball_angle": ("ball", angle[order]), "ball_angle_deviation": ("ball", spread[order])},
        {"ball": np.arange(1, angle.size + 1)},
    )
    how = "clicked" if clicked is not None else "found"
    warnings = mirror_warning(spread, setup) if clicked is None else ""
    data.attrs.update(
        title=f"balls of a photograph, {how}", mark_residual=camera.residual, warnings=warnings, **provenance()
    )
    return Labeled.of(labeled(data))


def _clicked(pixels: Floats, camera: Calibration, setup: FilmSetup) -> BallsInPicture:
    if pixels.shape != (setup.balls, 2) or not np.isfinite(pixels).all():
        raise QuestionError(f"clicked: given {pixels.shape}; give column and row of each of the {setup.balls} balls")
    places = camera.view.places(pixels, setup.ball_height)
    place = places[:, 0] + 1j * places[:, 1]
    off = np.abs(np.abs(place - complex(*setup.race_center)) - setup.orbit_radius)
    for number in np.flatnonzero(off > 0.5 * setup.ball_diameter):
        raise QuestionError(
            f"clicked: ball {number + 1} at pixel ({pixels[number, 0]:g}, {pixels[number, 1]:g}) is "
            f"{1e3 * off[number]:.3g} mm beside the orbit of the race; check its pixel, the marks and ball_height"
        )
    for i in range(len(place)):
        for j in range(i):
            if abs(place[i] - place[j]) < 0.6 * setup.ball_diameter:
                raise QuestionError(f"clicked: balls {j + 1} and {i + 1} are at one place")
    ahead = [camera.view.places(pixels + step, setup.ball_height) for step in 0.5 * np.eye(2)]
    along = 1j * (place - complex(*setup.race_center)) / np.abs(place - complex(*setup.race_center))
    slopes = [((one[:, 0] + 1j * one[:, 1] - place) / 0.5 * np.conj(along)).real for one in ahead]
    return BallsInPicture(place, setup.pixel_deviation * np.hypot(*slopes), np.ones(len(place)))


def _gray(argument: str | Path | ArrayLike) -> Gray:
    if isinstance(argument, str | Path):
        from PIL import Image, UnidentifiedImageError

        if reason := not_to_read(Path(argument)):
            raise ResultError(f"{argument}: {reason}")
        try:
            with Image.open(argument) as gray:
                return np.asarray(gray.convert("L"), np.uint8)
        except (OSError, UnidentifiedImageError, ValueError) as reason:
            raise ResultError(f"{argument}: cannot be read as a picture: {reason}") from None
    picture = np.asarray(argument)
    if picture.dtype != np.uint8 or picture.ndim not in (2, 3) or (picture.ndim == 3 and picture.shape[2] < 3):
        raise QuestionError(
            f"photograph: an array {picture.shape} of {picture.dtype}; must be (rows, columns) or (rows, columns, 3) of uint8"
        )
    return picture if picture.ndim == 2 else np.round(picture[..., :3] @ LIGHT).astype(np.uint8)


def rest_histogram(found: Sequence[xr.Dataset], *, bins: int = 12, reference: float = 0.0) -> Labeled:
    """Where balls came to rest in several films or photographs, as Spannan (2021), figure 6.20, counts it.

    Parameters
    ----------
    found
        Results of ``track_balls``, of which the last angle counts that was seen, or of ``photographed_angles``.
    bins
        Around the rotor; the first has its middle at ``reference``.
    reference
        Angle in the rotor, rad, from which angles count, such as that of the unbalance.

    Returns
    -------
    Labeled
        Dataset over ``bin``: ``angle`` (rad, middle of the bin), ``count`` of balls and ``count_deviation``, what angles near
        the edge of a bin may change, by their standard deviations.

    Raises
    ------
    QuestionError
        If there are no angles, or no bins.
    """
    if not 2 <= bins <= 360:
        raise QuestionError(f"bins: given {bins}; 2 to 360 are possible")
    angles, spreads = [], []
    for number, one in enumerate(found, 1):
        if "ball_angle" not in one or "ball_angle_deviation" not in one:
            raise QuestionError(
                f"rest_histogram: result {number} has no ball angles; give results of track_balls or photographed_angles"
            )
        angle, spread = (np.atleast_2d(one[name].values) for name in ("ball_angle", "ball_angle_deviation"))
        for column, sure in zip(angle.T, spread.T, strict=True):
            rows = np.flatnonzero(np.isfinite(column))
            if rows.size:
                angles.append(float(column[rows[-1]]))
                spreads.append(float(sure[rows[-1]]))
    if not angles:
        raise QuestionError("rest_histogram: no ball was seen in any of them")
    wide = 2.0 * np.pi / bins
    place = (np.array(angles) - reference) / wide + 0.5
    where = np.floor(place).astype(int) % bins
    within = place - np.floor(place)
    unsure = np.minimum(within, 1.0 - within) * wide < 2.0 * np.array(spreads)
    spread = np.sqrt(0.25 * np.bincount(where, weights=unsure, minlength=bins))
    data = xr.Dataset(
        {
            "count": ("bin", np.bincount(where, minlength=bins), {"long_name": "balls at rest", "units": ""}),
            "count_deviation": ("bin", spread, {"long_name": "standard deviation of the count", "units": ""}),
        },
        {"angle": ("bin", wide * np.arange(bins), {"long_name": "angle from the reference", "units": "rad"})},
        {
            "title": f"{len(angles)} balls at rest in {len(found)} films or photographs",
            "reference": reference,
            **provenance(),
        },
    )
    return Labeled.of(data)


# Films as files and as arrays: pictures in shades of gray, one after the other.


@dataclass(frozen=True)
class Film:
    """Pictures and when they were taken.

    Parameters
    ----------
    pictures
        Array (frames, rows, columns) of 8 bits, or the path of a film.
    time
        Of each picture, s.
    rotor_angle
        Of each picture, rad, where it is known (of films of simulated races); else empty.
    """

    pictures: Gray | Path
    time: Floats
    rotor_angle: Floats

    def __iter__(self) -> Iterator[Gray]:
        return iter(self.pictures) if isinstance(self.pictures, np.ndarray) else read_pictures(self.pictures)


def _encoder(path: Path) -> None:
    if find_spec("imageio_ffmpeg") is None:
        raise QuestionError(f'{path}: films need imageio-ffmpeg: install it by pip install "autobalancer[film]"')


def write_film(path: str | Path, pictures: Iterable[Gray], frame_rate: float) -> Path:
    """Write pictures as MP4, in a quality that keeps edges.

    Raises
    ------
    QuestionError
        If the name does not end with .mp4, or imageio-ffmpeg is not installed.
    ResultError
        If the file cannot be written.
    """
    path = as_path(path)
    if path.suffix.lower() != ".mp4":
        raise QuestionError(f"{path}: films are saved as .mp4; end the name with it")
    _encoder(path)
    return write_safely(path, lambda file: _write(file, pictures, frame_rate))


def _write(file: Path, pictures: Iterable[Gray], frame_rate: float) -> None:
    from imageio_ffmpeg import write_frames

    writer: Any = None
    try:
        for picture in pictures:
            if writer is None:
                size = (picture.shape[1], picture.shape[0])
                writer = write_frames(
                    str(file), size, fps=frame_rate, pix_fmt_in="gray", quality=None, macro_block_size=2,
                    output_params=["-crf", "12", "-preset", "veryfast"],
                )  # fmt: skip
                writer.send(None)
            writer.send(np.ascontiguousarray(picture))
    finally:
        if writer is not None:
            writer.close()


def film_facts(path: str | Path) -> tuple[float, int, tuple[int, int]]:
    """Pictures a second, about how many pictures, and their size (columns, rows) of a film.

    Raises
    ------
    QuestionError
        If imageio-ffmpeg is not installed.
    ResultError
        If there is no such film, or it cannot be read.
    """
    reader = _open(as_path(path))
    facts = next(reader)
    reader.close()
    return float(facts["fps"]), round(float(facts["fps"]) * float(facts["duration"])), tuple(facts["size"])


def _open(path: Path) -> Any:
    if reason := not_to_read(path):
        raise ResultError(f"{path}: {reason}")
    _encoder(path)
    from imageio_ffmpeg import read_frames

    return _ffmpeg_errors(path, read_frames(str(path), pix_fmt="gray", bpp=1))


def _ffmpeg_errors(path: Path, reader: Any) -> Iterator[Any]:
    """What ffmpeg says of a file that it cannot read becomes one sentence."""
    try:
        with closing(reader):
            yield from reader
    except (OSError, RuntimeError, StopIteration, ValueError, IndexError, KeyError) as reason:
        lines = [line.strip() for line in str(reason).splitlines() if line.strip()]
        raise ResultError(f"{path}: cannot be read as a film: {lines[-1] if lines else 'it has no pictures'}") from None


def read_pictures(path: str | Path) -> Iterator[Gray]:
    """The pictures of a film in shades of gray, (rows, columns) each; raises as :func:`film_facts`."""
    with closing(_open(as_path(path))) as reader:
        columns, rows = next(reader)["size"]
        for data in reader:
            yield np.frombuffer(data, np.uint8).reshape(rows, columns)

"""Films as files and as arrays: pictures in shades of gray, one after the other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError, ResultError
from autobalancer.safe_file import as_path, not_to_read, write_safely

Gray = NDArray[np.uint8]
Floats = NDArray[np.float64]


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

    return _told(path, read_frames(str(path), pix_fmt="gray", bpp=1))


def _told(path: Path, reader: Any) -> Iterator[Any]:
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

"""What a written picture or film holds: size, ink, frames, length."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from imageio_ffmpeg import read_frames
from PIL import Image, ImageSequence

CELLS = 4  # a picture is cut into as many columns and rows


def size_of(path: str | Path) -> tuple[int, int]:
    """Width and height in pixels of a PNG in which something is drawn from edge to edge.

    Something: 1 to 70 % of the pixels are not paper, in more than twenty colors (lines are smoothed), and none of the
    outer columns and rows of a grid of 4 by 4 cells is empty.
    """
    with Image.open(path) as picture:
        assert picture.format == "PNG"
        pixels = np.asarray(picture.convert("RGB"))
    _drawn(pixels)
    height, width, _ = pixels.shape
    return width, height


def film_of(path: str | Path) -> tuple[int, float, tuple[int, int]]:
    """Number of frames, length in seconds, and size in pixels of a film, MP4 or GIF; something is drawn, and it moves."""
    if Path(path).suffix == ".gif":
        with Image.open(path) as film:
            frames = [
                (frame.info["duration"], np.asarray(frame.convert("RGB"))) for frame in ImageSequence.Iterator(film)
            ]
        seconds, pictures = 1e-3 * sum(length for length, _ in frames), [picture for _, picture in frames]
    else:
        reader = read_frames(str(path))
        about = next(reader)
        width, height = about["size"]
        pictures = [np.frombuffer(frame, np.uint8).reshape(height, width, 3) for frame in reader]
        seconds = about["duration"]
    for picture in pictures:
        _drawn(picture)
    assert any((one != pictures[0]).any() for one in pictures[1:])
    height, width, _ = pictures[0].shape
    return len(pictures), seconds, (width, height)


def _drawn(pixels: np.ndarray) -> None:
    ink = np.abs(pixels.astype(int) - pixels[0, 0]).max(axis=2) > 8
    assert 0.01 < ink.mean() < 0.7
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 20
    columns = [part.any() for part in np.array_split(ink, CELLS, axis=1)]
    rows = [part.any() for part in np.array_split(ink, CELLS, axis=0)]
    assert all(columns)
    assert all(rows)

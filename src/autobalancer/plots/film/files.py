"""Frames to a film: MP4 through the ffmpeg that comes with imageio-ffmpeg, GIF through Pillow."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.safe_file import write_safely

Frame = NDArray[np.uint8]


def film_format(path: Path) -> str:
    """``"mp4"`` or ``"gif"``, from the extension.

    Raises
    ------
    QuestionError
        If the extension is neither, or MP4 is asked for and its encoder is not installed.
    """
    kind = path.suffix.lower().removeprefix(".")
    if kind not in ("mp4", "gif"):
        raise QuestionError(f"{path}: films are saved as .mp4 or .gif; end the name with one of these")
    if kind == "mp4" and find_spec("imageio_ffmpeg") is None:
        raise QuestionError(
            f'{path}: MP4 films need the encoder imageio-ffmpeg: install it by pip install "autobalancer[film]", '
            "or end the name with .gif, which needs nothing more"
        )
    return kind


def write_film(path: Path, frames: Iterator[Frame], fps: int) -> None:
    """Write a film; an existing file is replaced only when the new one is complete.

    Raises
    ------
    ResultError
        If the file cannot be written.
    """
    write = _mp4 if film_format(path) == "mp4" else _gif
    write_safely(path, lambda file: write(file, frames, fps))


def _mp4(path: Path, frames: Iterator[Frame], fps: int) -> None:
    from imageio_ffmpeg import write_frames

    first = next(frames)
    height, width = first.shape[:2]
    writer = write_frames(
        str(path), (width, height), fps=fps, quality=7, macro_block_size=2, output_params=["-movflags", "+faststart"]
    )
    writer.send(None)
    try:
        writer.send(first)
        for frame in frames:
            writer.send(frame)
    finally:
        writer.close()


def _gif(path: Path, frames: Iterator[Frame], fps: int) -> None:
    from PIL import Image

    pictures = list(frames)
    palette = Image.new("P", (1, 1))
    palette.putpalette(_commonest(pictures[:: max(1, len(pictures) // 8)]))
    small = [Image.fromarray(picture).quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    small[0].save(path, save_all=True, append_images=small[1:], duration=_hundredths(len(small), fps), loop=0)


def _commonest(pictures: list[Frame]) -> bytes:
    """The 256 commonest colors: one palette for all frames does not flicker, and it keeps white white."""
    packed = np.concatenate([picture.reshape(-1, 3) for picture in pictures]).astype(np.uint32) @ [65536, 256, 1]
    color, times = np.unique(packed, return_counts=True)
    ranked = color[np.argsort(-times, kind="stable")].astype(np.int64)
    _, first = np.unique(ranked & 0xF8F8F8, return_index=True)  # Pillow mixes up closer ones, white too
    kept = ranked[np.sort(first)][:256]
    return np.stack([kept >> 16, kept >> 8 & 255, kept & 255], axis=1).astype(np.uint8).tobytes()


def _hundredths(count: int, fps: int) -> list[int]:
    """Milliseconds a frame. GIF knows only hundredths of a second: rounded so that the whole film has its length."""
    ends: Iterable[int] = [round(100.0 * k / fps) for k in range(count + 1)]
    return [10 * int(step) for step in np.diff(np.array(list(ends)))]

"""Frames to a film: MP4 through the ffmpeg that comes with imageio-ffmpeg, GIF through Pillow."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Iterable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypedDict, Unpack, cast

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from autobalancer.arrays import Floats
from autobalancer.errors import QuestionError, one_of
from autobalancer.machine_kinds import arguments_of, machine_kind, refuse_unknown
from autobalancer.plots.style import INK, labels_of, look, picture
from autobalancer.progress import shows_progress
from autobalancer.results.display_units import AxisUnit, round_down, significant, speed_axis
from autobalancer.safe_file import as_path, write_safely
from autobalancer.units import argument, optional_argument

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


# A film on disk that shows itself in a notebook.


EMBEDDED = 30_000_000  # bytes of a film that a notebook takes into itself


class Film(type(Path())):  # type: ignore[misc]
    """The path of a film; a notebook shows the film in place of the path."""

    def _repr_html_(self) -> str | None:
        kind = self.suffix.lower().removeprefix(".")
        if kind not in ("mp4", "gif") or not self.is_file() or self.stat().st_size > EMBEDDED:
            return None
        data = b64encode(self.read_bytes()).decode("ascii")
        if kind == "gif":
            return f'<img src="data:image/gif;base64,{data}" style="max-width:100%">'
        return f'<video controls loop muted style="max-width:100%" src="data:video/mp4;base64,{data}"></video>'


# The canvas of a film: what never moves is drawn once, the rest on top of it.


WIDTH, SHAPE = 9.6, 17.0 / 30.0  # inches, and height by width; the width in pixels sets the resolution


class FilmCanvas:
    """A figure of ``width`` pixels for many frames; artists are placed, then :meth:`freeze` is called once."""

    def __init__(self, width: int) -> None:
        even = width - width % 2
        dpi, height = even / WIDTH, 2 * round(0.5 * SHAPE * even)  # video needs even numbers of pixels
        self.figure = picture(WIDTH, (height + 0.01) / dpi, dpi=dpi)
        self.figure.set_layout_engine("none")  # fixed places: the picture must not shift with its labels
        self.canvas = cast(Any, FigureCanvasAgg(self.figure))
        self.moving: list[Artist] = []
        self.cursors: list[Line2D] = []

    def write(self, run: xr.Dataset, middle: float, heights: tuple[float, float, float], caption: str) -> None:
        """The name of the machine, the line ``text`` that changes, and the caption, each around ``middle`` at its height."""
        name, line, below = heights
        center: dict[str, Any] = {"ha": "center", "va": "center"}
        self.figure.text(middle, name, str(run.attrs.get("machine_name", "")), weight="bold", **center)
        self.text = self.figure.text(middle, line, "", fontsize=11, family="monospace", **center)
        self.figure.text(middle, below, caption, ha="center", va="bottom", fontsize=8.5, color="#404040")

    def panels(self, left: float, first: float, last: float) -> tuple[Axes, Axes]:
        """Two axes over the time of the film, one above the other, right of ``left``, each with a cursor at ``first``."""
        wide = 0.975 - left
        upper = self.figure.add_axes((left, 0.55, wide, 0.35))
        lower = self.figure.add_axes((left, 0.09, wide, 0.345), sharex=upper)
        lower.set(xlabel="time (s)", xlim=(first, last))
        self.cursors = [panel.axvline(first, color=INK, lw=1.0, zorder=6, clip_on=False) for panel in (upper, lower)]
        return upper, lower

    def freeze(self, moving: Sequence[Artist]) -> None:
        """Draw everything but ``moving``, the cursors and the labels before which they pass, which each frame draws so."""
        labels = [labels_of(panel) for panel in self.figure.axes if any(line in self.cursors for line in panel.lines)]
        for each in labels:
            each.held = True
        self.moving = [*moving, *self.cursors, *labels]
        for artist in self.moving:
            artist.set_animated(True)
        self.canvas.draw()
        self.still = self.canvas.copy_from_bbox(self.figure.bbox)

    def pixels(self, time: float) -> NDArray[np.uint8]:
        """The frame with the cursors at ``time``: rows, columns, red-green-blue."""
        for cursor in self.cursors:
            cursor.set_xdata([time, time])
        self.canvas.restore_region(self.still)
        renderer = self.canvas.get_renderer()
        for artist in self.moving:
            artist.draw(renderer)
        return np.asarray(self.canvas.buffer_rgba())[:, :, :3].copy()


def frames_of(
    draw: Callable[[int], Frame], count: int, progress: Callable[[int, int], None] | None = None
) -> Iterator[Frame]:
    """Frames 0 to ``count`` - 1 of ``draw``; ``progress`` is called with (frames done, frames in all)."""
    for k in range(count):
        yield draw(k)
        if progress is not None:
            progress(k + 1, count)


# What every film asks: which part of a run, how long and how large, and how fast it then is.


class FilmOptions(TypedDict, total=False):
    """What :func:`animate` takes; the last two for deep chambers only."""

    start: float | str | None
    end: float | str | None
    duration: float | str
    fps: int
    frame: Literal["rotor", "space"] | None
    deflection_scale: float | Literal["auto"]
    speed_unit: str
    width: int
    azimuth: float
    elevation: float


class FilmQuestion(NamedTuple):
    """What was asked of a film, in SI."""

    path: Path
    start: float | None  # s
    end: float | None  # s
    duration: float  # s, of the film
    frames: int
    fps: int
    frame: str | None  # rotor or space
    scale: float | Literal["auto"]
    unit: AxisUnit  # of speeds
    width: int


@shows_progress
def animate(
    run: xr.Dataset,
    path: str | Path,
    *,
    progress: Callable[[int, int], None] | None = None,
    **options: Unpack[FilmOptions],
) -> Film:
    """Make a film of a run, ``.mp4`` or ``.gif``: the machine beside its speeds and its deflection over time.

    Of balls in races one sees rotor, races, balls and unbalance. Balancers in different planes have a disc each, with the
    unbalance of their plane; below them the axis is seen from the side, with these planes in perspective, so that its tilt
    or bending is visible. Of deep chambers one sees the balls in three dimensions, colored by their speed.

    A rotor at 3000 rpm turns twice between two frames of a film in real time, so its picture would seem to stand still or
    to rotate slowly. In the frame of the rotor it stands still as under a stroboscope, and one sees what
    matters: how the balls move relative to it, and to which side it is deflected. In space the rotor rotates;
    choose a short interval, so that the film is slow motion. The caption says how fast the film is, how much larger
    the deflection is drawn, and, in space, how often the rotor turns between two frames. The pale arc behind a ball in a race
    is its path since the previous frame; a full ring means that it circled at least once.

    Frames lie on the samples of a run of races where the samples are denser than the frames; between samples its motion is a
    cubic in the frame of the rotor. For slow motion of a machine that is not isotropic save some ten samples to a
    revolution (``SampleTimes``).

    Parameters
    ----------
    run
        From :func:`simulate`, :func:`load_run` or an archive, with samples.
    path
        The film. MP4 needs no program on the system. An existing film is replaced when the new one is complete.
    progress
        Called with (frames done, frames in all). ``None`` shows a bar where a person is looking, ``False`` none.
    **options
        ``start`` and ``end``, the interval of the run (s), by default all samples; ``duration`` of the film (s), by default
        10; ``fps``, frames in a second of film, 1 to 100, by default 25; ``frame``, ``"rotor"`` (it stands still, the default
        of races) or ``"space"`` (it turns, the default of chambers); ``deflection_scale``, how much larger the deflection is
        drawn, by default so that the greatest is 15 % of the orbit radius, of a chamber 10 % of its radius; ``speed_unit``,
        ``"rpm"``, ``"rad/s"`` or ``"Hz"``; ``width`` in pixels, 320 to 3840, by default 960. Of deep chambers also the
        direction of view in degrees: ``azimuth`` in the horizontal plane from the rotor's axis, by default 35, and
        ``elevation`` above it, by default 20. 0 and 0 look along the axis, 90 and 0 from the side, 0 and 90 from above.

    Returns
    -------
    Film
        The path of the file that was written; a notebook shows the film.

    Raises
    ------
    QuestionError
        If the run has no samples there, an option belongs to the other kind of run, or the extension, a unit or a number is
        not possible.
    ResultError
        If the file cannot be written.
    """
    kind = machine_kind(run)
    scene = kind["scene"]
    given: dict[str, Any] = dict(options)
    common, own = arguments_of(film_question)[1:], arguments_of(scene)[2:]
    refuse_unknown("animate", given, [*common, *own], kind.words)
    asked = film_question(path, **{name: given.pop(name) for name in common if name in given})
    with look():
        write_film(asked.path, frames_of(scene(run, asked, **given).frame, asked.frames, progress), asked.fps)
    return Film(asked.path)


def film_question(
    path: str | Path,
    *,
    start: float | str | None = None,
    end: float | str | None = None,
    duration: float | str = 10.0,
    fps: int = 25,
    frame: str | None = None,
    deflection_scale: float | Literal["auto"] = "auto",
    speed_unit: str = "rpm",
    width: int = 960,
) -> FilmQuestion:
    """The arguments that all films have, read and checked.

    Raises
    ------
    QuestionError
        If one of them is not possible.
    """
    first, last = optional_argument("start", start, "s"), optional_argument("end", end, "s")
    seconds = argument("duration", duration, "s")
    film_format(as_path(path))
    count, unit = frame_count(frame, fps, seconds, width), speed_axis(speed_unit)
    return FilmQuestion(as_path(path), first, last, seconds, count, fps, frame, deflection_scale, unit, width)


def frame_count(frame: str | None, fps: int, duration: float, width: int) -> int:
    """Number of frames of a film.

    Raises
    ------
    QuestionError
        If the frame of reference is neither rotor nor space, or a number makes no film.
    """
    if frame is not None:
        one_of("frame", frame, "rotor", "space")
    if not 1 <= fps <= 100:
        raise QuestionError(f"fps: given {fps}; must be between 1 and 100 frames a second")
    count = round(duration * fps) if np.isfinite(duration) else 0
    if not 2 <= count <= 100000:
        raise QuestionError(f"duration: given {duration:g} s at {fps} frames a second; a film has 2 to 100000 frames")
    if not 320 <= width <= 3840:
        raise QuestionError(f"width: given {width} pixels; must be between 320 and 3840")
    return count


def frame_times(samples: Floats, start: float | None, end: float | None, count: int) -> Floats:
    """Equal steps from ``start`` to ``end``, by default over all samples.

    Raises
    ------
    QuestionError
        If the interval is not within the samples.
    """
    if samples.size < 2:
        raise QuestionError(f"the run has {samples.size} samples; a film needs two")
    first = float(samples[0]) if start is None else float(start)
    last = float(samples[-1]) if end is None else float(end)
    if not samples[0] - 1e-9 <= first < last <= samples[-1] + 1e-9:
        raise QuestionError(
            f"from {first:g} s to {last:g} s: the samples go from {samples[0]:g} s to {samples[-1]:g} s; "
            "choose an interval within"
        )
    return np.linspace(first, last, count)


def magnification(requested: float | Literal["auto"], greatest: float, size: float, share: float) -> float:
    """How much larger a deflection is drawn; by default so that ``greatest`` is at most ``share`` of ``size``.

    Raises
    ------
    QuestionError
        If a number is asked for that is not greater than zero.
    """
    if requested != "auto":
        if not (np.isfinite(requested) and requested > 0.0):
            raise QuestionError(f"deflection_scale: given {requested!r}; must be 'auto' or a number greater than zero")
        return float(requested)
    return round_down(share * size / greatest) if greatest > 1e-12 * size else 1.0


def size_words(thing: str, scale: float) -> str:
    """How large a ``thing`` is drawn, in words: ``"deflection drawn 20 times larger"``, ``"... at half size"``."""
    if scale == 1.0:
        return f"{thing} to scale"
    if scale > 1.0:
        return f"{thing} drawn {scale:g} times larger"
    return f"{thing} drawn at " + ("half size" if scale == 0.5 else f"1/{significant(1.0 / scale)} of its size")


def pace(duration: float, times: Floats) -> str:
    """How fast a film of ``duration`` (s) over ``times`` (s) is, in words."""
    ratio = duration / max(float(np.ptp(times)), 1e-12)
    if 0.95 < ratio < 1.05:
        return "real time"
    if ratio > 1.0:
        return f"slow motion, {significant(ratio)} times slower"
    return f"{significant(1.0 / ratio)} times faster than real"

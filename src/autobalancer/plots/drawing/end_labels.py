"""Names of curves at their right ends, outside the axes: one for coincident curves, none on another."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.transforms import offset_copy
from numpy.typing import NDArray

from autobalancer.plots.drawing.style import INK

Floats = NDArray[np.float64]
SAME = 2e-3  # of the axis; ends nearer to each other are one line in the picture
NEED, SIZE = 0.045, 8.0  # of the axis, what a label needs; and its size in points
WIDEST = 48  # letters of a line; longer names have several lines, so that the axes keep their room
BESIDE, APART = 5.0, 26.0  # points from the end to its label, and where labels had to be moved


class End(NamedTuple):
    """The right end of a curve: its height in data, its name, and a number about it, written after the name."""

    height: float
    name: str
    note: str


def end_labels(axes: Axes, x: float, ends: Sequence[End], top: float) -> None:
    """Write names to the right of the ends at ``x`` on an axis from 0 to ``top``; thin lines lead to those that were moved."""
    groups = together(sorted(ends), SAME * top)
    heights = np.array([np.mean([end.height for end in group]) for group in groups])
    texts = [in_lines(joint_name(group)) for group in groups]
    lines = np.array([text.count("\n") + 1 for text in texts])
    places = moved_apart(np.repeat(heights, lines), NEED * top)
    levels = np.array([part.mean() for part in np.split(places, np.cumsum(lines)[:-1])])
    moved = bool((np.abs(levels - heights) > 0.2 * NEED * top).any())
    for text, height, level in zip(texts, heights, levels, strict=True):
        axes.annotate(
            text,
            (x, float(height)),
            xytext=(1.0, float(level) / top),
            textcoords=offset_copy(axes.transAxes, axes.get_figure(root=True), x=APART if moved else BESIDE, units="points"),
            va="center",
            fontsize=SIZE,
            color=INK,
            annotation_clip=False,
            arrowprops={"arrowstyle": "-", "color": INK, "lw": 0.6, "shrinkA": 1.0, "shrinkB": 2.0, "relpos": (0.0, 0.5)}
            if moved
            else None,
        )  # fmt: skip


def together(ends: Sequence[End], near: float) -> list[list[End]]:
    """Ascending ends in groups of those that are ``near`` to the one before."""
    groups: list[list[End]] = []
    for end in ends:
        if groups and end.height - groups[-1][-1].height <= near:
            groups[-1].append(end)
        else:
            groups.append([end])
    return groups


def joint_name(group: Sequence[End]) -> str:
    """One name for coincident curves: what their names begin with once, and a common note once; forward comes first."""
    group = sorted(group, key=lambda end: "backward" in end.name)
    names = [end.name.split() for end in group]
    common = 0
    while len(group) > 1 and all(len(words) > common + 1 and words[common] == names[0][common] for words in names):
        common += 1
    notes = list(dict.fromkeys(end.note for end in group))
    each = [" ".join(words[common:]) for words in names]
    if len(notes) > 1:
        each = [f"{name} {end.note}" for name, end in zip(each, group, strict=True)]
    text = " ".join([*names[0][:common], ", ".join(each)])
    return text if len(notes) > 1 else f"{text}, {notes[0]}"


def in_lines(text: str) -> str:
    """A long text in lines that end at its commas."""
    first, *rest = text.split(", ")
    lines = [first]
    for part in rest:
        if len(lines[-1]) + len(part) + 2 > WIDEST:
            lines[-1] += ","
            lines.append(part)
        else:
            lines[-1] += f", {part}"
    return "\n".join(lines)


def moved_apart(wanted: Floats, gap: float) -> Floats:
    """Ascending places at least ``gap`` apart, together as near as possible to those wanted."""
    stacks: list[tuple[float, int]] = []  # mean of wanted places less their order, and how many
    for number, place in enumerate(wanted):
        stacks.append((float(place) - number * gap, 1))
        while len(stacks) > 1 and stacks[-2][0] >= stacks[-1][0]:
            (low, few), (high, many) = stacks[-2:]
            stacks[-2:] = [((low * few + high * many) / (few + many), few + many)]
    bases = np.repeat([base for base, _ in stacks], [count for _, count in stacks])
    return np.asarray(bases + gap * np.arange(len(wanted)), np.float64)

"""Where balls come to rest, as dots around the race, a panel for each point of the grid of a study."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from autobalancer.errors import QuestionError
from autobalancer.plots.drawing.style import UNBALANCE, ball_color, ball_label, heading, look, picture
from autobalancer.random_numbers import generator
from autobalancer.results.answers.studied import Studied
from autobalancer.results.given import Given, result

MOST_PANELS, COLUMNS = 12, 4
RING, SPREAD = 1.0, 0.12  # radius of the dots, and how far they are moved aside so that all are seen


def rest_positions(found: Given, *, speed_unit: str = "rpm") -> Figure:
    """Ball angles at the end of the members of a study, counted from the unbalance, which is at the right.

    Dots are moved inwards and outwards at random, so that those at one angle are seen side by side; radius means nothing else.

    Parameters
    ----------
    found
        From :func:`autobalancer.study`, with runs.
    speed_unit
        rpm, rad/s or Hz, for titles of panels.

    Raises
    ------
    QuestionError
        If ``found`` is no study with balls, or its grid has more than 12 points.
    """
    given = result(
        found, "plot.rest_positions", "study", lambda it: "draw" in it.coords and "ball_angle_to_unbalance" in it
    )
    given = given if isinstance(given, Studied) else Studied.of(given)
    points, texts = given.at_points(), given.point_texts(speed_unit)
    if len(points) > MOST_PANELS:
        raise QuestionError(
            f"plot.rest_positions: the grid has {len(points)} points, at most {MOST_PANELS} are drawn; vary less, "
            "or select some in Python with .where"
        )
    rows = -(-len(points) // COLUMNS)
    columns = -(-len(points) // rows)
    with look():
        figure = picture(max(1.9 * columns, 4.2), 2.15 * rows + 0.9)
        heading(figure, f"{given.heading()}\nballs at the end, from the unbalance (line)")
        for number, (where, text) in enumerate(zip(points, texts, strict=True)):
            axes: Any = figure.add_subplot(rows, columns, number + 1, projection="polar")
            _panel(axes, given["ball_angle_to_unbalance"].values[where & given.counted()])
            axes.set_title(text, fontsize=8.5, loc="center", weight="normal")
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=8.5)
    return figure


def _panel(axes: Any, angles: Any) -> None:
    aside = SPREAD * (2.0 * generator(0).random(angles.shape) - 1.0)
    size = float(np.clip(900.0 / max(angles.shape[0], 1), 2.0, 14.0))
    for ball in range(angles.shape[1]):
        axes.scatter(
            angles[:, ball],
            RING + aside[:, ball],
            s=size,
            color=ball_color(ball),
            alpha=0.6,
            linewidths=0.0,
            label=ball_label(ball, angles.shape[1]),
        )
    axes.plot([0.0, 0.0], [0.0, RING - 2.0 * SPREAD], color=UNBALANCE, linewidth=2.0)
    axes.set_ylim(0.0, RING + 1.5 * SPREAD)
    axes.set_yticks([])
    axes.set_xticks(np.linspace(0.0, 2.0 * np.pi, 8, endpoint=False))
    axes.tick_params(axis="x", labelsize=7.0, pad=-1.0)

"""Drag laws on the command line and in a picture."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from tests.references.pictures import size_of
from typer.main import get_command

import autobalancer as ab
from autobalancer.cli.main import app as whole
from autobalancer.errors import QuestionError
from autobalancer.laws import drag_coefficient as laws

app = get_command(whole).commands["catalog"]  # type: ignore[attr-defined]
RUNNER = CliRunner(env={"COLUMNS": "180"})


def test_the_catalog_prints_what_the_laws_return(tmp_path: Path) -> None:
    picture = tmp_path / "drag.png"
    arguments = ["drag-laws", "--reynolds", "24000", "--reynolds", "3", "--json", "--plot", str(picture)]
    rows = json.loads(RUNNER.invoke(app, arguments, catch_exceptions=False).output)
    assert [row["coefficient"] for row in rows] == [
        law.coefficient([24000.0, 3.0]).tolist() for law in ab.laws.drag_laws()
    ]
    assert size_of(picture) == (1080, 960)
    text = RUNNER.invoke(app, ["drag-laws"], catch_exceptions=False).output
    assert "sphere_on_plane" in text
    assert "38.7" in text


def test_the_catalog_takes_the_geometry_of_a_race() -> None:
    size = ["--ball-diameter", "12.3 mm", "--orbit-radius", "76.95 mm"]
    rows = json.loads(RUNNER.invoke(app, ["drag-laws", "--json", "--clear-width", "9.225 mm", *size]).output)
    assert rows[-1]["name"] == "race_geometry"
    assert rows[-1]["cd_times_re"] == pytest.approx(386.949, abs=0.01)
    with pytest.raises(QuestionError, match="together"):
        RUNNER.invoke(app, ["drag-laws", *size], catch_exceptions=False)
    with pytest.raises(QuestionError, match="greater than zero"):
        RUNNER.invoke(app, ["drag-laws", "--reynolds", "0"], catch_exceptions=False)


def test_the_picture_shows_each_law_twice_and_dots_what_lies_beyond_its_range() -> None:
    points = laws.table([1.0, 100.0], [300.0, 9.0])
    figure = ab.plot.drag_laws([ab.laws.discoidal(), points], labels=["rig", "points"])
    upper, lower = figure.axes
    drawn = upper.lines[0].get_xydata()
    np.testing.assert_allclose(drawn[:, 1], ab.laws.discoidal().coefficient(drawn[:, 0]), rtol=1e-12)
    assert drawn[-1, 0] == pytest.approx(2e5)
    np.testing.assert_allclose(lower.lines[0].get_xydata()[:10, 1], 387.0)
    beyond = lower.lines[3].get_xydata()
    np.testing.assert_allclose(beyond[:, 1] / beyond[:, 0], 9.0)
    np.testing.assert_allclose(upper.lines[4].get_xydata(), [[1.0, 300.0], [100.0, 9.0]])
    with pytest.raises(QuestionError, match="a label for each"):
        ab.plot.drag_laws([points], labels=[])
    with pytest.raises(QuestionError, match="must increase"):
        ab.plot.drag_laws(first=0.0)

"""Pictures and tables of measured signals say units, time, window, and what their marks are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.measure import Channel

RATE = 400.0


def turning(speed: np.ndarray) -> xr.Dataset:
    """A forward circle of 2 mm whose x is seen as displacement, and y as displacement and velocity; speed in rad/s."""
    time = np.arange(speed.size) / RATE
    angle = np.cumsum(speed) / RATE
    x, y = 2e-3 * np.cos(angle - 0.5), 2e-3 * np.sin(angle - 0.5)
    channels = {
        "x": Channel(x, "displacement", direction="x"),
        "y": Channel(y, "displacement", direction="y"),
        "v_y": Channel(2e-3 * speed * np.cos(angle - 0.5), "velocity", direction="y"),
        "angle": Channel(angle, "angle"),
    }
    return ab.measure.rotor_angle(ab.measure.signals(time, channels))


@pytest.fixture(scope="module")
def up() -> xr.Dataset:
    return turning(np.linspace(20.0, 90.0, 4000))


def test_each_unit_has_its_panel_and_each_column_its_unit(up: xr.Dataset, tmp_path: Path) -> None:
    found = ab.measure.orders(up, (1,))
    of_lengths, of_speeds, _ = ab.plot.orders(found).axes
    assert (of_lengths.get_ylabel(), of_speeds.get_ylabel()) == ("amplitude (mm)", "amplitude (mm/s)")
    assert [len(axes.get_legend().get_texts()) for axes in (of_lengths, of_speeds)] == [2, 1]
    (line,) = of_speeds.lines
    np.testing.assert_allclose(line.get_ydata(), 2.0 * found["speed"], rtol=5e-3)  # 2 mm times the speed
    ab.save_run(found, tmp_path / "orders.csv")
    head = (tmp_path / "orders.csv").read_text().splitlines()[0].split(",")
    assert {"amplitude[x] [m]", "amplitude[v_y] [m/s]", "bias[v_y] [m/s]", "phase[v_y] [rad]"} <= set(head)
    spectrum = ab.measure.spectrum(up.isel(time=slice(0, 800)))
    assert [axes.get_ylabel() for axes in ab.plot.spectrum(spectrum).axes] == ["amplitude (mm)", "amplitude (mm/s)"]
    ab.save_run(spectrum, tmp_path / "spectrum.csv")
    assert "density[v_y] [(m/s)^2/Hz]" in (tmp_path / "spectrum.csv").read_text().splitlines()[0]


def test_a_run_down_says_which_way_time_runs_and_a_map_wants_one_way(up: xr.Dataset) -> None:
    assert ab.plot.orders(ab.measure.orders(up)).axes[-1].get_xlabel() == "rotor speed (rpm)"
    down = turning(np.linspace(90.0, 20.0, 4000))
    assert "time runs to the left" in ab.plot.orders(ab.measure.orders(down)).axes[-1].get_xlabel()
    drawn = ab.plot.order_map(ab.measure.order_map(down, revolutions=8.0))
    assert "time runs to the left" in drawn.axes[0].get_xlabel()
    assert "hann window of 8 revolutions" in drawn.get_suptitle()
    assert drawn.axes[1].get_ylabel() == "amplitude of x (mm)"
    both = turning(90.0 - 60.0 * np.abs(np.linspace(-1.0, 1.0, 4000)))
    found = ab.measure.orders(both)
    above = ab.plot.orders(found).axes[0]
    assert [text.get_text() for text in above.get_legend().get_texts()].count("first point") == 1
    with pytest.raises(QuestionError, match="rises and falls; take one of both"):
        ab.plot.order_map(ab.measure.order_map(both))


def test_the_rings_of_an_orbit_are_where_the_rotor_angle_is_zero(up: xr.Dataset) -> None:
    axes = ab.plot.answer(ab.measure.orbit(up, "x", "y", orders=(1.0,))).axes[0]
    words = [text.get_text() for text in axes.figure.legends[0].get_texts()]
    assert words == ["measured, 4 revolutions", "order 1", "where the rotor angle is zero"]
    (ring,) = [line for line in axes.lines if line.get_marker() == "o" and len(line.get_xdata())]
    np.testing.assert_allclose(np.ravel(ring.get_xydata()), [2.0 * np.cos(-0.5), 2.0 * np.sin(-0.5)], rtol=1e-3)
    (arrow,) = axes.texts  # forward, so against the clock
    (x, y), (ahead_x, ahead_y) = arrow.xyann, arrow.xy
    assert x * ahead_y - y * ahead_x > 0.0


def test_a_long_name_does_not_leave_the_picture(up: xr.Dataset, tmp_path: Path) -> None:
    found = ab.measure.orders(up, channels=["x"])
    found.attrs["title"] = "orders of " + "a_run_up_of_the_grinder_in_hall_B " * 5
    figure = ab.plot.orders(found)
    figure.savefig(tmp_path / "orders.png")
    assert figure._suptitle.get_window_extent().x1 <= figure.bbox.x1
    assert " ".join(figure.get_suptitle().split()).startswith(found.attrs["title"].strip())

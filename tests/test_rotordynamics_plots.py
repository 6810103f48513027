"""Pictures of modes, Campbell diagrams, responses and whirl: what is drawn is what the result says."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.text import Text
from tests.test_rotordynamics_modes import RIG, planar, rigid

import autobalancer as ab
from autobalancer.errors import QuestionError
from autobalancer.files.examples import rig
from autobalancer.plots.rotor import THINNEST, WHIRL
from autobalancer.plots.style import End, joint_name, labels_of, moved_apart
from autobalancer.rotordynamics.campbell import campbell, modes
from autobalancer.rotordynamics.response import whirl_orbits

RPM = math.pi / 30.0


@pytest.fixture(scope="module")
def response() -> xr.Dataset:
    return ab.rotor.response(RIG, np.linspace(600.0, 5500.0, 801) * RPM, ["B1", "B2"])


def lines(axes: Any) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {str(line.get_label()): (line.get_xdata(), line.get_ydata()) for line in axes.get_lines()}


def test_the_campbell_diagram_colors_forward_and_backward_whirl_and_marks_the_critical_speeds() -> None:
    found = campbell(rigid(), np.linspace(0.0, 900.0, 61))
    axes = ab.plot.campbell(found, speed_unit="rad/s", frequency_unit="rad/s").axes[0]
    branches = [c for c in axes.collections if isinstance(c, LineCollection)]
    assert len(branches) == 4
    for number, branch in enumerate(branches):
        word = str(found["name"].values[number]).split()[1]
        assert {to_hex(color).upper() for color in branch.get_colors()} == {WHIRL[word].upper()}
        drawn = np.array([segment[0] for segment in branch.get_segments()])
        assert drawn[:, 1] == pytest.approx(found["frequency"].values[number, :-1])
    marks = [line for line in axes.get_lines() if line.get_marker() == "o"]
    crossed = found["intersection_speed"].values
    assert crossed.size >= 3
    assert sorted(line.get_xdata()[0] for line in marks) == pytest.approx(crossed)
    assert sorted(line.get_ydata()[0] for line in marks) == pytest.approx(crossed)
    x, y = lines(axes)["harmonic 1"]
    assert x == pytest.approx(y)


def test_the_campbell_diagram_draws_damped_branches_thicker() -> None:
    thin, thick = (
        ab.plot.campbell(campbell(planar(damping=damping), [0.0, 100.0])).axes[0].collections[0].get_linewidths()[0]
        for damping in (0.0, 60.0)
    )
    assert thin == pytest.approx(THINNEST)
    assert thick > 2.0 * thin


def test_units_of_the_campbell_diagram_are_chosen() -> None:
    found = campbell(RIG, np.linspace(0.0, 300.0, 31))
    axes = ab.plot.campbell(found).axes[0]
    assert "(rpm)" in axes.get_xlabel()
    assert "(Hz)" in axes.get_ylabel()
    level = np.array(axes.collections[0].get_segments()[0])
    assert level[0, 1] == pytest.approx(found["frequency"].values[0, 0] / (2.0 * math.pi))


def test_titles_of_modes_stay_within_their_panels() -> None:
    figure = ab.plot.modes(modes(RIG, 150.0), modes=4)
    figure.draw_without_rendering()
    boxes = [axes._left_title.get_window_extent() for axes in figure.axes]
    for i, box in enumerate(boxes):
        assert box.width > 0.0
        assert box.x1 < figure.bbox.x1
        assert not any(box.overlaps(other) for other in boxes[:i])
    for axes in figure.axes:
        words = axes.get_title("left").split("\n")[0].replace(",", "").split()
        assert len(words) == len(set(words))  # the whirl is not said twice


def test_mode_shapes_are_drawn_at_their_greatest_deflection() -> None:
    found = modes(RIG, 200.0)
    figure = ab.plot.modes(found, modes=4)
    assert len(figure.axes) == 4
    first = lines(figure.axes[0])["along y"]
    assert first[0] == pytest.approx(found["place"].values * 1e3)
    assert np.abs(first[1]).max() == pytest.approx(1.0, rel=1e-3)
    assert figure.axes[0].get_title("left").startswith("cylindrical y, ")
    assert f"{found['frequency'].values[0] / (2.0 * math.pi):.4g} Hz" in figure.axes[0].get_title("left")
    assert len(ab.plot.modes(modes(planar(), 0.0)).axes) == 2


def test_the_bode_diagram_has_amplitude_and_phase_of_every_station(response: xr.Dataset) -> None:
    above, below = ab.plot.response(response, deflection_unit="mm").axes
    drawn = lines(above)
    size = np.hypot(response["x_real"], response["x_imag"]).values[:, 0] * 1e3
    assert drawn["B1, x"][0] == pytest.approx(response["speed"].values / RPM)
    assert drawn["B1, x"][1] == pytest.approx(size)
    assert drawn["mean of the greatest"][1] == pytest.approx(response["mean_of_greatest"].values * 1e3)
    at, phase = lines(below)["B2, y"]
    assert np.nanmax(np.abs(phase)) <= 180.0 + 1e-9
    known = [int(np.nanargmin(np.abs(at - speed) + 0.0 * phase)) for speed in response["speed"].values / RPM]
    assert at[known] == pytest.approx(response["speed"].values / RPM)
    same = np.exp(1j * np.radians(phase[known])) / np.exp(1j * response["y_phase"].values[:, 1])
    assert same == pytest.approx(np.ones(801))
    assert np.nanmax(np.abs(np.diff(phase))) < 90.0  # broken where it passes 180 degrees
    assert above.get_yscale() == "log"
    assert "(mm)" in above.get_ylabel()


def test_backward_whirl_is_underlaid_where_it_is(response: xr.Dataset) -> None:
    above = ab.plot.response(response).axes[0]
    shaded = [(p.get_x(), p.get_x() + p.get_width()) for p in above.patches]
    assert shaded
    speed = response["speed"].values / RPM
    inside = np.zeros(speed.size, bool)
    for low, high in shaded:
        inside |= (speed >= low - 1e-6) & (speed <= high + 1e-6)
    assert (inside == (response["whirl"].values == "backward").any(axis=1)).all()


def test_the_polar_diagram_of_an_oscillator_is_passed_clockwise_from_the_unbalance_to_its_opposite() -> None:
    found = ab.rotor.response(planar(), np.linspace(5.0, 600.0, 2000), unbalance=1e-4)
    drawn = [
        line for line in ab.plot.answer(found, "polar_response").axes[0].get_lines() if len(line.get_xdata()) > 2000
    ]
    assert len(drawn) == 1
    curve = np.asarray(drawn[0].get_xdata()) + 1j * np.asarray(drawn[0].get_ydata())
    assert curve[0].real > 0.0 > curve[-1].real
    assert (np.diff(np.unwrap(np.angle(curve))) < 0.0).all()


def test_orbits_have_their_direction_in_title_and_color() -> None:
    found = whirl_orbits(RIG, 1675.0 * RPM)
    figure = ab.plot.answer(found, deflection_unit="um")
    for number, axes in enumerate(figure.axes):
        word = str(found["whirl"].values[number])
        assert axes.get_title("left") == f"{found['station'].values[number]}: {word}"
        x, y = lines(axes)["orbit"]
        assert x == pytest.approx(found["x"].values[number] * 1e6)
        assert y == pytest.approx(found["y"].values[number] * 1e6)
        tail, head = axes.texts[0].xyann, axes.texts[0].xy
        assert (tail[0] * head[1] - tail[1] * head[0] > 0.0) == (word == "forward")
    assert "1675 rpm" in figure.get_suptitle()


def test_the_orbits_along_the_axis_are_drawn_in_space() -> None:
    found = whirl_orbits(RIG, 1675.0 * RPM)
    axes = ab.plot.answer(found, "whirl_along_axis", deflection_unit="mm").axes[0]
    at_zero = next(line for line in axes.get_lines() if line.get_label() == "rotor angle 0")
    place, x, y = at_zero.get_data_3d()
    assert place == pytest.approx(found["place"].values * 1e3)
    assert x == pytest.approx(found["axis_x"].values[:, 0] * 1e3)
    assert y == pytest.approx(found["axis_y"].values[:, 0] * 1e3)
    with pytest.raises(QuestionError, match="one plane only"):
        ab.plot.answer(whirl_orbits(planar(), 50.0, unbalance=1e-4), "whirl_along_axis")


@pytest.mark.parametrize("name", ["campbell", "modes", "response"])
def test_another_result_is_refused_by_name(name: str) -> None:
    with pytest.raises(QuestionError, match=rf"plot\.{name}: given another result; this is not a result of rotor\."):
        getattr(ab.plot, name)(xr.Dataset())


def test_unknown_units_and_parts_are_refused(response: xr.Dataset) -> None:
    with pytest.raises(QuestionError, match="must be 'rpm'"):
        ab.plot.response(response, speed_unit="knots")
    with pytest.raises(QuestionError, match="must be 'forward', 'x' or 'y'"):
        ab.plot.answer(response, "polar_response", part="z")
    with pytest.raises(QuestionError, match="one speed only"):
        ab.plot.response(response.isel(speed=[0]))


def test_the_polar_line_between_a_few_speeds_is_that_of_many() -> None:
    few, many = (ab.rotor.response(planar(), np.linspace(20.0, 90.0, n), unbalance=1e-4) for n in (51, 401))
    (drawn,) = [
        line for line in ab.plot.answer(few, "polar_response").axes[0].get_lines() if len(line.get_xdata()) == 401
    ]
    exact = ab.plot.answer(many, "polar_response").axes[0].get_lines()
    (close,) = [line for line in exact if len(line.get_xdata()) > 401]
    one, other = (np.asarray(line.get_xdata()) + 1j * np.asarray(line.get_ydata()) for line in (drawn, close))
    assert np.abs(one - other[::8]).max() < 0.02 * np.abs(other).max()
    at, corners = np.arange(401), np.arange(0, 401, 8)
    straight = np.interp(at, corners, one[::8].real) + 1j * np.interp(at, corners, one[::8].imag)
    assert np.abs(straight - other[::8]).max() > 5.0 * np.abs(one - other[::8]).max()


def test_numbers_of_close_critical_speeds_do_not_cover_each_other() -> None:
    found = campbell(RIG, np.linspace(0.0, 5000.0, 61) * RPM)
    figure = ab.plot.campbell(found)
    figure.draw_without_rendering()
    placed = labels_of(figure.axes[0]).placed
    assert len(placed) == found["intersection_speed"].size == 4
    for i, one in enumerate(placed):
        assert not any(one.overlaps(other) for other in placed[:i])


def test_only_whirls_that_are_drawn_stand_in_the_legend_of_a_campbell_diagram() -> None:
    found = campbell(RIG, np.linspace(0.0, 5000.0, 61) * RPM)
    assert (found["whirl"].values[:, 0] == "straight").all()  # at standstill only
    words = [text.get_text() for text in ab.plot.campbell(found).axes[0].get_legend().get_texts()]
    assert "straight" not in words
    assert "mixed" in words


def end_names(axes: Any) -> list[Any]:
    axes.get_figure().draw_without_rendering()
    return [text for text in axes.texts if "%" in text.get_text()]


def test_branches_on_one_another_have_one_name_and_both_colors() -> None:
    axes = ab.plot.campbell(campbell(planar(damping=60.0), np.linspace(0.0, 100.0, 21))).axes[0]
    (name,) = end_names(axes)
    assert name.get_text().startswith("cylindrical forward, backward, ")
    dashes = [line for line in axes.get_lines() if to_hex(line.get_color()).upper() in WHIRL.values()]
    drawn = {to_hex(color).upper() for branch in axes.collections for color in branch.get_colors()}
    assert drawn == {WHIRL["forward"], WHIRL["backward"]}
    assert len(dashes) == 1
    assert dashes[0].get_ydata() == pytest.approx(axes.collections[0].get_segments()[0][0, 1])
    assert len(labels_of(axes).placed) == 1  # they meet the line of the speed at the same place


@pytest.mark.parametrize("highest", [900.0, 5000.0, 20000.0])
def test_names_of_close_branches_do_not_cover_each_other(highest: float) -> None:
    found = campbell(rigid(), np.linspace(0.0, highest, 61))
    names = end_names(ab.plot.campbell(found).axes[0])
    boxes = [Text.get_window_extent(name) for name in names]  # without the line to the branch
    heights = [name.xy[1] for name in names]
    assert heights == sorted(heights)
    assert [box.y0 for box in boxes] == sorted(box.y0 for box in boxes)
    for i, one in enumerate(boxes):
        assert not any(one.overlaps(other) for other in boxes[:i])


def test_labels_are_moved_apart_no_farther_than_needed() -> None:
    assert moved_apart(np.array([0.0, 0.0, 5.0]), 1.0) == pytest.approx([-0.5, 0.5, 5.0])
    assert moved_apart(np.array([0.0, 3.0]), 1.0) == pytest.approx([0.0, 3.0])
    ends = [End(2.0, "bending 1 backward", "1 %"), End(2.0, "bending 1 forward", "3 %")]
    assert joint_name(ends) == "bending 1 forward 3 %, backward 1 %"
    assert joint_name([End(2.0, "conical x", "1 %"), End(2.0, "bending y", "1 %")]) == "conical x, bending y, 1 %"


def test_long_names_at_the_ends_leave_the_axes_their_room() -> None:
    found = ab.rotor.campbell(rig("discoidal_rig"), "288:1380 rpm:5")  # torsion, axial and tilt close together
    figure = ab.plot.campbell(found)
    figure.draw_without_rendering()
    assert figure.axes[0].get_position().width > 0.45


@pytest.mark.parametrize("damping", [20.0, 0.2])
def test_a_picture_of_a_few_speeds_shows_the_peak_in_full_and_plain_numbers(damping: float) -> None:
    """Of an oscillator the peak is U/(2 D M sqrt(1 - D^2)); with the lighter damping it is 900 times narrower than a step."""
    share = damping / (2.0 * math.sqrt(3.0 * 12e3))
    speeds = np.linspace(20.0, 200.0, 4 if damping < 1.0 else 100)
    found = ab.rotor.response(planar(damping=damping), speeds, unbalance=1e-4, smooth=True)
    above = ab.plot.response(found, deflection_unit="um").axes[0]
    peak = 1e6 * 1e-4 / (2.0 * share * 3.0 * math.sqrt(1.0 - share**2))
    assert np.max(lines(above)["greatest"][1]) == pytest.approx(peak, rel=2e-3)
    assert np.isin(speeds, found["speed"].values).all()
    assert found.sizes["speed"] < 500
    above.get_figure().draw_without_rendering()
    shown = [text.get_text() for text in above.get_yticklabels()]
    assert "100" in shown
    assert not any("$" in text for text in shown)


def test_a_smooth_response_ends_where_nothing_limits_the_resonance() -> None:
    """The critical speed is in the middle of the speeds asked for; there the response has no value."""
    model = planar(damping=0.0)
    critical = math.sqrt(12e3 / 3.0)
    found = ab.rotor.response(model, [0.5 * critical, 1.5 * critical], unbalance=1e-4, smooth=True)
    assert 10 < found.sizes["speed"] < 3000
    assert np.isfinite(found["semi_major"].values).all()

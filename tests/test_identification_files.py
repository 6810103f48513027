"""Measurement files and the command that uses them."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.references.pictures import size_of
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.examples import rig
from autobalancer.files.machine_file import load_race_machine, save_machine
from autobalancer.measurement.run_up_fit import load_measurements
from autobalancer.rotordynamics.identify import identify
from autobalancer.rotordynamics.parameter_fit import (
    KnownValue,
    MeasuredCriticalSpeed,
    MeasuredMode,
    MeasuredResponse,
    MeasuredStiffness,
)

MACHINE = rig("rodrigues_rig")
DATA = "examples/measurements/rodrigues_critical_speeds.toml"
HEAD = '[[parameters]]\npaths = ["rotor.mass"]\nlower = "1 kg"\nupper = "2 kg"\nname = "M"\n'


def written(folder: Path, text: str) -> Path:
    path = folder / "data.toml"
    path.write_text(HEAD + text, encoding="utf-8")
    return path


def test_every_kind_of_measurement_is_read_with_its_units(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text("# note\nspeed [rpm], amplitude [mm]\n600, 0.1\n1200, 0.2\n1800, 0.3\n")
    path = written(
        tmp_path,
        """
        [[modes]]
        value = "9.6 Hz"
        error = "1 %"
        speed = "60 rpm"
        whirl = "forward"
        [[modes]]
        value = "2.8 1/s"
        error = "0.1 1/s"
        quantity = "decay_rate"
        [[critical_speeds]]
        value = "600 rpm"
        error = "6 rpm"
        order = 2
        [[stiffnesses]]
        value = "40 kN/m"
        error = "1 kN/m"
        station = "disk"
        direction = "y"
        [[known]]
        path = "M"
        value = "1280 g"
        error = "5 g"
        [[responses]]
        file = "curve.csv"
        error = "2 %"
        stations = ["B1", "B2"]
        highest = "1500 rpm"
        """,
    )
    (free,), found = load_measurements(path)
    rpm = np.pi / 30.0
    assert (free.name, free.lower, free.upper) == ("M", "1 kg", "2 kg")
    kinds = [MeasuredMode, MeasuredMode, MeasuredCriticalSpeed, MeasuredStiffness, KnownValue, MeasuredResponse]
    assert [type(entry) for entry in found] == sorted(kinds, key=[type(e) for e in found].index)
    at = {type(entry): entry for entry in found[::-1]}
    mode, decay = [entry for entry in found if isinstance(entry, MeasuredMode)]
    assert (mode.value, mode.error) == pytest.approx((9.6 * 2.0 * np.pi, 0.096 * 2.0 * np.pi))
    assert (mode.speed, mode.whirl) == (pytest.approx(2.0 * np.pi), "forward")
    assert (decay.quantity, decay.value) == ("decay_rate", 2.8)
    assert at[MeasuredCriticalSpeed] == MeasuredCriticalSpeed(pytest.approx(600 * rpm), pytest.approx(6 * rpm), 2)
    assert at[MeasuredStiffness] == MeasuredStiffness(4e4, 1e3, "disk", "y")
    assert at[KnownValue] == KnownValue(1.28, 0.005, "M")
    curve = at[MeasuredResponse]
    assert isinstance(curve, MeasuredResponse)
    np.testing.assert_allclose(curve.speeds, [600 * rpm, 1200 * rpm])
    np.testing.assert_allclose(curve.amplitudes, [1e-4, 2e-4])
    assert curve.error == pytest.approx(0.02)


def test_an_error_in_meters_of_a_logarithmic_curve_becomes_relative(tmp_path: Path) -> None:
    (tmp_path / "curve.csv").write_text("speed [rad/s]; amplitude [um]\n10; 100\n20; 200\n")
    text = '[[responses]]\nfile = "curve.csv"\nerror = "2 um"\n'
    (curve,) = load_measurements(written(tmp_path, text))[1]
    np.testing.assert_allclose(curve.error, [0.02, 0.01])  # type: ignore[attr-defined]
    np.testing.assert_allclose(curve.rows().error, 2e-6)
    (curve,) = load_measurements(written(tmp_path, text.replace("2 um", "2 %") + "logarithmic = false\n"))[1]
    np.testing.assert_allclose(curve.rows().error, [2e-6, 4e-6])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "[[mode]]\nvalue = 1\n",
            r"mode: unknown key; did you mean 'modes' or 'orders'\? allowed here: critical_speeds",
        ),
        ("[[modes]]\nvalue = 1\n", r"modes\[1\].error: missing"),
        ("[[modes]]\nvalue = 1\nerror = 1\nshape = 2\n", r"modes\[1\].shape: unknown key"),
        ('[[modes]]\nvalue = "1 kg"\nerror = 1\n', r"modes\[1\].value: given '1 kg'"),
        ('[[modes]]\nvalue = 1\nerror = 1\nquantity = "Q"\n', "quantity: given 'Q'"),
        ("[modes]\nvalue = 1\n", r"modes\[1\].error: missing"),
        ('[[responses]]\nfile = "no.csv"\nerror = "1 %"\n', r"responses\[1\].*no such file"),
        ('[[responses]]\nfile = "data.toml"\nerror = "1 %"\n', "name the columns"),
        ("value = ", "not valid TOML"),
    ],
)
def test_faulty_files_are_refused_with_the_key(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(AutobalancerError, match=says):
        load_measurements(written(tmp_path, text))
    with pytest.raises(QuestionError, match="no such file"):
        load_measurements(tmp_path / "none.toml")


def test_the_command_writes_machine_numbers_and_picture(tmp_path: Path) -> None:
    out, numbers, picture = tmp_path / "fitted.toml", tmp_path / "fit.nc", tmp_path / "fit.png"
    options = ["--out", str(out), "--out", str(numbers), "--plot", str(picture)]
    place = "rotor.supports[1].stiffness[1]"
    author = ab.with_parameter(MACHINE, place, f"{1e-3 * MACHINE.rotor.supports[0].stiffness[0]} kN/m")
    machine = save_machine(author, tmp_path / "rig.toml")
    shown = CliRunner().invoke(app, ["identify", str(machine), "--measurements", DATA, *options])
    assert shown.exit_code == 0, shown.output
    assert "stiffness along x" in shown.output
    fitted = load_race_machine(out)
    assert "Identified from 6 measured values" in fitted.description
    number, unit = fitted.rotor.supports[0].stiffness[0].text.split()
    assert unit == "kN/m"  # as its author wrote it
    assert f"{float(number):.7g}" in shown.output
    with xr.open_dataset(numbers) as data:
        assert float(data["value"][0]) == pytest.approx(fitted.rotor.supports[0].stiffness[0])
    assert size_of(picture) == (1260, 510)


def test_the_command_prints_numbers_for_programs_and_frees_more(tmp_path: Path) -> None:
    machine = save_machine(MACHINE, tmp_path / "rig.toml")
    arguments = ["identify", str(machine), "--measurements", DATA, "--json", "--free", "rotor.mass=1.2 kg:1.3 kg"]
    shown = CliRunner().invoke(app, arguments)
    found = json.loads(shown.stdout)
    assert found["parameter"][-1] == "rotor.mass"
    assert 1.2 <= found["value"][-1] <= 1.3
    wrong = CliRunner().invoke(app, [*arguments[:-1], "rotor.mass"])
    assert wrong.exit_code == 2


def test_the_curve_of_the_picture_has_the_peak_that_lies_between_measured_speeds() -> None:
    """The response of the fitted machine, not a line from one measured value to the next."""
    dense, coarse = np.linspace(100.0, 300.0, 4001), np.linspace(100.0, 300.0, 10)
    peak = ab.rotor.response(MACHINE, dense, ["B1", "B2"])["mean_of_greatest"].values.max()
    values = ab.rotor.response(MACHINE, coarse, ["B1", "B2"])["mean_of_greatest"].values
    assert values.max() < 0.7 * peak
    measured = MeasuredResponse(coarse, values, 0.01, ["B1", "B2"], label="both bearings")
    figure = ab.plot.answer(identify(MACHINE, {"rotor.transverse_inertia": (0.01, 0.02)}, [measured]).data)
    lines = {line.get_label(): np.asarray(line.get_ydata(), float) for line in figure.axes[0].get_lines()}
    assert lines["measured"].size == 10
    assert lines["after the fit"].max() / lines["measured"].max() == pytest.approx(peak / values.max(), rel=0.02)


def test_the_picture_has_a_panel_for_each_curve() -> None:
    speeds = np.linspace(100.0, 300.0, 30)
    values = ab.rotor.response(MACHINE, speeds, ["B1", "B2"])["mean_of_greatest"].values
    curve = MeasuredResponse(speeds, values, 0.01, ["B1", "B2"], label="both bearings")
    free = {"rotor.transverse_inertia": (0.01, 0.02)}
    fit = identify(MACHINE, free, [curve, KnownValue(0.014, 0.001, next(iter(free)))]).data
    figure = ab.plot.answer(fit)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["both bearings", "", "correlation"]
    for count in (5, 14):  # names of so many parameters do not touch
        names = [f"rotor.supports[{k}].angular_stiffness_about_x" for k in range(count)]
        of_parameters = {"correlation": (("parameter", "other_parameter"), np.eye(count) - 1e-4)}
        alone = fit.drop_dims(["parameter", "other_parameter"], errors="ignore")
        figure = ab.plot.answer(alone.assign(of_parameters).assign_coords(parameter=np.array(names, object)))
        figure.canvas.draw()
        assert not any(text.get_text() == "-0.00" for text in figure.axes[-1].texts)
        boxes = [label.get_window_extent() for label in figure.axes[-1].get_yticklabels()]
        assert not any(one.overlaps(other) for one, other in pairwise(boxes))
        assert min(box.x0 for box in boxes) >= 0.0
    with pytest.raises(QuestionError, match=r"is of a result of rotor\.identify"):
        ab.plot.answer(ab.rotor.response(MACHINE, speeds), "identification")

"""Measured signals: one form, several files, and bad input that is refused or told with its time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
from autobalancer.errors import AutobalancerError, QuestionError, RangeWarning, ResultError
from autobalancer.measure import Channel

TIME = np.arange(400) / 1000.0
WAVE = 1e-4 * np.sin(2.0 * np.pi * 10.0 * TIME)


def table(path: Path, head: str, *columns: np.ndarray, mark: str = ",", decimal: str = ".") -> Path:
    rows = [mark.join(f"{value:.9g}".replace(".", decimal) for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join(["# a logger", head, *rows]) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(("mark", "decimal"), [(",", "."), (";", ","), ("\t", ","), ("\t", ".")])
def test_a_table_is_read_whatever_its_separators(tmp_path: Path, mark: str, decimal: str) -> None:
    head = mark.join(["time [ms]", "bearing A x [mm]", "a [m/s2]", "tacho"])
    file = table(tmp_path / "s.csv", head, 1e3 * TIME, 1e3 * WAVE, 2.0 * WAVE, WAVE > 0.0, mark=mark, decimal=decimal)
    found = ab.measure.load_signals(file)
    assert found["time"].values == pytest.approx(TIME)
    assert found["bearing_A_x"].values == pytest.approx(WAVE, abs=1e-12)
    assert [v.attrs["quantity"] for v in found.data_vars.values()] == ["displacement", "acceleration", "tacho"]
    assert found["bearing_A_x"].attrs["direction"] == "x"
    assert found.attrs["sampling_rate"] == pytest.approx(1000.0)


def test_lines_of_a_logger_above_the_names_are_left_out(tmp_path: Path) -> None:
    file = table(tmp_path / "s.csv", "Zeit [ms];Lager süd x [mm]", 1e3 * TIME, 1e3 * WAVE, mark=";", decimal=",")
    above = "Messung;Prüfstand 3;12.11.2026\nAbtastrate:, 1000 Hz\n\n"
    file.write_bytes((above + file.read_text(encoding="utf-8")).encode("cp1252"))
    assert ab.measure.load_signals(file)["Lager_süd_x"].values == pytest.approx(WAVE, abs=1e-12)
    file.write_text("x [m];y [m]\n1;1\na;b\n3;3\n", encoding="utf-8")
    with pytest.raises(ResultError, match="line 3, column 'x': 'a' is not a number"):
        ab.measure.load_signals(file, rate=1000.0)


def test_channels_are_described_beside_the_file_or_by_a_dict(tmp_path: Path) -> None:
    file = table(tmp_path / "s.csv", "ai0,ai1", 8.0e3 * WAVE, 0.0102 * WAVE)
    (tmp_path / "s.channels.toml").write_text(
        '[channels.x]\ncolumn = "ai0"\nquantity = "displacement"\nunit = "V"\nsensitivity = "8 mV/um"\nplace = "bearing A"\n'
        'direction = 45\nuncertainty = "1 um"\n\n[channels.a]\ncolumn = "ai1"\nquantity = "acceleration"\n'
        'sensitivity = "10.2 mV/(m/s^2)"\n',
        encoding="utf-8",
    )
    found = ab.measure.load_signals(file, rate="1 kHz")
    assert found["x"].values == pytest.approx(WAVE, abs=1e-12)
    assert found["a"].values == pytest.approx(WAVE, abs=1e-12)
    assert found["x"].attrs["direction"] == 45.0
    assert found["x"].attrs["uncertainty"] == pytest.approx(1e-6)
    only = ab.measure.load_signals(file, {"v": {"column": "ai0", "quantity": "voltage", "unit": "mV"}}, rate=1000.0)
    assert only["v"].values == pytest.approx(8.0 * WAVE)


def test_times_that_are_rounded_in_the_file_are_even(tmp_path: Path) -> None:
    t = np.arange(300) / 2048.0
    file = tmp_path / "s.csv"
    file.write_text("t [s],x [um]\n" + "".join(f"{a:.4f},{b:.2f}\n" for a, b in zip(t, np.sin(40 * t), strict=True)))
    assert ab.measure.load_signals(file).attrs["sampling_rate"] == pytest.approx(2048.0, rel=1e-3)


def test_uneven_samples_are_resampled_only_when_asked(tmp_path: Path) -> None:
    t = TIME + 2e-4 * np.sin(37.0 * TIME)
    file = table(tmp_path / "s.csv", "time [s],x [m]", t, 1e-4 * np.sin(2.0 * np.pi * 10.0 * t))
    with pytest.raises(QuestionError, match=r"not evenly spaced: .* Resample them, for example resample='\d+ Hz'"):
        ab.measure.load_signals(file)
    with pytest.warns(RangeWarning, match="resampled to 1000 Hz"):
        found = ab.measure.load_signals(file, resample="1 kHz")
    known = 1e-4 * np.sin(2.0 * np.pi * 10.0 * found["time"].values)
    assert found["x"].values == pytest.approx(known, abs=1e-9)


def holed(values: np.ndarray) -> np.ndarray:
    return np.where((TIME > 0.1) & (TIME < 0.1025), np.nan, values)


@pytest.mark.parametrize(
    ("head", "columns", "error"),
    [
        ("time [s],x [um]", (TIME, holed(WAVE)), r"'x': 2 of 400 samples are no numbers, at 0\.101 s to 0\.102 s"),
        ("time [s],x [m]", (TIME, 1e3 * WAVE), r"0\.2 m from peak to peak; is its unit mm or um\?"),
        ("time [s],x [um]", (np.where(TIME > 0.2, TIME + 0.05, TIME), WAVE), r"missing after 0\.2 s \(0\.051 s\)"),
        ("time [s],x [um]", (np.where(TIME == 0.3, 0.1, TIME), WAVE), r"must ascend; after 0\.299 s comes 0\.1 s"),
        ("time [s],x [kg]", (TIME, WAVE), "its unit 'kg' is that of no quantity"),
        ("time [s],x", (TIME, WAVE), "no column has a unit"),
        ("x [um]", (WAVE,), "no column of time; give the rate"),
        ("0.1,0.2", (TIME, WAVE), "does not name its columns; describe 1, 2, ... as channels"),
        ("x [um],x [um]", (TIME, WAVE), "column 'x' comes twice"),
        ("time [m],x [um]", (TIME, WAVE), "unit of column 'time'"),
        ("t,x [um]", (TIME, WAVE), r"column 't' has no unit; write it in the first line, such as t \[s\]"),
    ],
)
def test_bad_input_is_refused_with_its_time(
    tmp_path: Path, head: str, columns: tuple[np.ndarray, ...], error: str
) -> None:
    with pytest.raises(AutobalancerError, match=error):
        ab.measure.load_signals(table(tmp_path / "s.csv", head, *columns))


def test_a_piece_without_the_fault_is_read(tmp_path: Path) -> None:
    file = table(tmp_path / "s.csv", "time [s],x [um]", TIME, holed(WAVE))
    assert ab.measure.load_signals(file, start="0.11 s").sizes["time"] == 290
    with pytest.raises(QuestionError, match=r"no samples from start to end; the file has 0 s to 0\.399 s"):
        ab.measure.load_signals(file, start=3.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (np.clip(WAVE, -1.0, 0.6e-4), r"'x' is clipped: \d+ samples stand at .* at 0\.011 s to 0\.039 s"),
        (np.full(400, 2e-6), "'x' is constant, 2e-06 at every sample"),
        (1e-9 * WAVE, "is its unit right"),
    ],
)
def test_doubtful_channels_are_told(tmp_path: Path, values: np.ndarray, words: str) -> None:
    with pytest.warns(RangeWarning, match=words):
        found = ab.measure.load_signals(table(tmp_path / "s.csv", "time [s],x [m]", TIME, values))
    assert "x" in found.attrs["warnings"]


def test_a_wave_that_is_only_rounded_is_not_clipped() -> None:
    from autobalancer.measurement.signals.checks import clipped_samples

    slow = np.sin(2.0 * np.pi * 0.7 * np.arange(4000) / 1000.0)
    for digits in (1, 2, 3, 6):
        assert not clipped_samples(np.round(slow, digits)).size
    noisy = np.clip(slow + 0.02 * np.random.default_rng(1).standard_normal(slow.size), -0.8, 0.8)
    assert clipped_samples(noisy).size > 500


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"quantity": "position"}, "quantity 'position'; must be one of displacement"),
        ({"units": "mm"}, "units 'mm'; a displacement is given in m"),
        ({"direction": "up"}, "direction 'up'; must be x, y, z"),
        ({"values": WAVE[1:]}, "399 values for 400 times"),
        ({"values": holed(WAVE)}, r"the value at 0\.101 s is not a finite number"),
    ],
)
def test_the_constructor_takes_nothing_else(change: dict[str, object], words: str) -> None:
    channel = ab.measure.Channel(**{"values": WAVE, "quantity": "displacement", **change})
    with pytest.raises(QuestionError, match=words):
        ab.measure.signals(TIME, {"x": channel})
    with pytest.raises(QuestionError, match="steps are not equal"):
        ab.measure.signals(TIME**2 + TIME, {"x": ab.measure.Channel(WAVE, "displacement")})


def test_signals_are_kept_in_a_file_and_show_their_channels(tmp_path: Path) -> None:
    channels = {"x": ab.measure.Channel(WAVE, "displacement", "bearing A", "x", uncertainty=1e-6)}
    found = ab.measure.signals(TIME, channels, origin="a run")
    ab.save_run(found, tmp_path / "s.nc")
    again = ab.measure.load_signals(tmp_path / "s.nc")
    assert repr(again) == repr(found)
    assert "bearing A x" in repr(found)
    with pytest.raises(ResultError, match="no such file"):
        ab.measure.load_signals(tmp_path / "t.csv")


def universal(kind: str, values: np.ndarray) -> bytes:
    """A time record of the acceleration at node 12 along minus x, in g, from 0.5 s at 1 kHz."""
    lines = [
        "bearing",
        "",
        "",
        "",
        "",
        "    1         1    0         0       NONE        12  -1       NONE         0   0",
    ]
    form = 2 if kind == "58" else 4
    lines.append(f"{form:10d}{values.size:10d}{1:10d}{0.5:13.5e}{1e-3:13.5e}{0.0:13.5e}")
    lines.append(f"{17:10d}    0    0    0 {'Time':<20} {'s':<20}")
    lines.append(f"{12:10d}    0    0    0 {'Acceleration':<20} {'g':<20}")
    lines += [f"{0:10d}    0    0    0 {'NONE':<20} {'NONE':<20}"] * 2
    if kind == "58":
        rows = ["".join(f"{v:13.5e}" for v in values[i : i + 6]) for i in range(0, values.size, 6)]
        body = ("\n".join(["    58", *lines, *rows]) + "\n").encode()
    else:
        first = f"    58b{1:6d}{2:6d}{11:12d}{8 * values.size:12d}{0:6d}{0:6d}{0:12d}{0:12d}"
        body = ("\n".join([first, *lines]) + "\n").encode() + values.astype("<f8").tobytes() + b"\n"
    return b"    -1\n" + body + b"    -1\n"


@pytest.mark.parametrize("kind", ["58", "58b"])
def test_time_records_of_universal_files_are_read_in_ascii_and_binary(tmp_path: Path, kind: str) -> None:
    values = np.sin(40.0 * TIME) + 0.1
    (tmp_path / "r.uff").write_bytes(universal(kind, values) + universal(kind, 2.0 * values))
    found = ab.measure.load_signals(tmp_path / "r.uff")
    assert found["acceleration_12_x"].values == pytest.approx(-9.80665 * values, abs=1e-4)
    assert found["acceleration_12_x'"].values == pytest.approx(-9.80665 * 2.0 * values, abs=2e-4)
    assert found["acceleration_12_x"].attrs["place"] == "12"
    assert float(found["time"][0]) == 0.5
    (tmp_path / "r.uff").write_bytes(universal(kind, values).replace(b"       400 ", b"       402 ", 1))
    with pytest.raises(ResultError, match="400 numbers where 402" if kind == "58" else "ends before its 402 values"):
        ab.measure.load_signals(tmp_path / "r.uff")


def test_signals_that_are_written_as_a_universal_file_come_back_as_they_were(tmp_path: Path) -> None:
    channels = {
        "x": Channel(1e-4 * np.sin(40.0 * TIME), "displacement", "A", "x"),
        "along": Channel(np.cos(40.0 * TIME), "acceleration", "bearing 12", 30.0),
        "mark": Channel(np.sign(np.sin(20.0 * TIME)), "tacho"),
    }
    given = ab.measure.signals(TIME + 0.25, channels)
    ab.save_run(given, tmp_path / "r.uff")
    found = ab.measure.load_signals(tmp_path / "r.uff")
    np.testing.assert_allclose(found["time"], given["time"], atol=1e-9)
    for name in channels:
        np.testing.assert_allclose(found[name], given[name], rtol=1e-11)
        assert {k: str(found[name].attrs[k]) for k in ("quantity", "place", "units")} == {
            k: str(given[name].attrs[k]) for k in ("quantity", "place", "units")
        }
    assert float(found["along"].attrs["direction"]) == 30.0
    with pytest.raises(ResultError, match="universal files hold signals"):
        ab.save_run(xr.Dataset(), tmp_path / "other.uff")
    long = ab.measure.signals(TIME, {"x": Channel(TIME, "displacement", "the upper bearing", "x")})
    with pytest.raises(ResultError, match="has more than 10 letters"):
        ab.save_run(long, tmp_path / "other.uff")


def test_arrays_of_numpy_and_matlab_are_read(tmp_path: Path) -> None:
    from scipy.io import savemat

    np.savez(tmp_path / "s.npz", **{"time": TIME, "x [um]": 1e6 * WAVE, "note": np.array("text")})
    assert ab.measure.load_signals(tmp_path / "s.npz")["x"].values == pytest.approx(WAVE, abs=1e-12)
    savemat(tmp_path / "s.mat", {"fs": 1000.0, "ai0": 1e6 * WAVE})
    words = {"x": {"column": "ai0", "quantity": "displacement", "unit": "um"}}
    found = ab.measure.load_signals(tmp_path / "s.mat", words)
    assert found["x"].values == pytest.approx(WAVE, abs=1e-12)
    assert found.attrs["sampling_rate"] == pytest.approx(1000.0)
    with pytest.raises(QuestionError, match="no column has a unit"):
        ab.measure.load_signals(tmp_path / "s.mat")
    np.savez(tmp_path / "s.npz", a=TIME, b=TIME[1:])
    with pytest.raises(ResultError, match=r"equally long arrays of one dimension; there are a \(400\), b \(399\)"):
        ab.measure.load_signals(tmp_path / "s.npz")


def test_sound_files_need_a_full_scale(tmp_path: Path) -> None:
    from scipy.io import wavfile

    wavfile.write(tmp_path / "s.wav", 1000, np.round(32767 * WAVE / 1e-4).astype(np.int16))
    words = {"a": {"column": "1", "quantity": "acceleration", "full_scale": "20 m/s^2"}}
    found = ab.measure.load_signals(tmp_path / "s.wav", words)
    assert found["a"].values == pytest.approx(20.0 * WAVE / 1e-4, abs=2e-3)
    with pytest.raises(QuestionError, match="describe the channels"):
        ab.measure.load_signals(tmp_path / "s.wav")

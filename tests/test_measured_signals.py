"""Measured signals: one form, several files, and bad input that is refused or told with its time."""

from __future__ import annotations

import os
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
from autobalancer.errors import AutobalancerError, QuestionError, RangeWarning, ResultError
from autobalancer.measure import Channel
from autobalancer.measurement.balancing.run_down import load_orders

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


def rows(head: str, mark: str, *columns: Callable[[int], str], count: int = 40) -> str:
    return "\n".join([head, *(mark.join(column(i) for column in columns) for i in range(count))]) + "\n"


def second(i: int) -> str:
    return f"{i / 2000:.4f}"


def tenth(i: int) -> str:
    return f"{0.1 * i:.1f}"


def comma(column: Callable[[int], str]) -> Callable[[int], str]:
    return lambda i: column(i).replace(".", ",")


MIDNIGHT = tuple(f"23:59:59.{980 + i}" if i < 20 else f"00:00:00.{i - 20:03d}" for i in range(40))
TENTHS = 1e-4 * np.arange(40)  # of mm
LOGGERS = {
    "units below": (rows("Time,Ch 1\ns,mm", ",", second, tenth), {"Ch_1": TENTHS}),
    "lines above": (rows("Bench;3\nRate;2000\nTime;Ch 1\n[s];[mm]", ";", second, tenth), {"Ch_1": TENTHS}),
    "LabVIEW": (rows("X_Value\tx [mm]", "\t", second, tenth), {"x": TENTHS}),
    "slashes": (rows("time/s\tx/mm\tv/(mm/s)", "\t", second, tenth, tenth), {"x": TENTHS, "v": TENTHS}),
    "underscore": (rows("time_s;x [mm]", ";", second, tenth), {"x": TENTHS}),
    "catman": (rows("Zeit  1 - Standard [s]\tWeg [mm]", "\t", comma(second), comma(tenth)), {"Weg": TENTHS}),
    "blanks": (rows("time [s]  x [mm]", "   ", second, tenth), {"x": TENTHS}),
    "both marks, each sure": (rows("time [s];x [mm]", ";", second, comma(tenth)), {"x": TENTHS}),
    "German thousands": (
        rows("time [s];f [N]", ";", comma(second), lambda i: f"1.{500 + i},5"),
        {"f": 1500.5 + np.arange(40)},
    ),
    "quoted thousands": (
        rows("time [s],f [N]", ",", second, lambda i: f'"1,{500 + i}.5"'),
        {"f": 1500.5 + np.arange(40)},
    ),
    "Swiss thousands": (rows("time [s],f [N]", ",", second, lambda i: f"1'{500 + i}"), {"f": 1500.0 + np.arange(40)}),
    "thousands of millions": (
        rows("time [s];f [N]", ";", second, lambda i: f"1,{500 + i},000"),
        {"f": 1e3 * (1500.0 + np.arange(40))},
    ),
}


@pytest.mark.parametrize("name", LOGGERS)
def test_tables_of_loggers_are_read_as_they_write_them(tmp_path: Path, name: str) -> None:
    text, known = LOGGERS[name]
    (tmp_path / "s.csv").write_text(text, encoding="utf-8")
    found = ab.measure.load_signals(tmp_path / "s.csv", implausible=True)
    assert found["time"].values == pytest.approx(np.arange(40) / 2000.0)
    assert {str(key): pytest.approx(found[key].values) for key in found.data_vars} == known


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (rows("time [s]\tn [rad/s]", "\t", second, lambda i: f"1,{500 + i}"), "line 2, column 'n': '1,500' may have"),
        (rows("time [s];n [rad/s]", ";", comma(second), lambda i: f"1.{500 + i}"), "line 2, column 'n': '1.500' may"),
        (rows("time [s];x [mm]", ";", second, lambda i: "0,5" if i else "1.5"), "line 3, .* another decimal mark"),
        (rows("time [s],x [mm]", ",", comma(second), tenth), "3 cells for 2 columns; where commas are decimal marks"),
        (rows("time [s];x [mm]", ";", second, lambda i: "1e400"), "samples are no numbers"),
        (rows("time [s];x [mm]", ";", second, lambda i: "1e308"), None),
        (rows("1e400;x [mm]", ";", lambda i: "1e400", tenth), "not a number"),
        (rows("0;0", ";", second, tenth), "does not name its columns"),
        (rows("x [mm];n", ";", tenth, lambda i: "a" if i == 30 else "1"), "line 32, column 'n': 'a' is not a number"),
    ],
)
def test_what_may_mean_two_things_or_nothing_is_refused_at_its_place(
    tmp_path: Path, text: str, words: str | None
) -> None:
    (tmp_path / "s.csv").write_text(text, encoding="utf-8")
    if words is None:
        with pytest.warns(RangeWarning, match="is constant"):
            ab.measure.load_signals(tmp_path / "s.csv")
        return
    with pytest.raises(AutobalancerError, match=words):
        ab.measure.load_signals(tmp_path / "s.csv")


@pytest.mark.parametrize("date", ["", "2026-11-12T", "12.11.2026 "])
def test_clock_times_and_time_stamps_are_seconds_from_the_first_also_past_midnight(tmp_path: Path, date: str) -> None:
    late = date.replace("12T", "13T").replace("12.11", "13.11")
    stamps = [(late if clock < "12" else date) + clock for clock in MIDNIGHT]
    text = rows("Zeitpunkt;Bemerkung;x [mm]", ";", stamps.__getitem__, lambda i: "ok", tenth)
    (tmp_path / "s.csv").write_text(text, encoding="utf-8")
    with pytest.warns(RangeWarning, match="column 'Bemerkung': no numbers, left out"):
        found = ab.measure.load_signals(tmp_path / "s.csv")
    assert found["time"].values == pytest.approx(1e-3 * np.arange(40), abs=1e-9)


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "cp1252"])
def test_tables_are_read_in_the_encodings_of_notepad_and_excel(tmp_path: Path, encoding: str) -> None:
    text = rows("Zeit [s]\tLänge [µm]", "\t", comma(second), comma(tenth))
    (tmp_path / "s.txt").write_bytes(text.replace("\n", "\r\n").encode(encoding))
    assert ab.measure.load_signals(tmp_path / "s.txt")["Länge"].values == pytest.approx(1e-3 * TENTHS)


def test_a_rate_takes_the_place_of_times_that_are_rounded_too_coarsely(tmp_path: Path) -> None:
    file = tmp_path / "s.csv"
    file.write_text(rows("time [ms];x [mm]", ";", lambda i: str(i // 2), tenth, count=400), encoding="utf-8")
    with pytest.raises(QuestionError, match=r"after 0 s comes 0 s. If the samples are even .* rate='2005 Hz'"):
        ab.measure.load_signals(file, implausible=True)
    with pytest.warns(RangeWarning, match=r"rate of 2000 Hz is used, not the column of time$"):
        found = ab.measure.load_signals(file, rate="2 kHz", implausible=True)
    assert found["time"].values == pytest.approx(np.arange(400) / 2000.0)
    with pytest.warns(RangeWarning, match=r"by it the file lasts 0\.199 s, by the rate 0\.3325 s"):
        ab.measure.load_signals(file, rate="1.2 kHz", implausible=True)


def test_columns_that_are_left_out_and_a_likely_tacho_are_named(tmp_path: Path) -> None:
    file = table(tmp_path / "s.csv", "time [s],x,y [mm],Drehzahlimpuls [V]", TIME, WAVE, 1e3 * WAVE, 1e5 * WAVE)
    with pytest.warns(RangeWarning, match="x has no unit and was left out"):
        found = ab.measure.load_signals(file)
    assert list(found.data_vars) == ["y", "Drehzahlimpuls"]
    with pytest.raises(QuestionError, match=r"'Drehzahlimpuls' is the tacho, say .*--tacho Drehzahlimpuls"):
        ab.measure.rotor_angle(found)
    file = table(tmp_path / "s.csv", "time [s],x,tacho [V]", TIME, WAVE, 1e5 * np.sin(300.0 * TIME))
    with pytest.warns(RangeWarning), pytest.raises(QuestionError, match=r"none of tacho is .*x has no unit"):
        ab.measure.orders(ab.measure.load_signals(file))


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
    with pytest.raises(QuestionError, match=r"^channels\.v\.colum: unknown key; did you mean 'column'"):
        ab.measure.load_signals(file, {"v": {"colum": "ai0"}}, rate=1000.0)


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


def holed(values: np.ndarray, end: float = 0.2) -> np.ndarray:
    return np.where((TIME > 0.1) & (end > TIME), np.nan, values)


@pytest.mark.parametrize("long", [False, True])
def test_a_missing_sample_and_a_gap_of_a_tenth_of_a_period_are_bridged_and_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, long: bool
) -> None:
    if long:
        monkeypatch.setattr("autobalancer.measurement.signal_formats.LONG", 100)
        monkeypatch.setattr("autobalancer.measurement.signal_formats.LONG_TABLE", 100)
    wave = np.sin(2.0 * np.pi * 12.0 * TIME)  # a period of 83 samples
    with_gap = np.where(np.isin(np.arange(400), [50, 200, 201, 202]), np.nan, wave)
    pulses = np.where(np.arange(400) == 50, np.nan, (np.arange(400) % 80 < 4) * 5.0)
    file = table(tmp_path / "s.csv", "time [s],x [um],tacho [V]", TIME, with_gap, pulses)
    with pytest.warns(RangeWarning, match="were no numbers"):
        found = ab.measure.load_signals(file)
    assert (
        "'x': 4 of 400 samples were no numbers and are interpolated, at 0.05 s, 0.2 s to 0.202 s"
        in found.attrs["warnings"]
    )
    assert found["x"].values == pytest.approx(1e-6 * wave, abs=1e-11)  # a hundred thousandth of its amplitude
    assert found["tacho"].values == pytest.approx((np.arange(400) % 80 < 4) * 5.0)
    assert "'tacho': 1 of 400" in found.attrs["warnings"]


@pytest.mark.parametrize(
    ("gap", "hertz"),
    [(range(100, 110), 12.0), (range(100, 102), 120.0), (range(397, 400), 12.0), (range(20, 400, 20), 12.0)],
)
def test_a_gap_that_is_long_for_its_signal_at_an_end_or_one_of_many_is_refused(
    tmp_path: Path, gap: range, hertz: float
) -> None:
    wave = np.where(np.isin(np.arange(400), gap), np.nan, np.sin(2.0 * np.pi * hertz * TIME))
    with pytest.raises(QuestionError, match=r"10 % of a period are bridged, not more than 1 % of all\. Use the pieces"):
        ab.measure.load_signals(table(tmp_path / "s.csv", "time [s],x [um]", TIME, wave))


@pytest.mark.parametrize(
    ("head", "columns", "error"),
    [
        ("time [s],x [um]", (TIME, holed(WAVE)), r"'x': 99 of 400 samples are no numbers, at 0\.101 s to 0\.199 s"),
        ("time [s],x [m]", (TIME, 1e3 * WAVE), r"0\.2 m from peak to peak; is its unit mm or um\?"),
        ("time [s],x [um]", (np.where(TIME > 0.2, TIME + 0.05, TIME), WAVE), r"missing after 0\.2 s \(0\.051 s\)"),
        ("time [s],x [um]", (np.where(TIME == 0.3, 0.1, TIME), WAVE), r"must ascend; after 0\.299 s comes 0\.1 s"),
        ("time [s],x [kg]", (TIME, WAVE), "its unit 'kg' is that of no quantity"),
        ("time [s],x", (TIME, WAVE), "no column has a unit"),
        ("x [um]", (WAVE,), "no column of time; give the rate"),
        (
            "frequency [Hz],x [um]",
            (1.0 + TIME, WAVE),
            "no column of time; over the frequency it is a receptance",
        ),
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
    assert ab.measure.load_signals(file, start="0.21 s").sizes["time"] == 190
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
    from autobalancer.measurement.load_signals import clipped_samples

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
        ({"values": holed(WAVE, 0.1025)}, r"the value at 0\.101 s is not a finite number"),
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
    if kind == "58":
        (tmp_path / "r.uff").write_bytes(universal(kind, values).replace(b"1.00000e-01", b"1.00o00e-01", 1))
        with pytest.raises(ResultError, match=r"function 1: '\S*1.00o00e-01\S*' is not a number"):
            ab.measure.load_signals(tmp_path / "r.uff")
    (tmp_path / "r.uff").write_bytes(universal(kind, values).replace(b"       400 ", b"       402 ", 1))
    with pytest.raises(ResultError, match="400 numbers where 402" if kind == "58" else "ends before its 402 values"):
        ab.measure.load_signals(tmp_path / "r.uff")


def test_universal_files_are_read_whatever_stands_between_their_functions(tmp_path: Path) -> None:
    file, mark, values = tmp_path / "r.uff", b"    -1\n", np.sin(40.0 * TIME)
    one, two = universal("58", values), universal("58b", values)
    for content in (
        one + one[len(mark) :] + one[len(mark) :],  # one mark between two functions
        two.replace(b"\n" + mark, mark) * 3,  # a mark that follows binary numbers at once
        (one * 3).replace(b"\n", b"\r\n").replace(b"    -1\r", b"    -1" + b" " * 74 + b"\r"),
    ):
        file.write_bytes(content)
        assert len(ab.measure.load_signals(file)) == 3
    swallowed = (two + two).replace(b"%12d" % 3200, b"%12d" % (3200 + len(two)), 1)
    file.write_bytes(swallowed)
    with pytest.warns(RangeWarning, match="1 of 2 functions .* could be read"):
        assert len(ab.measure.load_signals(file)) == 1
    label = "µm/s²".ljust(20)
    for encoding in ("utf-8", "latin-1"):
        file.write_bytes(one.decode().replace("g".ljust(20), label).encode(encoding))
        found = ab.measure.load_signals(file)["acceleration_12_x"]
        assert found.values == pytest.approx(-1e-6 * values, abs=1e-11)
    file.write_bytes(one.replace(b"    1         1", b"   12         1") + one)
    with pytest.warns(RangeWarning, match="1 of 2 functions are no time records, left out"):
        ab.measure.load_signals(file)


@pytest.mark.parametrize("binary", [0, 1])
def test_universal_files_are_those_of_pyuff_in_both_directions(tmp_path: Path, binary: int) -> None:
    pyuff = pytest.importorskip("pyuff")
    values = np.sin(np.outer(np.arange(1, 5), 40.0 * TIME))
    kinds = {"rsp_dir": 3, "ordinate_spec_data_type": 12, "orddenom_spec_data_type": 0, "abscissa_axis_units_lab": "s"}
    sets = [
        pyuff.prepare_58(
            func_type=1, rsp_node=k, data=row, x=TIME, binary=binary, abscissa_spec_data_type=17, id1=f"channel {k}",
            abscissa_spacing=1, abscissa_min=0.0, abscissa_inc=1e-3, num_pts=TIME.size, ref_node=0, ref_dir=0,
            ordinate_axis_units_lab="m/s^2", **kinds,
        )
        for k, row in enumerate(values, 1)
    ]  # fmt: skip
    pyuff.UFF(str(tmp_path / "theirs.uff")).write_sets(sets)
    found = ab.measure.load_signals(tmp_path / "theirs.uff")
    assert list(found.data_vars) == [f"acceleration_{k}_z" for k in range(1, 5)]
    np.testing.assert_allclose([found[name] for name in found.data_vars], values, atol=1e-11)
    ab.save_run(found, tmp_path / "ours.uff")
    again = pyuff.UFF(str(tmp_path / "ours.uff")).read_sets()
    np.testing.assert_allclose([one["data"] for one in again], values, atol=1e-11)
    np.testing.assert_allclose(again[0]["x"], TIME, atol=1e-9)
    hertz, ratio = np.arange(1.0, 65.0), np.exp(1j * np.arange(64.0)) * np.arange(1.0, 65.0)
    response = kinds | {"func_type": 4, "orddenom_spec_data_type": 13, "orddenom_axis_units_lab": "N"}
    one = pyuff.prepare_58(
        rsp_node=7, ref_node=7, ref_dir=3, data=ratio, x=hertz, binary=binary, abscissa_spec_data_type=18, id1="hammer",
        abscissa_spacing=1, abscissa_min=1.0, abscissa_inc=1.0, num_pts=64, ordinate_axis_units_lab="m/s^2",
        **(response | {"abscissa_axis_units_lab": "Hz"}),
    )  # fmt: skip
    pyuff.UFF(str(tmp_path / "hammer.uff")).write_sets(one)
    for kind, label in ((12, "m/s^2"), (0, "(1/N)*(m/s²)")):
        text = (tmp_path / "hammer.uff").read_bytes().replace(b"m/s^2".ljust(20), label.encode().ljust(20))
        if kind == 0:  # a unit of the whole, as some programs write it
            text = text.replace(b"%10d" % 12 + b" " * 4, b"%10d" % 1 + b" " * 4).replace(b"        13 ", b"         0 ")
            text = text.replace(b"N".ljust(20), b"NONE".ljust(20))
        (tmp_path / "hammer.uff").write_bytes(text)
        measured = ab.measure.load_receptance(tmp_path / "hammer.uff")
        known = -ratio / (2.0 * np.pi * hertz) ** 2
        np.testing.assert_allclose(measured["receptance_real"] + 1j * measured["receptance_imag"], known, rtol=1e-9)


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


def test_files_of_libraries_are_read(tmp_path: Path) -> None:
    h5py, nptdms = pytest.importorskip("h5py"), pytest.importorskip("nptdms")
    with h5py.File(tmp_path / "s.mat", "w", userblock_size=512) as file:
        file["time"], file["x [um]"] = TIME[None], 1e6 * WAVE[None]
    with (tmp_path / "s.mat").open("r+b") as head:
        head.write(b"MATLAB 7.3 MAT-file")
    with h5py.File(tmp_path / "s.h5", "w") as file:
        file["bench/rate"] = 1000.0
        file["bench/x"] = 1e6 * WAVE
        file["bench/x"].attrs["units"] = "um"
    wave = {"wf_increment": 1e-3, "unit_string": "um"}
    with nptdms.TdmsWriter(tmp_path / "s.tdms") as writer:
        writer.write_segment([nptdms.ChannelObject("bench", "x", 1e6 * WAVE, properties=wave)])
    body = rows("X_Value\tx\tComment", "\t", "{:.3f}".format, lambda i: f"{1e6 * WAVE[i]:.9f}", count=0)
    body += "".join(f"{t:.6f}\t{1e6 * x:.9f}\n" for t, x in zip(TIME, WAVE, strict=True))
    head = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t.\nX_Columns\tOne\n***End_of_Header***\t\n\t\n"
    kind = "Channels\t1\t\nSamples\t400\t\nY_Unit_Label\tum\t\nX0\t0.0\t\nDelta_X\t0.001\t\n***End_of_Header***\t\t\n"
    (tmp_path / "s.lvm").write_text(head + kind + body, encoding="utf-8")
    for name in ("s.mat", "s.h5", "s.tdms", "s.lvm"):
        found = ab.measure.load_signals(tmp_path / name)
        assert found["x"].values == pytest.approx(WAVE, abs=1e-11), name
        assert found.attrs["sampling_rate"] == pytest.approx(1000.0)
    assert not (tmp_path / "s.lvm.pkl").exists()


def test_a_missing_library_is_named_with_the_way_to_get_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "nptdms", None)
    (tmp_path / "s.tdms").write_bytes(b"TDSm")
    with pytest.raises(ResultError, match=r'is TDMS; pip install "autobalancer\[signals\]"'):
        ab.measure.load_signals(tmp_path / "s.tdms")


@pytest.mark.parametrize(
    ("start", "words"),
    [
        (b"PAR1", "is Parquet, which is not read; export it as .csv. What is read: tables"),
        (b"\x1f\x8b\x08", "compressed by gzip, .* unpack it first"),
        (b"MDF     4.10", "is MDF"),
        (b"\x93NUMPY\x01", "write .npz"),
        (b"PK\x03\x04", "as of Excel, which is not read; save the table as .csv"),
        (bytes(range(256)), "is no text"),
        (b"\x89HDF\r\n\x1a\n", "cannot be read"),
    ],
)
def test_what_is_no_table_is_named_as_what_it_is(tmp_path: Path, start: bytes, words: str) -> None:
    (tmp_path / "s.csv").write_bytes(start)
    with pytest.raises(ResultError, match=words):
        ab.measure.load_signals(tmp_path / "s.csv")


def test_a_long_table_is_refused_where_its_pieces_do_not_agree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from autobalancer.files import text_files as tables
    from autobalancer.measurement import signal_formats as formats

    monkeypatch.setattr(formats, "LONG_TABLE", 1000)
    monkeypatch.setattr(tables, "PIECE", 4000)
    file, rows = tmp_path / "s.csv", [f"{t:.3f};{x:.6e}" for t, x in zip(TIME, WAVE, strict=True)]
    for changed, words in (
        ("0.390;1;2", "line 392: 3 cells for 2 columns"),
        ("0.390;much", "line 392, column 'x': 'much' is not a number"),
        ("0,390;1e-5", "line 392, column 'time': '0,390' has another decimal mark than numbers above"),
    ):
        file.write_text("\n".join(["time [s];x [m]", *rows[:390], changed, *rows[391:]]))
        with pytest.raises(ResultError, match=words):
            ab.measure.load_signals(file)
    commas = [row.replace(".", ",") for row in rows[300:]]
    file.write_text("\n".join(["time [s];x [m]", *rows[:300], *["# a break"] * 400, *commas]))
    with pytest.raises(ResultError, match="other decimal marks than above"):
        ab.measure.load_signals(file)
    file.write_text("\n".join(["time;x [m]", *(f"10:00:0{row}" for row in rows)]))
    with pytest.raises(ResultError, match="times of day are read in tables up to"):
        ab.measure.load_signals(file)


def test_files_that_would_fill_the_memory_or_never_end_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from scipy.io import savemat

    from autobalancer.measurement import signal_formats as formats

    h5py = pytest.importorskip("h5py")
    monkeypatch.setattr(formats, "HARMLESS", 1_000_000)
    zeros = np.zeros(1_000_000)
    np.savez_compressed(tmp_path / "z.npz", x=zeros)
    savemat(tmp_path / "z.mat", {"x": zeros}, do_compression=True)
    with h5py.File(tmp_path / "z.h5", "w") as file:
        file.create_dataset("x", data=zeros, compression="gzip")
    np.save(tmp_path / "x.npy", np.zeros(100))
    with zipfile.ZipFile(tmp_path / "hollow.npz", "w") as archive:  # an array that claims more than it has
        archive.writestr("x.npy", (tmp_path / "x.npy").read_bytes().replace(b"(100,), }      ", b"(100000000,), }"))
    for name in ("z.npz", "z.mat", "z.h5", "hollow.npz"):
        with pytest.raises(ResultError, match=r"unpacks to \d.* MB or more; at most 100 times the file"):
            ab.measure.load_signals(tmp_path / name)
    os.mkfifo(tmp_path / "pipe")
    for place in (tmp_path / "pipe", Path("/dev/zero")):
        for read in (ab.measure.load_signals, ab.measure.load_receptance, ab.load_run, load_orders):
            with pytest.raises(ResultError, match="is a device or a pipe"):
                read(place)


def test_accelerations_called_ax_and_ay_are_along_x_and_y_with_a_note(tmp_path: Path) -> None:
    rows = "\n".join(f"{k / 100},{k % 7 - 3},{k % 5 - 2},{k % 3 - 1}" for k in range(40))
    (tmp_path / "log.csv").write_text(f"time [s],ax [m/s^2],b_AY [m/s^2],ax2 [m/s^2]\n{rows}\n")
    with pytest.warns(RangeWarning, match="ax is taken to be along x; give its direction if it is not"):
        found = ab.measure.load_signals(tmp_path / "log.csv")
    assert [found[name].attrs["direction"] for name in ("ax", "b_AY", "ax2")] == ["x", "y", ""]


@pytest.mark.parametrize("packed", [False, True])
def test_a_matlab_file_whose_lengths_do_not_fit_is_refused_before_it_is_read_beyond_its_end(
    packed: bool, tmp_path: Path
) -> None:
    """SciPy would end the process."""
    from scipy.io import savemat

    savemat(tmp_path / "whole.mat", {"time": np.arange(50) / 10.0, "a [um]": np.ones(50)}, do_compression=packed)
    content = (tmp_path / "whole.mat").read_bytes()
    if packed:
        size = int.from_bytes(content[132:136], "little")
        inner = zlib.decompress(content[136 : 136 + size])
        wrong = zlib.compress(inner.replace(struct.pack("<II", 9, 400), struct.pack("<II", 9, 4000)))
        damaged = content[:132] + struct.pack("<I", len(wrong)) + wrong + content[136 + size :]
    else:
        damaged = content.replace(struct.pack("<II", 9, 400), struct.pack("<II", 9, 4000), 1)
    (tmp_path / "damaged.mat").write_bytes(damaged)
    with pytest.raises(
        ResultError, match=r"damaged\.mat: cannot be read: the numbers of a variable are cut short or damaged"
    ):
        ab.measure.load_signals(tmp_path / "damaged.mat")


def test_one_column_of_a_long_table_takes_no_room_for_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """The column of time is asked for as a whole, which must not bring all columns into memory."""
    import tracemalloc

    from autobalancer.measurement import signal_formats as formats

    monkeypatch.setattr(formats, "BLOCK", 1000)
    rows = np.arange(600_000.0).reshape(-1, 6)
    columns = formats._stored_columns(Path("long.csv"), [rows])
    tracemalloc.start()
    column = np.asarray(columns[1])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.array_equal(column, rows[:, 1])
    assert peak < 1.5 * column.nbytes

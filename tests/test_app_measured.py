"""Measured data on the page, without a browser: files and their columns, waveforms, drives, fits."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.test_app import unpacked

import autobalancer as ab
from autobalancer.app.form_fields import numbers_of, with_numbers
from autobalancer.app.store.fits import Free, Question, fit, fit_file, fits
from autobalancer.app.store.jobs import Job
from autobalancer.app.store.measured_files import TIME, Measurements, plain_name, samples
from autobalancer.app.store.signal_pictures import BINS, WHOLE, PictureOptions, drive_of, order_table, wave_block
from autobalancer.errors import AutobalancerError, QuestionError

MASS, STIFFNESS, DAMPING, MOMENT = 10.0, 1e5, 100.0, 4e-4  # of the rotor that was measured, SI
ROTOR = """name = "rotor"  # on springs
axis = "vertical"
rotor = { kind = "planar", mass = "10 kg", stiffness = "80 kN/m", damping = "100 N*s/m" }
drive = { kind = "speed", profile = { kind = "constant", speed = "100 rad/s" } }
unbalances = [{ moment = "400 g*mm" }]
run = { duration = "1 s" }
"""


def logger_table() -> bytes:
    """As a German logger writes it: decimal commas, times in ms in a column that is not called time."""
    rows = ["Zeitstempel;Weg X [µm];Puls"]
    for k in range(400):
        t = 0.5 * k
        rows.append(f"{t:.1f};{100.0 * np.sin(0.04 * np.pi * t):.2f};{5.0 * (t % 50.0 < 10.0):.1f}".replace(".", ","))
    return "\n".join(rows).encode("cp1252")


def order_rows() -> bytes:
    """The steady response of the rotor, from its closed form."""
    rows = ["speed [rad/s], place, direction, amplitude [um], phase [deg], amplitude deviation [um]"]
    for speed in np.linspace(60.0, 140.0, 15):
        size = MOMENT * speed**2 / (STIFFNESS - MASS * speed**2 + 1j * DAMPING * speed)
        rows.append(f"{speed:.9g},,x,{1e6 * abs(size):.9g},{np.degrees(np.angle(size)):.9g},1")
    return "\n".join(rows).encode()


def test_columns_are_guessed_and_what_the_heads_do_not_say_is_described(tmp_path: Path) -> None:
    shelf = Measurements(tmp_path)
    name = shelf.add("Messung 1.csv", logger_table())
    reading = shelf.entry(name).reading
    assert [(one.quantity, one.unit, one.direction) for one in reading.columns] == [
        (TIME, "s", ""),
        ("displacement", "µm", "x"),
        ("", "", ""),
    ]
    reading.columns[0].unit, reading.columns[2].quantity = "ms", "tacho"
    shelf.describe(name, reading)
    signals = Measurements(tmp_path).data(name)  # after a restart
    assert float(signals.attrs["sampling_rate"]) == pytest.approx(2000.0)
    assert float(abs(signals["Weg_X"]).max()) == pytest.approx(1e-4, rel=1e-3)
    channels = tomllib.loads(reading.toml())["channels"]
    again = ab.measure.load_signals(shelf.path(name), channels)  # the file of channels is that of the command line
    assert np.array_equal(again["Weg_X"], signals["Weg_X"])
    reading.columns[1].unit = "furlong"
    shelf.describe(name, reading)
    with pytest.raises(QuestionError, match="Weg_X"):
        shelf.data(name)
    shelf.delete(name)
    assert shelf.entries() == []


@pytest.mark.parametrize(
    ("file", "content", "words"),
    [
        ("a.csv", b"time [s],x [um]\n0,1\n1,abc\n", "a.csv, line 3, column 'x': 'abc' is not a number"),
        ("b.mat", b"MATLAB", "b.mat: cannot be read"),
        ("c.nc", b"netCDF", "c.nc: not a readable result file"),
        ("d.wav", b"RIFF", "d.wav: cannot be read"),
        ("e.exe", b"MZ", "is none of these files"),
        ("f.uff", b"    -1\n", "no dataset 58"),
    ],
)
def test_a_bad_file_is_refused_in_the_words_of_its_reader_and_nothing_stays(
    file: str, content: bytes, words: str, tmp_path: Path
) -> None:
    with pytest.raises(AutobalancerError, match=words.replace(".", r"\.")) as said:
        Measurements(tmp_path).add(file, content)
    assert str(tmp_path) not in str(said.value)
    assert not list((tmp_path / "measured").glob("*"))


def test_no_name_of_a_file_or_a_measurement_leaves_its_folder(tmp_path: Path) -> None:
    assert plain_name("../../etc/a b;c\0.CSV") == "a b_c_.csv"
    for name in ("a.h5", "a.tdms", "a.lvm"):  # whatever ab.measure.load_signals reads
        assert plain_name(name) == name
    assert Measurements.keep_file(tmp_path / "files", "../K.mtx", b"1 1 5") == "K.mtx"
    with pytest.raises(QuestionError, match=r"a\.exe': is none of these files; they end in \.csv, \.dat"):
        Measurements.keep_file(tmp_path, "a.exe", b"")
    with pytest.raises(QuestionError, match=r"K\.mtx: has 24\.0 MB; at most 24 MB are taken"):
        Measurements.keep_file(tmp_path, "K.mtx", bytes(24_000_001))
    for name in ("..", "../x", "", "20261123-012345-zzzzzz", "a\0b"):
        with pytest.raises(QuestionError):
            Measurements(tmp_path).path(name)


def test_the_samples_are_those_that_can_be_looked_at(tmp_path: Path) -> None:
    assert {"run_up_signals", "decay_signals", "run_down_orders"} <= set(samples())
    assert "race_profile" not in samples()
    shelf = Measurements(tmp_path)
    table = shelf.data(shelf.add_sample("run_down_orders"))
    assert len(order_table(table)().axes) == 2


def test_waveforms_of_many_samples_keep_their_peaks(tmp_path: Path) -> None:
    time = np.arange(2 * WHOLE) / 1e4
    values = 1e-5 * np.sin(3.0 * time)
    values[33_333] = 7e-4
    signals = ab.measure.signals(time, {"x": ab.measure.Channel(values, "displacement")})
    head, array = unpacked(wave_block(signals))
    line = head["panels"][0]["lines"][0]
    assert array(line["high"]).size <= BINS
    assert array(line["high"]).max() == pytest.approx(700.0)  # um
    assert array(line["t"])[array(line["high"]).argmax()] == pytest.approx(3.3333, abs=1e-3)


def test_the_measured_turning_becomes_the_drive() -> None:
    time = np.linspace(0.3, 4.3, 4001)
    turned = 0.4 + 20.0 * time + 6.0 * time**2
    signals = ab.measure.signals(time, {"angle": ab.measure.Channel(turned, "angle")})
    profile, begin = drive_of(signals, PictureOptions())
    knots = [float(text.split()[0]) for text in profile["time"]]
    speeds = [float(text.split()[0]) for text in profile["speed"]]
    speed = np.interp(time, knots, speeds)
    angle = np.radians(float(begin.split()[0])) + speeds[0] * time[0]
    angle = angle + np.concatenate([[0.0], np.cumsum(0.5 * np.diff(time) * (speed[1:] + speed[:-1]))])
    away = (angle - turned + np.pi) % (2.0 * np.pi) - np.pi
    assert np.abs(away).max() < 0.01


def test_a_fit_finds_the_stiffness_and_puts_it_into_the_text(tmp_path: Path) -> None:
    shelf, job = Measurements(tmp_path), Job(1, "ada", "fit", 60.0)
    job.begun = float("inf")
    name = shelf.add("orders.csv", order_rows())
    question = Question(
        [Free("rotor.stiffness", "50 kN/m", "200 kN/m"), Free("unbalances[1].moment", "1 g*mm", "1 kg*mm")]
    )
    found = fit(shelf, name, ROTOR, question, PictureOptions(), job)
    (entry,) = fits(Measurements(tmp_path), name).entries()  # after a restart
    row = next(row for row in entry.rows if row["path"] == "rotor.stiffness")
    assert row["low"] <= STIFFNESS * (1.0 + 1e-5)
    assert row["high"] >= STIFFNESS * (1.0 - 1e-5)
    assert row["value"] == pytest.approx(STIFFNESS, rel=1e-4)
    fitted: Any = ab.load_machine(fit_file(shelf, name, found, "fitted.toml"))
    text = with_numbers(ROTOR, fitted, [one["path"] for one in entry.rows])
    assert text.startswith('name = "rotor"  # on springs')
    assert [float(number.number) for number in numbers_of(text, fitted)][1] == pytest.approx(100.0, rel=1e-4)  # kN/m
    other = ROTOR.replace("100 N*s/m", "50 N*s/m")  # not the machine that was fitted
    assert ab.parse_machine(with_numbers(other, fitted, ["rotor.stiffness"])).rotor.damping == DAMPING


class Ending(Job):
    """A job that somebody cancels at its sixth trial."""

    def progress(self, done: float, total: float) -> None:
        self.share += 1.0
        if self.share > 5.0:
            raise KeyboardInterrupt


def test_a_cancelled_fit_keeps_its_best_machine(tmp_path: Path) -> None:
    shelf = Measurements(tmp_path)
    name = shelf.add("orders.csv", order_rows())
    question = Question([Free("rotor.stiffness", "50 kN/m", "200 kN/m")])
    fit(shelf, name, ROTOR, question, PictureOptions(), Ending(1, "ada", "fit", 60.0))
    (entry,) = fits(shelf, name).entries()
    assert not entry.finished
    assert "cancelled after 5 trials" in entry.notes[0]
    assert abs(entry.rows[0]["value"] - STIFFNESS) <= abs(8e4 - STIFFNESS)

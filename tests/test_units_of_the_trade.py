"""Units as German, British and American engineers, standards, loggers and data sheets write them, in every door."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pint
import pytest
from typer.testing import CliRunner

from autobalancer.app.form_fields import in_unit, number_and_unit, written
from autobalancer.app.store.measured_files import guessed
from autobalancer.cli import app
from autobalancer.errors import AutobalancerError, QuestionError, UnitError
from autobalancer.files.machine_file import parse_machine
from autobalancer.files.text_files import read_table
from autobalancer.machine.part import Quantity
from autobalancer.measure import BalanceRun, Reading, TrialMass, balance, load_signals
from autobalancer.measurement.signal_formats import RawColumn, RawFile
from autobalancer.measurement.signals import factor_to, hertz_argument, quantity_of
from autobalancer.results.signals import universal_text
from autobalancer.units import argument, from_si, option_to_si, to_si
from autobalancer.units.quantity import ends, range_values, read_text
from autobalancer.units.trade import JOINED, meanings, table

TURN, MIL, INCH, G0, POUND = math.tau, 25.4e-6, 25.4e-3, 9.80665, 0.45359237
RPM, DEG, LBF = TURN / 60.0, math.tau / 360.0, POUND * G0
SPEED, GROWTH, SWING = "rad/s", "1/s", "rad/s^2"
READ_AS: dict[
    tuple[str, float], str
] = {  # the quantity that is wanted and how many SI units one is: units as they are written
    (
        SPEED,
        RPM,
    ): "1/min, min^-1, min-1, min⁻¹, /min, min**-1, r/min, rev/min, U/min, Umdr./min, Upm, RPM, rpm, r.p.m., Rpm, cpm, "
    "cycles/min, revolutions per minute, turn/min, U·min⁻¹",
    (SPEED, TURN): "Hz, rps, rev/s, U/s, r/s, turn/s, cps, hz",
    (SPEED, 1.0): "rad/s, rad/sec, rad s-1, rad·s⁻¹, radians/s",
    (SPEED, DEG): "deg/s, °/s, Grad/s",
    (SPEED, 1e3 * RPM): "krpm",
    (SPEED, 1e3 * TURN): "kHz",
    (SWING, RPM): "rpm/s, 1/min/s, min^-1/s, min⁻¹·s⁻¹, 1/(min s), RPM/sec",
    (SWING, TURN): "Hz/s, rev/s^2, U/s²",
    (SWING, 1.0): "rad/s², rad/s^2",
    (SWING, TURN / 3600.0): "1/min², rpm/min",
    (GROWTH, 1.0): "1/s, s^-1",
    (GROWTH, 1.0 / 60.0): "1/min",
    (GROWTH, 1e3): "1/ms",
    ("rad", DEG): "°, deg, Grad, degree, degrees, Deg",
    ("rad", TURN / 400.0): "gon, gradian",
    ("rad", 1e-3): "mrad",
    ("rad", TURN): "turn, rev, U",
    ("m", MIL): "mil, mils, thou, MIL",
    ("m", 1e-6): "um, µm, μm, micrometer",
    ("m", INCH): "in, inch, Zoll",
    ("m", 0.3048): "ft",
    ("m", 1e-3): "mm",
    ("m/s", INCH): "ips, in/s, inch/sec, IPS",
    ("m/s", 1e-3): "mm/s, mm s⁻¹",
    ("m/s^2", 1.0): "m/s2, m/s², m/s^2, m/s/s, m·s⁻², m s-2",
    ("m/s^2", G0): "g, G, g_0, gn",
    ("m/s^2", 1e-3 * G0): "mg",
    ("m/s^2", INCH): "in/s²",
    ("kg", 1.0): "kg, Kg, KG",
    ("kg", POUND): "lb, lbs, lbm",
    ("kg", 1e-3): "g",
    ("kg", 1e-6): "mg",
    ("kg", POUND / 16.0): "oz",
    ("kg", 1e3): "t",
    ("kg", 14.0 * POUND): "stone",
    ("kg*m", 1e-6): "gmm, g mm, g·mm, g*mm, g-mm, g.mm",
    ("kg*m", 1e-5): "gcm",
    ("kg*m", 1e-3): "kgmm",
    ("kg*m", 1.0): "kgm",
    ("kg*m", 1e-3 * INCH): "g-in",
    ("kg*m", POUND / 16.0 * INCH): "oz-in, oz in, in-oz, ozin",
    ("kg*m^2", 1.0): "kgm², kg m^2, kg·m², kg.m2",
    ("kg*m^2", 1e-7): "gcm²",
    ("kg*m^2", 1e-6): "kgmm²",
    ("kg*m^2", 1e-4): "kg cm²",
    ("kg*m^2", POUND * INCH**2): "lb-in²",
    ("kg*m^2", LBF * INCH): "lb-in-s^2",
    ("N/m", 1e3): "kN/m, KN/m, N/mm",
    ("N/m", LBF / INCH): "lb/in, lbf/in",
    ("N*s/m", 1.0): "Ns/m, N*s/m, N s/m, N·s·m⁻¹, kg/s",
    ("N*s/m", LBF / INCH): "lb-s/in",
    ("N*m", 1.0): "Nm, N m, N·m, N-m, N.m",
    ("N*m", 1e-2): "Ncm",
    ("N*m", 1e-3): "mNm",
    ("N*m", 12.0 * LBF * INCH): "ft-lb, lbf·ft",
    ("N*m", LBF * INCH): "in-lbf",
    ("N*m*s", 1.0): "Nms, Nms/rad",
    ("N*m*s/rad", 1.0): "N*m*s",
    ("N*m/rad", 1.0): "Nm/rad",
    ("N*m/rad", 1.0 / DEG): "Nm/°",
    ("N", LBF): "lbf",
    ("N", G0): "kp, kgf",
    ("Pa", 1e6): "MPa, N/mm², Mpa",
    ("Pa", LBF / INCH**2): "psi",
    ("Pa", 1e5): "bar",
    ("Pa*s", 1e-3): "mPas, cP, mPa·s",
    ("m^2/s", 1e-6): "cSt, mm²/s",
    ("kg/m^3", 1e3): "g/cm³, kg/l",
    ("kg/m^3", POUND / INCH**3): "lb/in^3",
    ("", 1e-2): "%",
    ("s", 1.0): "sec, s",
    ("s", 60.0): "min",
    ("V/(m/s^2)", 1e-3 / G0): "mV/g, mV/g_0, mV/G",
    ("V/(m/s^2)", 1e-3): "mV/(m/s²), mV/m/s²",
    ("V/(m)", 1e-3 / MIL): "mV/mil",
    ("V/(m)", 1.0 / MIL): "V/mil",
    ("V/(m)", 1e3): "mV/µm",
    ("V/(m/s)", 1.0): "mV/(mm/s), mV/mm/s, V/(m/s)",
    ("V/(m/s)", 1e-3 / INCH): "mV/ips, mV/in/s",
    ("V/(rad/s)", 1e-3 / RPM): "mV/rpm, mV*min",
}
REFUSED_AS: dict[
    tuple[str, str], str
] = {  # the quantity that is wanted and what the message says: units as they are written
    (SPEED, r"turns or radians a second\? Write Hz \(or rps\) for turns, rad/s for radians"): "1/s, s^-1, s⁻¹, 1/h",
    (SWING, r"turns or radians a second\? Write Hz/s \(or rpm/s\)"): "1/s^2, s⁻²",
    (GROWTH, "a quantity in 1/s is wanted"): "rad/s, Hz, rpm",
    ("", "a number without a unit is wanted"): "deg, rad, turn, 1/min",
    ("rad", "a quantity in rad is wanted"): "%, 1/min, mil, mm/m",
    ("rad", "write deg or gon"): "grad",
    ("rad", "did you mean mrad"): "Mrad",
    ("rad", "is not a unit"): "Grads",
    ("m", "a quantity in m is wanted"): "deg, Grad, lb, 1/min",
    ("m", "did you mean mm"): "Mm, MM",
    ("m", "is not a unit"): "picopoint, pp, m^10, m^(1/0), (m, m), ^2, m^2^2",
    ("m", "no peak to peak value|is a peak to peak value"): "mil pp, um pk-pk, µm p-p, mil peak-to-peak, µm SS",
    ("m", "no peak value|is a peak value"): "um 0-pk, mil pk, mm peak",
    ("m/s", "no rms value|is a rms value"): "mm/s rms, mm/s RMS, ips rms, mm/s eff.",
    ("kg", "did you mean kg"): "kgg",
    ("kg", "write g, or mg"): "gr",
    ("s", "did you mean ms"): "Ms",
    ("K", "a temperature is written degC"): "C",
    ("Pa", "mPa or MPa"): "mpa",
    ("N/m", "did you mean kgf/mm"): "kg/mm",
    ("N*m", "did you mean Nm"): "nm",
    ("N*m", r"a quantity in N\*m is wanted"): "Nm/rad",
    ("N*m/rad", "did you mean Nm/rad"): "Nm",
    ("kg*m", "a mass, not a force, times a radius: divide a static moment by 9.80665"): "Nm, N*m, Nmm, lbf*in",
    ("kg*m", "over the square of the speed"): "N, kN",
    ("kg*m", "with its radius"): "g, kg",
    ("kg*m", "balance quality grade"): "mm/s",
    ("kg", "a weight over 9.80665"): "N, lbf",
    ("m^2/s", "a dynamic viscosity over the density"): "mPa*s, cP, mPas",
    ("Pa*s", "a kinematic viscosity times the density"): "cSt, mm^2/s",
    ("N/m", "not a moment over an angle"): "Nm/rad",
    ("N*s/m", "a damping ratio D of a mass"): "%",
    ("rad/s", "a circumferential speed over the radius"): "m/s",
    ("rad/s^2", "how the speed rises in a time"): "rpm",
    ("s", "1 over the frequency"): "Hz",
    ("V/(m/s^2)", "behind the charge amplifier"): "pC/g",
}
READ = [(unit, wanted, si) for (wanted, si), units in READ_AS.items() for unit in units.split(", ")]
REFUSED = [(unit, wanted, words) for (wanted, words), units in REFUSED_AS.items() for unit in units.split(", ")]


def of_a_column(unit: str, wanted: str) -> float:
    with TemporaryDirectory() as folder:
        path = Path(folder) / "a.csv"
        path.write_text(f"number;amount [{unit}]\n1;3\n", encoding="utf-8")
        return float(read_table(path, "").numbers("amount", wanted)[0])


def of_the_form(unit: str, wanted: str) -> float:
    """A field of the page with its box of units, which writes a text into the file."""
    number, chosen = number_and_unit(f"3 {unit}", wanted) or ("", "")
    in_si = in_unit(number, chosen, wanted, wanted)
    text = written(number, chosen, wanted)
    found = float(to_si(text, wanted))
    assert float(in_si) == pytest.approx(found, rel=1e-9)
    return found


DOORS: dict[str, Callable[[str, str], float]] = {
    "machine file": lambda unit, wanted: float(Quantity(wanted)(f"3 {unit}")),
    "command line": lambda unit, wanted: float(option_to_si(f"3 {unit}", wanted)),
    "range": lambda unit, wanted: float(range_values("--range", f"1:5 {unit}:3", wanted)[1]),
    "ends of a range": lambda unit, wanted: ends("--range", f"3:4 {unit}", wanted)[0],
    "head of a table": of_a_column,
    "label of a channel": lambda unit, wanted: 3.0 * factor_to(unit, wanted or "1"),
    "form of the page": of_the_form,
    "argument of a function": lambda unit, wanted: argument("size", f"3 {unit}", wanted),
}


@pytest.mark.parametrize("door", DOORS)
def test_each_door_reads_every_unit_alike_and_refuses_the_same(door: str) -> None:
    for unit, wanted, si in READ:
        found = DOORS[door](unit, wanted)
        assert found == pytest.approx(3.0 * si, rel=1e-9), (unit, wanted)
        assert from_si(found, wanted, unit) == pytest.approx(3.0, rel=1e-9), (unit, wanted)
    for unit, wanted, words in REFUSED:
        try:
            found = DOORS[door](unit, wanted)
        except AutobalancerError as reason:
            assert re.search(words, str(reason)), (unit, wanted, str(reason))  # noqa: PT017
        else:
            pytest.fail(f"{unit!r} was read as {found / 3.0:g} {wanted}")


def test_the_table_is_that_of_a_trade() -> None:
    assert len(READ) + len(REFUSED) > 150
    assert len({row[:2] for row in (*READ, *REFUSED)}) == len(READ) + len(REFUSED)


def test_words_are_those_of_pint_but_for_those_that_it_takes_for_something_else() -> None:
    registry, bases = (
        pint.UnitRegistry(cache_folder=None),
        ("meter", "kilogram", "second", "ampere", "kelvin", "radian"),
    )
    unlike = set()
    for name, meaning in table().items():
        if not name.isidentifier() or name == "dimensionless":
            continue
        try:
            size, roots = registry.get_base_units(name)
        except pint.errors.UndefinedUnitError:
            continue
        exponents = tuple(dict(roots._units).get(base, 0.0) for base in bases)
        if exponents != meaning.dimension or size != pytest.approx(meaning.factor, rel=1e-12):
            unlike.add(name)
    assert {name for name in unlike if "Hz" not in name and "hertz" not in name} == {
        "mil",
        "mils",
        "Grad",
        "U",
        "cps",
        "G",
    }
    assert not set(JOINED) & set(table())


def test_grouped_numbers_and_decimal_commas_are_answered_with_what_is_read() -> None:
    for text, *better in (
        ("1,000,000 N/m", "1000000 N/m"), ("1.000.000 N/m", "1000000 N/m"), ("1 000 000 N/m", "1000000 N/m"),
        ("1'000 N/m", "1000 N/m"), ("1\u202f000 N/m", "1000 N/m"), ("4,500.5 N/m", "4500.5 N/m"), ("4.500,5 N/m", "4500.5 N/m"),
        ("12,5 N/m", "12.5 N/m"), ("1,234 N/m", "1.234 N/m", "1234 N/m"), ("12,5e3 N/m", "12.5e3 N/m"),
    ):  # fmt: skip
        with pytest.raises(UnitError) as reason:
            to_si(text, "N/m")
        offered = [to_si(one, "N/m") for one in re.findall(r"'([^']*)'", str(reason.value).split(";", 1)[1])]
        assert offered == [to_si(one, "N/m") for one in better], str(reason.value)
    for text in ("3,4,5 N/m", "3 kg 4", "3 N/m 5 N/m"):
        with pytest.raises(UnitError, match="one quantity is wanted here"):
            to_si(text, "N/m")
    assert to_si("0", "rad") == 0.0 == option_to_si("0", "rad")
    for text, unit in (("30", "rad"), ("0", "K")):
        with pytest.raises(UnitError, match="without a unit"):
            to_si(text, unit)
        with pytest.raises(UnitError, match="without a unit"):
            option_to_si(text, unit)


@pytest.mark.parametrize(
    ("suffix", "peaks"),
    [*((one, 0.5) for one in ("pp", "p-p", "pk-pk", "peak to peak", "peak-to-peak", "SS", "(pp)")), ("pk", 1.0), ("peak", 1.0),
     ("0-pk", 1.0), ("rms", math.sqrt(2.0)), ("RMS", math.sqrt(2.0)), ("eff", math.sqrt(2.0))],
)  # fmt: skip
def test_of_an_amplitude_the_kind_of_its_value_is_understood(tmp_path: Path, suffix: str, peaks: float) -> None:
    assert read_text(f"4 mil {suffix}", "m", True) == pytest.approx(4.0 * MIL * peaks, rel=1e-12)
    assert Reading(f"4 mil {suffix}", "10 deg").amplitude == pytest.approx(4.0 * MIL * peaks, rel=1e-12)
    path = tmp_path / "curve.csv"
    path.write_text(f"speed [1/min],amplitude [mil {suffix}]\n600,4\n", encoding="utf-8")
    amplitude = read_table(path, "").numbers("amplitude", "m")
    assert amplitude == pytest.approx(4.0 * MIL * peaks, rel=1e-12)
    assert quantity_of("x", f"mil {suffix}") == "displacement"  # a waveform, whose unit is then refused by name


def test_a_job_in_mils_asks_for_the_same_masses_as_one_in_millimeters() -> None:
    def job(first: str, second: str) -> list[BalanceRun]:
        trial = TrialMass("P1", "100 g", "0 deg")
        return [
            BalanceRun("original", [Reading(first, "160 deg")]),
            BalanceRun("t", [Reading(second, "70 deg")], [trial]),
        ]

    wanted = balance(job("0.1778 mm", "0.127 mm"))
    for first, second in (("7 mil", "5 mil"), ("7 mils pp", "5 thou p-p"), ("7 mil pp", "2.5 mil pk")):
        found = balance(job(first, second))
        assert found["correction"].values == pytest.approx(wanted["correction"].values, rel=1e-9)
    with pytest.raises(QuestionError, match="amplitude: 'fathomx' is not a unit"):
        Reading("3 fathomx", "0 deg")
    with pytest.raises(QuestionError, match="give a number with a unit, one of m, m/s"):
        Reading("3 kg", "0 deg")


def test_a_machine_file_says_its_speed_as_the_drawing_does() -> None:
    text = """
    name = "Schleuder mit Kugeln"
    axis = "vertical"
    rotor = { kind = "planar", mass = "10 Kg", stiffness = "625 N/mm", damping = "0.1 Ns/mm" }
    drive = { kind = "speed", profile = { kind = "ramp", end = "SPEED", duration = "15 s" } }
    unbalances = [{ moment = "400 gmm", angle = "90 Grad" }]
    """
    for speed in ("4800 min^-1", "4800 1/min", "4800 U/min", "80 Hz", "80 rps"):
        machine = parse_machine(text.replace("SPEED", speed))
        assert machine.drive.profile.end == pytest.approx(80.0 * TURN, rel=1e-12)
    assert (machine.rotor.mass, machine.rotor.stiffness, machine.rotor.damping) == (10.0, 625e3, 100.0)
    assert machine.unbalances[0].vector == pytest.approx(4e-4j)
    with pytest.raises(AutobalancerError, match=r"drive\.profile\.end: given '80 1/s'; turns or radians a second\?"):
        parse_machine(text.replace("SPEED", "80 1/s"))


def test_the_command_line_takes_the_words_of_the_trade() -> None:
    command = ["measure", "trial-mass", "--radius", "4 in", "--speed", "3000 U/min", "--rotor-mass", "20 Kg", "--json"]
    for grade in ("G 2.5", "2.5", "G2.5", "2.5 mm/s"):
        found = json.loads(CliRunner().invoke(app, [*command, "--grade", grade]).stdout)
        assert found["unbalance"] == pytest.approx(5.0 * 2.5e-3 * 20.0 / (50.0 * TURN), rel=1e-9)
        assert found["radius"] == pytest.approx(4.0 * INCH)
    answer = CliRunner().invoke(app, [*command[:5], "50 1/s", *command[6:]])
    assert answer.exit_code == 2
    assert "--speed: given '50 1/s'; turns or radians a second?" in " ".join(answer.stderr.split())


def test_channels_of_a_logger_come_in_the_units_of_its_sensors(tmp_path: Path) -> None:
    time = np.arange(64) / 1000.0
    wave = np.sin(TURN * 20.0 * time)
    path = tmp_path / "logger.csv"
    rows = "\n".join(
        f"{t:.3f};{1500};{x:.9f};{x:.9f};{x:.9f}".replace(".", ",") for t, x in zip(time, wave, strict=True)
    )
    path.write_text(f"time [s];Drehzahl [1/min];probe [V];a [V];v [mils]\n{rows}\n", encoding="utf-8")
    sensors = {
        "n": {"column": "Drehzahl"},
        "x": {"column": "probe", "quantity": "displacement", "sensitivity": "200 mV/mil", "uncertainty": "0.1 mil"},
        "a": {"quantity": "acceleration", "sensitivity": "100 mV/g"},
        "v": {"column": "v"},
    }
    found = load_signals(path, sensors, implausible=True)
    assert found["n"].values == pytest.approx(1500.0 * RPM)
    assert found["x"].values == pytest.approx(wave * 5.0 * MIL, abs=1e-12)
    assert found["x"].attrs["uncertainty"] == pytest.approx(0.1 * MIL)
    assert found["a"].values == pytest.approx(wave * 10.0 * G0, abs=1e-6)
    assert found["v"].values == pytest.approx(wave * MIL, abs=1e-12)
    with pytest.raises(AutobalancerError, match="'mils pp' is a peak to peak value"):
        load_signals(path, {"v": {"quantity": "displacement", "unit": "mils pp"}})
    with pytest.raises(AutobalancerError, match="turns or radians a second"):
        load_signals(path, {"v": {"unit": "1/s"}})
    uff = tmp_path / "logger.uff"
    record = found[["v"]].assign(v=found["v"].copy(data=wave).assign_attrs(units="mil"))
    uff.write_text(universal_text(record).replace("autobalancer displacement", "NONE" + " " * 21), encoding="latin-1")
    (name,) = load_signals(uff).data_vars
    assert load_signals(uff)[name].values == pytest.approx(wave * MIL, abs=1e-12)


def test_the_page_sees_what_a_column_is_from_the_word_for_its_unit() -> None:
    units = {"1/min": "speed", "min^-1": "speed", "1/s": "speed", "mil": "displacement", "mil pp": "displacement"}
    units |= {
        "Grad": "angle",
        "ips": "velocity",
        "g": "acceleration",
        "V": "voltage",
        "kg": "",
        "nonsense": "",
        "%": "",
        "s": "",
    }
    columns = {unit: RawColumn(np.linspace(5.0, 1.0, 9), unit) for unit in units}
    assert {
        one.column: one.quantity for one in guessed(RawFile("a.csv", np.arange(9.0), None, columns)).columns
    } == units


def test_a_rate_of_samples_may_be_in_hertz_or_per_second() -> None:
    for text in ("2 kHz", "2000 Hz", "2000 1/s", "120000 1/min", "2000 s^-1"):
        assert hertz_argument("rate", text) == pytest.approx(2000.0)


def test_a_word_that_is_not_of_the_trade_has_no_meaning_with_any_prefix() -> None:
    for word in ("point", "Grad", "mil", "rpm", "bar", "turn", "deg", "min", "ips", "lb", "ft", "g_0"):
        for prefix in ("p", "T", "h", "da", "E", "y", "Gi", "kilo", "giga"):
            with pytest.raises(UnitError, match="is not a unit"):
                meanings(prefix + word)

"""The words of the trade: every unit that is read, what it is in SI, which prefixes it may have, and products of them.

An angle is a dimension here, so that a turn never becomes a radian and an angle never a pure number. Only the prefixes that
people use stand before a word, so that no compound is made up: ``Grad`` is a degree, not giga-rad. A full name that is not in
the table, such as ``stone``, is looked up in Pint; that library is loaded for nothing else.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable
from difflib import get_close_matches
from functools import cache, lru_cache
from typing import Any, NamedTuple

from autobalancer.errors import UnitError

TURN = 2.0 * math.pi
GRAVITY = 9.80665  # m/s^2, standard
POUND, INCH = 0.45359237, 0.0254
HIGHEST = 10.0  # exponent of a base unit
BASE = ("m", "kg", "s", "A", "K", "rad")
PREFIXES = {"n": 1e-9, "u": 1e-6, "m": 1e-3, "c": 1e-2, "d": 1e-1, "k": 1e3, "M": 1e6, "G": 1e9}
LONG = {"nano": "n", "micro": "u", "milli": "m", "centi": "c", "kilo": "k", "mega": "M", "giga": "G"}
# spellings, the first of which has the prefixes; value; of what; prefixes
WORDS: dict[str, tuple[tuple[str, float, str, str], ...]] = {
    "length": (
        ("m", 1.0, "m", "n u m c d k"),
        ("in inch inches Zoll", INCH, "m", ""),
        ("mil mils thou", 1e-3 * INCH, "m", ""),
        ("ft foot feet", 12.0 * INCH, "m", ""),
    ),
    "angle": (
        ("rad radian radians", 1.0, "rad", "u m"),
        ("deg degree degrees Grad", TURN / 360.0, "rad", ""),
        ("arcmin", TURN / 21600.0, "rad", ""),
        ("arcsec", TURN / 1296000.0, "rad", ""),
        ("gon gradian gradians", TURN / 400.0, "rad", "m"),
        ("rev revs r revolution revolutions turn turns rot rotation rotations U Umdr cycle cycles", TURN, "rad", ""),
    ),
    "time": (
        ("s sec secs Sek", 1.0, "s", "n u m"),
        ("min mins minute minutes", 60.0, "s", ""),
        ("h hr hour hours", 3600.0, "s", ""),
        ("d day days", 86400.0, "s", ""),
    ),
    "speed, frequency": (
        ("rpm RPM Rpm cpm CPM Upm UpM UPM", TURN / 60.0, "rad/s", "k"),
        ("rps RPS cps", TURN, "rad/s", ""),
        ("Hz", TURN, "rad/s", "m k M"),
    ),
    "mass": (
        ("g gram grams", 1e-3, "kg", "u m k"),
        ("t tonne tonnes", 1e3, "kg", ""),
        ("lb lbs lbm", POUND, "kg", ""),
        ("oz ounce ounces", POUND / 16.0, "kg", ""),
        ("slug slugs", POUND * GRAVITY / (12.0 * INCH), "kg", ""),
    ),
    "velocity": (("ips IPS", INCH, "m/s", ""),),
    "acceleration": (("gn g_0 g_n G", GRAVITY, "m/s^2", "u m"), ("Gal", 1e-2, "m/s^2", "m")),
    "force": (
        ("N", 1.0, "kg*m/s^2", "u m k M"),
        ("lbf", POUND * GRAVITY, "kg*m/s^2", ""),
        ("ozf", POUND * GRAVITY / 16.0, "kg*m/s^2", ""),
        ("kgf kp", GRAVITY, "kg*m/s^2", ""),
        ("gf", 1e-3 * GRAVITY, "kg*m/s^2", ""),
    ),
    "pressure": (
        ("Pa", 1.0, "N/m^2", "m k M G"),
        ("bar", 1e5, "N/m^2", "m"),
        ("psi", POUND * GRAVITY / INCH**2, "N/m^2", ""),
        ("ksi", 1e3 * POUND * GRAVITY / INCH**2, "N/m^2", ""),
    ),
    "viscosity": (("St", 1e-4, "m^2/s", "c"), ("P", 0.1, "N*s/m^2", "c")),
    "volume": (("l L liter litre", 1e-3, "m^3", "m"), ("cc ccm", 1e-6, "m^3", "")),
    "energy, power": (("J", 1.0, "N*m", "u m k"), ("W", 1.0, "N*m/s", "m k")),
    "electricity": (("V", 1.0, "W/A", "u m k"), ("A", 1.0, "A", "u m"), ("T", 1.0, "N/(A*m)", "m")),
    "temperature": (
        ("K", 1.0, "K", "m"),
        ("degC celsius Celsius", 1.0, "K", ""),
        ("degF fahrenheit Fahrenheit", 5.0 / 9.0, "K", ""),
    ),
    "share": (("%", 1e-2, "", ""), ("‰", 1e-3, "", ""), ("ppm", 1e-6, "", ""), ("dimensionless", 1.0, "", "")),
}
ADDED = dict.fromkeys(("degC", "celsius", "Celsius"), 273.15)
ADDED |= dict.fromkeys(("degF", "fahrenheit", "Fahrenheit"), 273.15 - 32.0 * 5.0 / 9.0)  # after the factor
# words with a second meaning, which counts where only this one has the dimension that is wanted
SECOND = ({"g": "gn", "mg": "mgn", "ug": "ugn"}, {"lb": "lbf", "lbs": "lbf", "oz": "ozf"})
JOINED = {  # products that are written as one word; an exponent belongs to the last part
    "".join(parts): parts
    for parts in (
        *itertools.product(("g", "mg", "kg"), ("mm", "cm")),
        *itertools.product(("kg", "N", "mN", "kN", "MN"), ("m",)),
        *itertools.product(("N", "kN"), ("mm", "cm", "s")),
        *itertools.product(("N", "mN", "kN"), ("m",), ("s",)),
        *itertools.product(("N",), ("mm", "cm"), ("s",)),
        *itertools.product(("Pa", "mPa"), ("s",)),
        *itertools.product(("A", "mA"), ("m", "s")),
        ("oz", "in"),
    )
}
CASES = {  # a capital or small letter too many, and yet clear
    "Kg": "kg", "KG": "kg", "Km": "km", "KN": "kN", "KNm": "kNm", "Kgm": "kgm", "Kgmm": "kgmm", "KHz": "kHz", "Khz": "kHz",
    "khz": "kHz", "hz": "Hz", "HZ": "Hz", "KPa": "kPa", "Kpa": "kPa", "Mpa": "MPa", "Gpa": "GPa", "Sec": "s", "SEC": "s",
    "Min": "min", "Mil": "mil", "MIL": "mil", "Mils": "mil", "Rad": "rad", "RAD": "rad", "Deg": "deg", "DEG": "deg",
    "KRPM": "krpm", "kRPM": "krpm",
}  # fmt: skip
AMBIGUOUS = {
    "grad": "'grad' is a degree to some and a gon to others; write deg or gon",
    "gr": "'gr' is a gram to some and a grain to others; write g, or mg",
    "C": "'C' is a coulomb; a temperature is written degC",
    "pC": "'pC' is a charge; give the voltage behind the charge amplifier, such as mV/g",
}
SUFFIXES = {  # behind an amplitude: what makes the peak of a sinusoid of it
    "peak to peak": (0.5, r"pk[-/ ]?pk|p[-/]?p|ptp|p2p|peak[- ](?:to[- ])?peak|S-?S|Spitze-Spitze"),
    "peak": (1.0, r"0[-/ ]?pk|0[-/]?p|z-?p|pk|peak"),
    "rms": (math.sqrt(2.0), r"rms|RMS|eff|Eff"),
}
_SUFFIX = re.compile(
    r"(.+?)[\s_,]*[(\[]?\s*(?:" + "|".join(f"({form})" for _, form in SUFFIXES.values()) + r")\.?\s*[)\]]?\s*"
)
_CHARACTERS = str.maketrans({"µ": "u", "μ": "u", "·": "*", "×": "*", "⋅": "*", "∙": "*", "•": "*", "−": "-", "–": "-",
                             "⁄": "/", "\xa0": " ", "\u2009": " ", "\u202f": " "})  # fmt: skip
_RAISED = str.maketrans("⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹", "-+0123456789")
_PLAIN: tuple[tuple[str, Any], ...] = (
    ("[⁻⁺⁰¹²³⁴⁵⁶⁷⁸⁹]+", lambda found: "^" + found[0].translate(_RAISED)),
    (r"(?:℃|(?:°|\b[Gg]rad\b|\bdeg\b)\s*(?:C|Celsius)\b)", "degC"),
    (r"(?:℉|(?:°|\bdeg\b)\s*F\b)", "degF"),
    (r"°", "deg"),
    (r"\br\.p\.m\.?(?![A-Za-z])", "rpm"),
    (r"\bg_?[0n]\b", "gn"),
    (r"\s+per\s+", "/"),
    (r"\*\*", "^"),
    (r"^\s*/", "1/"),
)
_EXPONENT = r"[+-]?\d(?:\.\d+)?(?!\.?\d)"
_TOKEN = re.compile(  # word with an exponent behind it; exponent after ^; one; sign; product by a point or a hyphen
    rf"\s*(?:([A-Za-z%‰]+)({_EXPONENT})?|\^\s*(?:({_EXPONENT})|\(\s*([+-]?\d(?:\.\d+)?(?:\s*/\s*[1-9])?)\s*\))"
    r"|(1(?!\.?\d))|([*/()])|([.-])(?=\s*[A-Za-z])|\.(?![\dA-Za-z]))\s*"
)


class Meaning(NamedTuple):
    """What a unit is: factor to SI, dimension (exponents of BASE), and the exponent of minutes among its words."""

    factor: float
    dimension: tuple[float, ...]
    minutes: float = 0.0

    def times(self, other: Meaning, exponent: float = 1.0) -> Meaning:
        """The product with a power of another."""
        dimension = tuple(a + exponent * b for a, b in zip(self.dimension, other.dimension, strict=True))
        power = other.factor if exponent == 1.0 else other.factor**exponent
        return Meaning(self.factor * power, dimension, self.minutes + exponent * other.minutes)


ONE = Meaning(1.0, (0.0,) * len(BASE))


def factor(written: str, unit: str) -> float | None:
    """How many of the SI ``unit`` one ``written`` unit is; ``None`` if it has another dimension.

    Per minute is turns a minute where turns or radians are wanted. A moment over a speed may leave the radian out.

    Raises
    ------
    UnitError
        If it is no unit.
    """
    result, wanted = meanings(written), meanings(unit)[0].dimension
    for one in result:
        if _same(one.dimension, wanted):
            return one.factor
    for one in result:
        if not _same(one.dimension[:-1], wanted[:-1]):
            continue
        angle = one.dimension[-1], wanted[-1]
        if _same(wanted[:-1], (2.0, 1.0, -1.0, 0.0, 0.0)) and set(angle) == {0.0, -1.0}:  # N m s and N m s/rad
            return one.factor
        if angle[0] == 0.0 and one.minutes != 0.0:
            return float(one.factor * TURN ** angle[1])
    if unit.startswith("V/") and (nested := _nested(written)) != written:  # of a sensor: mV/mm/s is mV/(mm/s)
        return factor(nested, unit)
    return None


def _nested(written: str) -> str:
    return re.sub(r"^([^/()]+)/([^/()]+)/([^/()]+)$", r"\1/(\2/\3)", written)


def lacks_turns(written: str, unit: str) -> bool:
    """Whether it would be of this dimension if only it said of what: 1/s, where turns or radians in a second are wanted."""
    lacks_turns, wanted = meanings(written), meanings(unit)[0].dimension
    return any(
        unit.dimension[-1] == 0.0 != wanted[-1] and _same(unit.dimension[:-1], wanted[:-1]) for unit in lacks_turns
    )


def similar_unit(written: str, unit: str) -> str:
    """A unit that is written nearly alike and has the dimension of ``unit``; empty if there is none."""
    alike = [one for one in (*table(), *JOINED) if one.casefold() == written.casefold()]
    per_angle = (f"{written}/rad",) if "/rad" in unit else ()
    tried = (*alike, _nested(written), written.replace("kg", "kgf"), *per_angle)
    return next((one for one in tried if one != written and factor(one, unit) is not None), "")


CONFUSED: dict[
    str, dict[str, str]
] = {  # of the unit that is wanted: units of what it is taken for, and how to come from there
    "kg*m": {
        "N*m": "an unbalance is a mass, not a force, times a radius: divide a static moment by 9.80665 m/s^2, a torque is none",
        "N": "the force of an unbalance over the square of the speed is the unbalance",
        "kg": "a mass makes an unbalance with its radius: multiply by it",
        "m": "an eccentricity makes an unbalance with the mass of the rotor: multiply by it",
        "m/s": "a balance quality grade (mm/s) over the speed, times the mass of the rotor, is the unbalance",
        "kg*m^2": "an unbalance is a mass times its radius, an inertia a mass times the square of its radius",
    },
    "kg": {
        "N": "a weight over 9.80665 m/s^2 is the mass",
        "kg*m": "an unbalance over its radius is the mass",
    },
    "kg*m^2": {
        "kg*m": "an inertia is a mass times the square of its radius, an unbalance a mass times its radius",
        "N*m^2": "a GD^2 in N*m^2 over 4 times 9.80665 m/s^2 is the inertia",
    },
    "kg/m^3": {"N/m^3": "a specific weight over 9.80665 m/s^2 is the density"},
    "m^2/s": {
        "Pa*s": "a dynamic viscosity over the density is the kinematic one that is wanted: 1 mPa*s in water is 1 mm^2/s"
    },
    "Pa*s": {
        "m^2/s": "a kinematic viscosity times the density is the dynamic one that is wanted: 1 cSt of water is 1 mPa*s"
    },
    "N/m": {
        "N*m/rad": "the stiffness of a support is a force over a deflection, not a moment over an angle",
        "rad/s": "a natural frequency in rad/s squared, times the mass, is the stiffness",
    },
    "N*m/rad": {"N/m": "a torsional or tilting stiffness is a moment over an angle, not a force over a deflection"},
    "N*s/m": {
        "": "a damping ratio D of a mass m on a stiffness k is a damping of 2 D sqrt(k m)",
        "N*m*s/rad": "the damping of a support is a force over a velocity, not a moment over an angular velocity",
        "1/s": "a decay rate times twice the mass is the damping",
    },
    "N*m*s": {"N*s/m": "multiply a force over a velocity by the square of the radius"},
    "N*m": {
        "N": "a force makes a torque with its radius: multiply by it",
        "W": "a power over the speed in rad/s is the torque",
        "N*m*s": "a drag coefficient times the speed is a torque",
    },
    "N": {
        "N*m": "a torque over its radius is the force",
        "Pa": "a pressure times its area is the force",
    },
    "Pa": {"N": "a force over its area is the pressure", "N/m": "a force over an area is wanted, not over a length"},
    "rad/s": {
        "m/s": "a circumferential speed over the radius is the speed of the rotor",
        "rad/s^2": "a speed is wanted, not how it rises",
        "s": "turns over the time that they take, such as 20 Hz, are a speed, not the time",
        "rad": "a speed is an angle in a time, such as 90 deg/s",
    },
    "rad/s^2": {"rad/s": "how the speed rises in a time is wanted, such as 30 rpm/s"},
    "s": {"Hz": "a time is wanted; that of one period is 1 over the frequency"},
    "m": {
        "m/s": "the amplitude of a velocity over 2 pi times its frequency is that of the displacement",
        "m/s^2": "the amplitude of an acceleration over the square of 2 pi times its frequency is that of the displacement",
    },
    "rad": {"m": "an arc over its radius is the angle"},
}


def confused(written: str, unit: str) -> str:
    """How to come to a quantity in ``unit`` from one that is often taken for it and has the ``written`` unit; else empty."""
    given = meanings(written)[0].dimension
    for other, hint in CONFUSED.get(unit, {}).items():
        if _same(given, meanings(other)[0].dimension if other else ONE.dimension):
            return hint
    return ""


def added(written: str) -> float:
    """What is added after the factor: not nothing for degrees Celsius and Fahrenheit."""
    return ADDED.get(_plain(written).strip(), 0.0)


def without_suffix(written: str) -> tuple[str, str]:
    """``"mil pp"`` as ``("mil", "peak to peak")``; of a unit without such a word the unit and an empty text."""
    match = _SUFFIX.fullmatch(written)
    if match is None:
        return written, ""
    kind = next(name for name, form in zip(SUFFIXES, match.groups()[1:], strict=True) if form is not None)
    try:
        meanings(match[1].strip())
    except UnitError:
        return written, ""
    return match[1].strip(), kind


@lru_cache(maxsize=4096)
def meanings(written: str) -> tuple[Meaning, ...]:
    """All that a unit may mean: more than one where it has a word such as g (gram, or standard gravity) or lb.

    Raises
    ------
    UnitError
        If it is no unit; the message says which word is not known, and which is perhaps meant.
    """
    words: dict[str, Meaning] = {}
    meanings = [_read(written, lambda name: words.setdefault(name, _word(name, written)))]
    for second in SECOND:
        if second.keys() & words.keys():
            others = words | {name: table()[other] for name, other in second.items()}
            meanings.append(_read(written, others.__getitem__))
    return tuple(meanings)


@cache
def table() -> dict[str, Meaning]:
    """Every single word of the trade with its meaning."""
    table = {name: Meaning(1.0, tuple(float(name == one) for one in BASE)) for name in BASE}
    for spellings, value, of, prefixes in itertools.chain.from_iterable(WORDS.values()):
        plain = _read(of, table.__getitem__) if of else ONE
        symbol, *names = spellings.split()
        for name in (symbol, *names):
            table[name] = plain._replace(factor=value * plain.factor, minutes=float(value == 60.0))
        for prefix in prefixes.split():
            table[prefix + symbol] = plain._replace(factor=PREFIXES[prefix] * value * plain.factor)
    full = {
        "meter": "m",
        "metre": "m",
        "gram": "g",
        "second": "s",
        "newton": "N",
        "pascal": "Pa",
        "volt": "V",
        "hertz": "Hz",
    }
    for (long, prefix), (name, symbol) in itertools.product({"": "", **LONG}.items(), full.items()):
        if prefix + symbol in table:
            table[long + name] = table[f"{long}{name}s"] = table[prefix + symbol]
    return table


def _read(written: str, word: Callable[[str], Meaning]) -> Meaning:
    """The product that a text writes down, from left to right; ``word`` gives the meaning of each word."""
    text, at = _plain(written), 0
    stack: list[tuple[Meaning, float]] = []  # products outside of brackets, and the sign of the exponent of the bracket
    product, sign, last = ONE, 1.0, None  # last: the factor that an exponent after ^ belongs to
    while at < len(text):
        token = _TOKEN.match(text, at)
        if token is None:
            raise UnitError(f"{written!r} is not a unit; write one such as 'kg*m^2/s', with exponents below 10")
        at = token.end()
        name, behind, power, bracket, one, mark, _ = token.groups()
        if name is not None:
            *parts, end = JOINED.get(CASES.get(name, name), (name,))
            for part in parts:
                product = product.times(word(part), sign)
            last = word(end), sign
            product, sign = product.times(last[0], sign * float(behind or 1.0)), 1.0
            last = last if behind is None else None
        elif power is not None or bracket is not None:
            if last is None:
                raise UnitError(f"{written!r} is not a unit; an exponent follows a word or a bracket, such as m^2")
            above, _, below = (power or bracket).partition("/")
            product, last = product.times(last[0], last[1] * (float(above) / float(below or 1.0) - 1.0)), None
        elif one is not None:
            last, sign = None, 1.0
        elif mark == "(":
            stack.append((product, sign))
            product, sign, last = ONE, 1.0, None
        elif mark == ")" and stack:
            inside = product
            product, outside = stack.pop()
            product, sign, last = product.times(inside, outside), 1.0, (inside, outside)
        elif mark == ")":
            raise UnitError(f"{written!r} is not a unit; a bracket is closed that was not opened")
        else:
            sign, last = -1.0 if mark == "/" else 1.0, None
        if max(map(abs, product.dimension)) >= HIGHEST:
            raise UnitError(f"{written!r} is not a unit; write one such as 'kg*m^2/s', with exponents below 10")
    if stack:
        raise UnitError(f"{written!r} is not a unit; a bracket is not closed")
    return product


def _plain(written: str) -> str:
    text = written.translate(_CHARACTERS)
    for form, instead in _PLAIN:
        text = re.sub(form, instead, text)
    return text


def _word(name: str, written: str) -> Meaning:
    known = table()
    result = known.get(CASES.get(name, name))
    if result is None and name not in AMBIGUOUS:
        result = _full_name(name)
    if result is not None:
        return result
    whole = "" if name == written else f" in {written!r}"
    if name in AMBIGUOUS:
        raise UnitError(f"{AMBIGUOUS[name]}{whole}")
    every = [*known, *JOINED]
    near = [one for one in every if one.casefold() == name.casefold()] or get_close_matches(name, every, 2, 0.6)
    raise UnitError(f"{name!r}{whole} is not a unit" + (f"; did you mean {' or '.join(near)}?" if near else ""))


def _full_name(name: str) -> Meaning | None:
    """The meaning of a full name without a prefix, from Pint, whose symbols and prefixes would make a unit of nearly any word."""
    if len(name) < 4 or not name.islower():
        return None
    registry, bases = _registry(), ("meter", "kilogram", "second", "ampere", "kelvin", "radian")
    for prefix, full, _ in registry.parse_unit_name(name):
        if prefix == "" and name in (full, f"{full}s") and registry._units[full].is_multiplicative:
            size, roots = registry.get_base_units(full)
            exponents = dict(roots._units)
            if exponents.keys() <= set(bases):
                return Meaning(float(size), tuple(float(exponents.get(base, 0.0)) for base in bases))
    return None


@cache
def _registry() -> Any:
    import pint

    return pint.UnitRegistry(cache_folder=None, on_redefinition="ignore")


def _same(values: tuple[float, ...], other: tuple[float, ...]) -> bool:
    return all(abs(a - b) < 1e-9 for a, b in zip(values, other, strict=True))

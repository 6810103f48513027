"""How answers about rotors, their stability and their balancing show themselves, a form for each kind."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.results.answers.answer import FORMS, Answer, Form, Shown, sure
from autobalancer.results.display_units import (
    AxisUnit,
    axis_unit,
    length_axis,
    length_text,
    moment_text,
    share_text,
    significant,
    speed_axis,
)
from autobalancer.tables import Column, border_cell, rpm_and_si, whole_degrees
from autobalancer.units import column_factor

DAMPING = Shown("damping_ratio", "damping ratio", "%", ".3g")


def _at_speed(dataset: xr.Dataset) -> str:
    """The speed for which it was asked: ``at 1200 rpm (125.66 rad/s)``; empty if it is not kept."""
    return f"at {rpm_and_si(float(dataset.attrs['speed']))}" if "speed" in dataset.attrs else ""


# Modes, critical speeds and responses of rotors.


RATES = {"displacement": "", "velocity": "/s", "acceleration": "/s²"}

FORMS["Modes"] = Form(
    columns=(Shown("name", "mode"), Shown("frequency"), DAMPING, Shown("whirl")),
    row_of="mode",
    heading=lambda it: f"{it.attrs.get('machine_name', 'rotor')}: natural frequencies {_at_speed(it)}",
    empty="nothing oscillates",
    shown_in="Hz",
)


def _critical_speeds(found: Answer, unit: str) -> list[Column]:
    """The harmonic only if there is one that is not the speed itself."""
    harmonic = [Shown("harmonic", "frequency over speed", form="g")] * bool(np.any(found["harmonic"].values != 1.0))
    return found.shown(unit, Shown("critical_speed"), Shown("whirl"), *harmonic, Shown("name", "mode"))


FORMS["CriticalSpeeds"] = Form(_critical_speeds, "critical", ("critical_speed", "harmonic", "whirl", "name"))


def _intersections(found: Answer, unit: str) -> list[Column]:
    """Where a branch meets a multiple of the speed."""
    names = found["name"].values[found["intersection_branch"].values - 1]
    met = (
        Shown("intersection_speed", "meets at"),
        Shown("intersection_harmonic", "frequency over speed", form="g"),
        Shown("intersection_whirl", "whirl"),
    )
    return [*found.shown(unit, *met), Column("branch", [str(name) for name in names], wraps=True)]


FORMS["Campbell"] = Form(
    _intersections,
    "intersection",
    ("intersection_speed", "intersection_harmonic", "intersection_branch"),
    there=lambda it: "branch" in it["name"].dims,
    remarks=lambda it: [
        f"{it.sizes['branch']} branches from {' to '.join(rpm_and_si(float(it['speed'][k])) for k in (0, -1))}"
    ],
    empty="no branch meets the speed in this range",
)


def _heights(found: Answer, head: str, sizes: NDArray[np.float64]) -> Column:
    length = length_axis(None, float(np.nanmax(sizes, initial=0.0)))
    return Column(head, sizes * length.factor, length.sign + RATES[str(found.attrs.get("quantity", "displacement"))])


def _greatest(found: Answer, unit: str) -> list[Column]:
    """Each station at the speed at which it moves most."""
    size = found["semi_major"].transpose("station", "speed").values
    head = f"greatest {found.attrs.get('quantity', 'displacement')}"
    at = found.isel(speed=size.argmax(axis=1))
    return [
        *at.shown(unit, Shown("station")),
        _heights(found, head, size.max(axis=1)),
        *at.shown(unit, Shown("speed", "at")),
    ]


def rubber_remarks(attrs: Mapping[str, Any]) -> list[str]:
    """Where rubber moves farther than its elements, and what its first harmonic leaves out."""
    beyond, third = attrs.get("rubber_beyond_its_elements", ()), attrs.get("rubber_third_harmonic", 0.0)
    said = []
    if third > 0.0:
        said.append(
            "rubber in ellipses: first harmonic of its force; the third, left out, would move it by "
            f"{100.0 * third:.2g} % at most"
        )
    if len(beyond):
        said.append(
            f"rubber of {', '.join(beyond)}: moves farther than its largest breakaway amplitude; its loss force no longer grows "
            "there, as that of real rubber probably does. Give it a further element"
        )
    return said


FORMS["Response"] = Form(
    _greatest,
    there=lambda it: (
        "semi_major" in it and set(it["semi_major"].dims) == {"speed", "station"} and it.sizes["speed"] > 0
    ),
    remarks=lambda it: rubber_remarks(it.attrs),
)
FORMS["ResponsePeaks"] = Form(
    lambda it, unit: [
        *it.shown(unit, Shown("peak_speed", "peak at")),
        _heights(it, "amplitude", it["peak_amplitude"].values),
    ],
    "peak",
    ("peak_speed", "peak_amplitude"),
    empty="no peak in this range",
)


def _taken(found: Answer) -> Iterator[str]:
    """Which of two ways was taken, and what to be careful about."""
    if "chosen" in found.attrs:
        yield f"taken: {found.attrs['chosen']}"
        for direction in found["direction"].values:
            ends = found.sel(way=found.attrs["chosen"], direction=direction)
            if np.isnan(ends["valid_from"]) or np.isnan(ends["valid_to"]):
                yield f"along {direction} it does not hold anywhere near its critical speed; look at its picture"
    yield from map(str, found.attrs.get("notes", ()))


OSCILLATOR = (
    Shown("stiffness", unit="N/m"),
    Shown("mass", unit="kg", form=".4g"),
    Shown("damping", unit="N s/m", form=".4g"),
    Shown("critical_speed"),
    Shown("valid_from", "holds from", form=".4g"),
    Shown("valid_to", "holds to", form=".4g"),
)
FORMS["PlanarOscillators"] = Form(
    lambda it, unit: (
        it[[entry.name for entry in OSCILLATOR]]
        .stack(one=("way", "direction"))
        .shown(unit, Shown("way"), Shown("direction", "along"), *OSCILLATOR)
    ),
    "way",
    tuple(entry.name for entry in OSCILLATOR if entry.name != "critical_speed"),
    there=lambda it: "direction" in it["stiffness"].dims,
    remarks=lambda it: list(_taken(it)),
)
FORMS["FittedReceptance"] = Form(
    lambda it, unit: [
        Column("mode", np.arange(1, it.sizes["mode"] + 1).tolist()),
        *it.shown(
            unit,
            Shown("mode_frequency", "frequency"),
            sure("mode_frequency", bare=True),
            Shown("mode_damping_ratio", "damping ratio", "%", ".4g"),
            sure("mode_damping_ratio", "%", bare=True),
            Shown("mode_mass", "mass", "kg", ".4g"),
            sure("mode_mass"),
        ),
    ],
    "mode",
    ("mode_frequency", "mode_damping_ratio", "mode_mass"),
    frozenset({"fit_error", "band_low", "band_high"}),
    facts=lambda it: [
        ("left over", share_text(float(it.attrs["fit_error"]))),
        ("band", " to ".join(f"{it.attrs[f'band_{end}'] / (2.0 * np.pi):.4g}" for end in ("low", "high")) + " Hz"),
    ],
    shown_in="Hz",
)

# Torsion.


def _twisted(found: Answer, unit: str) -> list[Column]:
    """Each link and harmonic at the speed at which its torque is greatest."""
    whole = found.stack(row=("link", "harmonic"))
    worst = whole.isel(speed=whole["link_torque"].argmax("speed"))
    return worst.shown(
        unit,
        Shown("link"),
        Shown("harmonic", "frequency over speed", form="g"),
        Shown("link_torque", "greatest torque", "N m", ".4g"),
        Shown("twist", unit="deg", form=".4g"),
        Shown("speed", "at"),
    )


def _met(found: Answer) -> str:
    names = (f"crossing_{name}" for name in ("speed", "harmonic", "name", "damping_ratio"))
    rows = zip(*(found[name].values for name in names), strict=True)
    met = [f"{rpm_and_si(w)} ({name}, {h:g} per turn, damping ratio {100.0 * d:.3g} %)" for w, h, name, d in rows]
    return f"with damping: {'; '.join(met) or 'no frequency is met'}"


FORMS["TorsionalModes"] = Form(
    lambda it, unit: [
        *it.shown(unit, Shown("name", "mode"), Shown("frequency"), DAMPING),
        *(Column(str(part), it["angle_real"].values[:, i], form=".3g") for i, part in enumerate(it["part"].values)),
    ],
    "mode",
    ("name", "frequency", "damping_ratio", "angle_real"),
    heading=lambda it: f"{it.attrs.get('machine_name', 'drive')}: torsional natural frequencies {_at_speed(it)}",
    empty="nothing oscillates",
    shown_in="Hz",
)
FORMS["TorsionalCriticalSpeeds"] = Form(
    lambda it, unit: [
        *it.shown(
            unit,
            Shown("critical_speed"),
            Shown("harmonic", "frequency over speed", form="g"),
            Shown("name", "mode"),
        ),
        Column("excited by", [str(text) or "nothing here" for text in it["excited_by"].values], wraps=True),
    ],
    "critical",
    ("critical_speed", "harmonic", "name", "excited_by"),
    remarks=lambda it: [_met(it)],
)
FORMS["TorsionalResponse"] = Form(
    _twisted,
    there=lambda it: "link_torque" in it and set(it["link_torque"].dims) == {"speed", "harmonic", "link"},
)

# Steady states and the ranges of speed in which they are stable.


MARK = "*"
OVERLAP = (
    f"states with {MARK} are those of points: balls of this size would overlap in them, and touch side by side instead"
)
RANGE = {  # variables of a range, with their units
    "from_speed": "rad/s",
    "to_speed": "rad/s",
    "verdict": "",
    "growth_rate": "1/s",
    "leading_motion": "",
    "gap": "",
}


def _overlap(found: Answer) -> NDArray[Any]:
    return found["overlapping"].values if "overlapping" in found else np.zeros(found.sizes["state"], np.bool_)


def _states(found: Answer, unit: str) -> list[Column]:
    angles = np.degrees(found["ball_angle_in_rotor"].values) % 360.0
    names = [f"{name}{MARK * bool(here)}" for name, here in zip(found["name"].values, _overlap(found), strict=True)]
    return [
        Column("state", names),
        *found.shown(unit, Shown("verdict"), Shown("growth_rate", unit="1/s", form=".3g")),
        Column("ball angles", [", ".join(f"{angle:.4g}" for angle in row) for row in angles], "°", wraps=True),
        Column("deflection", [length_text(value) for value in found["deflection"].values]),
        Column("residual unbalance", [moment_text(value) for value in found["residual_unbalance"].values]),
    ]


def verdict_ranges(dataset: xr.Dataset) -> Answer:
    """Speeds in a row with one verdict: first, last, verdict, greatest growth rate, the motion there, whether a gap is before."""
    speeds, rates, verdicts, motions = (
        dataset[name].values for name in ("speed", "growth_rate", "verdict", "leading_motion")
    )
    missing = np.asarray(dataset.attrs.get("speeds_without_state", ()), np.float64)
    rows: list[list[Any]] = []
    for i, speed in enumerate(speeds):
        gap = i > 0 and bool(np.any((missing > speeds[i - 1]) & (missing < speed)))
        if not rows or gap or verdicts[i] != rows[-1][2]:
            rows.append([speed, speed, verdicts[i], rates[i], motions[i], gap])
        else:
            rows[-1][1] = speed
            if rates[i] > rows[-1][3]:
                rows[-1][3:5] = rates[i], motions[i]
    columns = {
        name: ("range", [row[k] for row in rows], {"long_name": name.replace("_", " "), "units": unit})
        for k, (name, unit) in enumerate(RANGE.items())
    }
    return Answer.of(xr.Dataset(columns), "Ranges")


def _missing(found: Answer) -> list[str]:
    missing = np.size(found.attrs.get("speeds_without_state", ()))
    return [f"no such state at {missing} of the speeds"] if missing else []


FORMS["Equilibria"] = Form(
    _states,
    "state",
    ("name", "verdict", "growth_rate", "ball_angle_in_rotor", "deflection", "residual_unbalance"),
    heading=lambda it: f"{it.attrs.get('title', '')} {_at_speed(it)}",
    remarks=lambda it: [OVERLAP] if _overlap(it).any() else [],
)
FORMS["Ranges"] = Form(
    (
        Shown("from_speed", "from", form=".6g"),
        Shown("to_speed", "to", form=".6g"),
        Shown("verdict", "state is"),
        Shown("growth_rate", "growth rate at most", "1/s", ".4g"),
        Shown("leading_motion", "fastest growing motion"),
    ),
    "range",
)
FORMS["Eigenvalues"] = Form(  # the table joins speeds of one verdict
    lambda it, unit: verdict_ranges(it).columns(unit),
    "speed",
    ("growth_rate", "verdict", "leading_motion"),
    remarks=_missing,
)

# Border curves, stability maps and curves of special points.


OF_BORDER = "_of_border"  # ending of the axes along which a map has border speeds


def _across(found: Answer) -> xr.DataArray:
    return found[str(next(iter(found.dims)))]


def _curves(found: Answer) -> list[str]:
    return [str(name) for name, entry in found.data_vars.items() if entry.attrs.get("units") == "rad/s"]


def _best(found: Answer, name: str) -> NDArray[np.float64]:
    """The border of the best positions of the balls, beside the one of all positions; nan beside others."""
    best = f"{name}_best_case"
    return np.asarray(found[best].values if best in found else np.full(found[name].shape, np.nan), np.float64)


def _border_columns(found: Answer, unit: str) -> list[Column]:
    shown, across = speed_axis(unit or "rpm"), _across(found)
    axis = axis_unit(across, unit or "rpm")
    columns = [Column(_called(across), axis.shown(across.values), axis.sign)]
    for name in _curves(found):
        pairs = zip(found[name].values, _best(found, name), strict=True)
        cells = [border_cell(speed, shown.factor, best) for speed, best in pairs]
        columns.append(Column(_called(found[name]), cells, shown.sign, ".6g"))
    return columns


def _called(entry: xr.DataArray) -> str:
    return str(entry.attrs.get("long_name", entry.name))


def _highest(found: Answer) -> list[str]:
    """Where the exact border is highest, and where there is none."""
    if "exact_border" not in found or not np.isfinite(found["exact_border"].values).any():
        return []
    borders, across = found["exact_border"].values, _across(found)
    place = int(np.argmax(np.where(np.isfinite(borders), borders, -np.inf)))
    never, some = np.isposinf(borders), np.isfinite(_best(found, "exact_border"))
    text = f"exact border: highest {rpm_and_si(float(borders[place]))} at {_value(across, float(across[place]))}"
    for where, what in (
        (never & ~some, "never stable"),
        (never & some, "stable at some positions of the balls only"),
    ):
        text += f", {what} at {int(where.sum())} of {borders.size} values" * bool(where.any())
    return [text]


def _value(axis: xr.DataArray, value: float) -> str:
    unit = axis_unit(axis, "rpm")
    return f"{_called(axis)} {significant(unit.shown(value), 4)} {unit.sign}".rstrip()


FORMS["BorderCurve"] = Form(
    _border_columns,
    there=lambda it: len(it.dims) == 1 and str(next(iter(it.dims))) in it.coords and bool(_curves(it)),
    remarks=_highest,
    most=10,
)


def _stable_text(found: Answer) -> str:
    """How much of a map has a balanced state, and a stable one."""
    rates = found["growth_rate"].values
    known = rates[np.isfinite(rates)]
    stable = f"{share_text(float((known < 0.0).mean()))} of them stable" if known.size else "no balanced state anywhere"
    return f"{rates.size} points, {known.size} with a balanced state, {stable}"


def _map_facts(found: Answer) -> Iterator[tuple[str, str]]:
    """Both axes, the stable share, borders, where friction holds balls at rest, and operating points."""
    dims = [str(dim) for dim in found["growth_rate"].dims]
    for letter, dim in zip("xy", dims, strict=True):
        axis, unit = found[dim], axis_unit(found[dim], "rpm")
        ends = " to ".join(significant(float(unit.shown(end)), 4) for end in (axis.values.min(), axis.values.max()))
        yield f"{letter} axis", f"{_called(axis)}, {ends} {unit.sign}".rstrip() + f" ({axis.size} values)"
    yield "stability", _stable_text(found)
    for name in _curves(found):
        entry = found[name]
        known = entry.values[np.isfinite(entry.values)]
        if entry.dims and all(str(dim).endswith(OF_BORDER) for dim in entry.dims) and known.size:
            low, high = rpm_and_si(float(known.min())), rpm_and_si(float(known.max()))
            never = ", in places never" if np.isposinf(entry.values).any() else ""
            yield _called(entry), (low if low == high else f"{low} to {high}") + never
    if "held_share" in found:
        share = share_text(float((found["held_share"] >= 1.0).mean()))
        yield "friction", f"the unbalance alone does not move balls at rest in {share} of the map"
    for k, name in enumerate(found["operating_point"].values if "operating_point" in found.coords else ()):
        values = {dim: float(found[f"operating_{dim}"].values[k]) for dim in dims}
        at = ", ".join(_value(found[dim], value) for dim, value in values.items())
        yield f"point {k + 1}", f"{name}: {at}; {_stability_at(found, values)}"


def _stability_at(found: Answer, values: dict[str, float]) -> str:
    if not all(found[dim].values.min() <= value <= found[dim].values.max() for dim, value in values.items()):
        return "outside of the map"
    near = {dim: int(np.abs(found[dim].values - value).argmin()) for dim, value in values.items()}
    rate = float(found["growth_rate"].isel(near))
    if math.isnan(rate):
        return "no balanced state at the nearest point of the map"
    return f"{'stable' if rate < 0.0 else 'unstable'} at the nearest point of the map, growth rate {rate:.3g} 1/s"


FORMS["StabilityMap"] = Form(
    there=lambda it: (
        "growth_rate" in it
        and len(it["growth_rate"].dims) == 2
        and all(dim in it.coords for dim in it["growth_rate"].dims)
    ),
    facts=lambda it: list(_map_facts(it)),
)


def _span(values: xr.DataArray, axis: AxisUnit) -> str:
    low, high = (f"{axis.shown(float(end)):.5g}" for end in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


def _special_curves(found: Answer, unit: str) -> list[Column]:
    """The ranges of both parameters along each curve, and of Hopf curves the frequencies."""
    curves = [found.isel(point=np.flatnonzero(found["curve"].values == k)) for k in np.unique(found["curve"].values)]
    columns = [Column("curve", [int(part["curve"][0]) for part in curves])]
    axes = {name: axis_unit(found[name], unit or "rpm") for name in ("parameter", "second_parameter")}
    for name, axis in (axes | ({"frequency": speed_axis("Hz")} if "frequency" in found else {})).items():
        head = "frequency" if name == "frequency" else str(found[name].attrs["long_name"])
        columns.append(Column(head, [_span(part[name], axis) for part in curves], axis.sign))
    if "frequency" in found:
        kinds = [", ".join(sorted(set(part["criticality"].values.tolist()))) for part in curves]
        columns.append(Column("criticality", kinds, wraps=True))
    return [*columns, Column("points", [part.sizes["point"] for part in curves])]


def _special_points(found: Answer) -> list[str]:
    axes = {name: axis_unit(found[name], "rpm") for name in ("parameter", "second_parameter")}
    said = []
    for i, kind in enumerate(found["special_type"].values if "special_type" in found else ()):
        values = ((axis, float(found[f"special_{name}"].values[i])) for name, axis in axes.items())
        said.append(f"{kind} at {', '.join(f'{axis.shown(v):.5g} {axis.sign}'.rstrip() for axis, v in values)}")
    return said


FORMS["BifurcationCurves"] = Form(
    _special_curves,
    "point",
    ("curve", "parameter", "second_parameter"),
    remarks=_special_points,
)

# Corrections and unbalances from readings.


SHOWN = {"kg": ("g", 1e3), "kg m": ("g mm", 1e6), "m": ("µm", 1e6), "m/s": ("mm/s", 1e3), "m/s^2": ("m/s²", 1.0)}


def shown_unit(unit: str) -> tuple[str, float]:
    """The unit in which a quantity of a balancing job is shown, and its factor."""
    return SHOWN.get(unit, (unit, 1.0))


def channel_unit(one: xr.Dataset) -> tuple[str, float]:
    """The same of what a sensor reads: the unit in which its readings were written, if they were."""
    if written := str(one["written_unit"].item()) if "written_unit" in one.coords else "":
        return written, 1.0 / column_factor(written, one["unit"].item(), amplitude=True)[0]
    return shown_unit(one["unit"].item() if "unit" in one.coords else one["residual"].attrs["units"])


def _corrections(found: xr.Dataset, unit: str) -> list[Column]:
    """Mass and angle, each with its standard deviation."""
    sign, _ = shown_unit(found["correction"].attrs["units"])
    return Answer.of(found).shown(
        unit,
        Shown("correction", "mass" if sign == "g" else "correction", sign, ".4g"),
        sure("correction", sign),
        Shown("correction_angle", "angle", "deg", ".1f", turn=360.0),
        sure("correction_angle", "deg"),
    )


def _changes(found: Answer) -> tuple[Shown, ...]:
    """Of masses that are left on."""
    sign, _ = shown_unit(found["correction"].attrs["units"])
    change = Shown("change", "change by", sign, ".4g"), Shown("change_angle", "at", "deg", ".1f", turn=360.0)
    return change if found.attrs.get("left_on") else ()


def _remains(found: Answer) -> list[tuple[str, str]]:
    """What remains, and beside known coefficients or a run-out from how many readings this was subtracted."""
    facts = []
    for c in range(found.sizes["channel"]):
        one = found.isel(channel=c)
        said = _to(one, float(one["original"]), "residual")
        if "left_on_residual" in one:
            said += f" with the corrections, {_to(one, float(one['original']), 'left_on_residual')} with the changes"
        facts.append((_channel(one), said))
    facts += _parts(found)
    if (count := found.attrs.get("runout_readings")) is not None:
        text = f"subtracted from {count} reading{'s' * (count > 1)}" if count else "none is subtracted"
        facts.append(("run-out", text))
    return [*facts, ("masses of the runs", _of_trial_masses(found))]


def _channel(one: xr.Dataset) -> str:
    speed = float(one["speed"])
    return f"sensor {one['sensor'].item()}" + ("" if np.isnan(speed) else f", {speed * 30.0 / np.pi:.5g} rpm")


def _to(one: xr.Dataset, before: float, name: str) -> str:
    """A vibration before and with masses: ``7.2 to 2.6 +- 0.2 mm/s``."""
    sign, factor = channel_unit(one)
    after, sure = float(one[name]), float(one[f"{name}_deviation"])
    more = "" if np.isnan(sure) else f" +- {significant(factor * sure, 2)}"
    after = factor * after if after > 1e-9 * before else 0.0
    return f"{significant(factor * before)} to {significant(after)}{more} {sign}".strip()


def _parts(found: Answer) -> list[tuple[str, str]]:
    """The masses of each correction that is split over holes, and what they lack."""
    if "part_of" not in found:
        return []
    sign, factor = shown_unit(found["part_mass"].attrs["units"])
    facts = []
    for name in dict.fromkeys(found["part_of"].values):
        own = found.isel(part=found["part_of"].values == name)
        parts = [
            f"{significant(factor * size)} {sign} at {whole_degrees(at)} deg"
            for size, at in zip(own["part_mass"].values, own["part_angle"].values, strict=True)
            if size > 0.0
        ]
        lacking = factor * float(own["part_left"][0])
        most = own["part_left"].attrs.get("most")
        tried = f", the least with up to {most} holes; 'most' allows more" if most else ""
        rest = (
            f"; {significant(lacking, 2)} {sign} of it are left{tried}"
            if lacking > 1e-9 * factor * own["part_mass"].sum()
            else ""
        )
        facts.append((str(name), (", ".join(parts) or "no mass") + rest))
    return facts


def _of_trial_masses(found: Answer) -> str:
    """Whether the masses with which the last run was made come off or stay."""
    sign, factor = shown_unit(found["run_mass"].attrs["units"])
    last = found.isel(run=-1)
    on = {
        plane: f"{significant(factor * size)} {sign} at {whole_degrees(angle)} deg in plane {plane}"
        for plane, size, angle in zip(
            *(last[name].values for name in ("all_planes", "run_mass", "run_mass_angle")), strict=True
        )
        if size > 0.0
    }
    if not on:
        return "all off, as in the last run; the corrections are for a rotor without them"
    off = (
        f"take off {', '.join(on.values())} of the last run: the corrections are for a rotor without masses of the runs"
    )
    always = [text for plane, text in on.items() if plane not in found["plane"].values]
    if not found.attrs.get("left_on") or len(always) == len(on):
        return off
    without = f" all but {', '.join(always)}, which comes off," if always else " them"
    return f"either {off}; or leave{without} on, and put on only what is in the columns 'change by' and 'at'"


FORMS["Balancing"] = Form(
    lambda it, unit: [*it.shown(unit, Shown("plane")), *_corrections(it, unit), *it.shown(unit, *_changes(it))],
    "plane",
    ("correction", "correction_angle"),
    facts=_remains,
)


def _places(found: Answer, unit: str) -> list[Column]:
    """A row for each sensor and speed; two where the runs do not decide."""
    rows = found.drop_vars("channel", errors="ignore").stack(row=("channel", "solution"))
    rows = rows.isel(row=np.flatnonzero(np.isfinite(rows["correction"].values)))
    speed = [Shown("speed")] * bool(np.isfinite(found["speed"].values).all())
    return [
        *rows.shown("rpm", Shown("sensor"), *speed),
        *_corrections(rows, unit),
        *rows.shown(unit, Shown("misfit", form=".2g")),
    ]


def _circles(found: Answer) -> list[tuple[str, str]]:
    """How far the circles are from meeting in one point and when to distrust it, and that the trial mass comes off."""
    facts = []
    for sensor, miss, misfits in zip(*(found[name].values for name in ("sensor", "miss", "misfit")), strict=True):
        text = "three circles always meet: only a fourth run shows whether the runs belong together"
        if found.sizes["run"] > 3:
            text = (
                f"miss one point by {significant(100.0 * miss, 2)} % of what the trial mass does, "
                f"{significant(misfits[0], 2)} standard deviations of the readings; up to {found.attrs['noise_up_to']:g} it is "
                f"noise, beyond that distrust the correction, beyond {found.attrs['none_beyond']:g} there is none"
            )
        facts.append((f"circles of {sensor}", text))
    for c, s in np.ndindex(found["residual"].shape):
        one = found.isel(channel=c, solution=s)
        if np.isfinite(one["residual"]):
            before = float(one["sensitivity"] * one["correction"])
            answer = f", answer {s + 1}" if found.sizes["solution"] > 1 else ""
            facts.append((f"{_channel(one)}{answer}", _to(one, before, "residual")))
    facts += _parts(found)
    return [*facts, ("trial mass", "take it off: the correction is for the rotor without it")]


FORMS["FourRun"] = Form(_places, "channel", ("correction", "correction_angle", "miss"), facts=_circles)


def _explained(found: Answer) -> list[tuple[str, str]]:
    """How well the model explains the readings of a run-down, and what is known worst."""
    facts = [
        ("of the readings not explained", share_text(float(found.attrs["left_over"]))),
        ("condition number", f"{found.attrs['condition']:.3g}"),
    ]
    if found.sizes["plane"] > 1:
        worst = found.isel(combination=0)
        rows = zip(*(worst[name].values for name in ("weight", "weight_phase", "plane")), strict=True)
        parts = [f"{float(weight):.2g} {name} at {np.degrees(float(way)):.0f} deg" for weight, way, name in rows]
        facts.append(("known worst", f"{', '.join(parts)}: +- {moment_text(float(worst['combination_deviation']))}"))
    return facts


FORMS["PlaneUnbalances"] = Form(
    (
        Shown("plane"),
        Shown("unbalance", unit="g mm", form=".4g"),
        sure("unbalance", "g mm"),
        Shown("unbalance_angle", "angle", "deg", ".1f", turn=360.0),
        sure("unbalance_angle", "deg"),
    ),
    "plane",
    known=frozenset({"left_over", "condition"}),
    facts=_explained,
)

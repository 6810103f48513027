"""Runs as what a person asks first: how it ended, how fast, balanced or not, and what was kept."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import xarray as xr

from autobalancer.errors import AutobalancerError
from autobalancer.results.answers.answer import FORMS, Answer, Form, Shown
from autobalancer.results.display_units import (
    AxisUnit,
    length_axis,
    length_text,
    measure_unit,
    significant,
    speed_axis,
    vibration_axis,
)
from autobalancer.results.verdict import GREATER, passage_text, worse_by
from autobalancer.tables import Column, border_cell, rpm_and_si

if TYPE_CHECKING:
    from autobalancer.results.verdict import Verdict


OF_VERDICT = ("residual unbalance", "greatest deflection", "unbalance jumps", "balls settle")  # rows of it
MANY = 4  # critical speeds
READ = 100_000_000  # bytes; the samples of a longer run are not read for a few lines of text


class Run(Answer):
    """A run of balls in races."""

    __slots__ = ()
    shown_as = Form()
    times: ClassVar[tuple[str, ...]] = ("time", "envelope_time", "turn_time")

    def has_table(self) -> bool:
        """How it ended and its times must be there."""
        known = {"machine_name", "outcome_text"} <= set(self.attrs)
        return known and any(time in self.coords and self[time].ndim for time in self.times)

    def heading(self) -> str:
        """Of which machine, and how it ended."""
        return f"{self.attrs['machine_name']}: run, {self.attrs['outcome_text']}"

    def facts(self) -> list[tuple[str, str]]:
        """Speed, balls, the verdict with its main numbers, and what was kept."""
        return [*self._speed(), ("balls", self._balls()), *self._judged(), ("kept", ", ".join(self._kept()))]

    def remarks(self) -> Sequence[str]:
        """Where to look next."""
        return ("more: ab.verdict(run), ab.run_measures(run), ab.plot.answer(run)",)

    def verdict(self) -> Verdict:
        """The verdict on it."""
        from autobalancer.results.verdict import verdict

        return verdict(self)

    def _speed(self) -> Iterator[tuple[str, str]]:
        name = next((name for name in ("speed", "envelope_speed", "turn_speed") if name in self), "")
        if name and self[name].size:
            first, last, most = (float(value) for value in (self[name][0], self[name][-1], self[name].max()))
            text = rpm_and_si(last) if abs(first - last) < 1e-3 * abs(last) else f"{_rpm(first)} to {rpm_and_si(last)}"
            yield "speed", text + (f", at most {rpm_and_si(most)}" if most > 1.01 * max(first, last) else "")
        critical = np.atleast_1d(self.attrs.get("critical_speeds", ())).tolist()
        if critical:
            more = f" and {len(critical) - MANY} more" if len(critical) > MANY else ""
            of = f", of {kind}" if (kind := self.attrs.get("critical_speeds_of")) else ""
            yield f"critical speed{'s' * (len(critical) > 1)}", ", ".join(map(rpm_and_si, critical[:MANY])) + more + of

    def _balls(self) -> str:
        count = self.sizes.get("ball", 0)
        if not count:
            return "spread evenly and held" if self.attrs.get("balls_held") else "none"
        races = set(zip(self["balancer"].values.tolist(), self["race"].values.tolist(), strict=True))
        return f"{count} in {len(races)} race{'s' * (len(races) > 1)}"

    def _judged(self) -> Iterator[tuple[str, str]]:
        if self.nbytes > READ:
            return
        from autobalancer.results.verdict import verdict_lines

        try:
            verdict = self.verdict()
        except (AutobalancerError, KeyError, ValueError, IndexError) as reason:  # of a part of a run
            yield "verdict", f"none: {reason}" if isinstance(reason, AutobalancerError) else "none"
            return
        head, rows, _ = verdict_lines(verdict)
        yield "verdict", head
        if verdict.places:
            worst = max(verdict.places, key=lambda place: place.vibration)
            where = f" at {worst.name}" if len(verdict.places) > 1 else ""
            without = "" if np.isnan(worst.without_balls) else f"; without balls {length_text(worst.without_balls)}"
            yield "vibration", f"at most {length_text(worst.vibration)} from the mean position{where}{without}"
        yield from (row for row in rows if row[0] in OF_VERDICT)

    def _kept(self) -> Iterator[str]:
        for dim, text in (("time", "{} samples"), ("bin", "an envelope of {} parts"), ("event", "{} events")):
            if self.sizes.get(dim, 0):
                yield text.format(self.sizes[dim])
        if self.sizes.get("turn", 0) > 1 and "turn_rotor_angle" in self:
            turns = float(np.ptp(self["turn_rotor_angle"].values)) / (2.0 * np.pi)
            yield f"the last {turns:.3g} revolutions"


def _rpm(speed: float) -> str:
    return f"{significant(speed * 30.0 / np.pi, 4)}"


# A run beside a measurement shows the measures of both.


def _channels(found: Answer) -> list[tuple[str, str]]:
    """How far each channel is from the run, beside what its noise explains."""
    rows = []
    places = found["place"].values if "place" in found else [""] * found.sizes["channel"]
    keys = ("channel", "units", "rms_measured", "rms_away", "rms_expected")
    for name, unit, size, away, noise, place in zip(*(found[key].values for key in keys), places, strict=True):
        shown = AxisUnit(*measure_unit("rad")) if unit == "rad" else vibration_axis(str(unit), float(size))
        factor, sign = shown.factor, shown.sign
        beside = f", its noise {noise * factor:.3g} {sign}" if np.isfinite(noise) else ", its noise is not known"
        text = f"rms of the difference {away * factor:.3g} {sign}{beside}"
        rows.append((f"{name}, {place} of the run" if place else str(name), text))
    return rows


def _measures_of_both(found: Answer, unit: str) -> list[Column]:
    """One row for each channel and each measure: measured, of the run, and their difference with its standard deviation."""
    speed = speed_axis(unit or "rpm")
    units = [str(entry) for entry in found["measure_unit"].values]
    shown = [(speed.sign, speed.factor) if entry == "rad/s" else measure_unit(entry) for entry in units]
    factors = np.array([factor for _, factor in shown])
    seen, run, sure = (found[name].values * factors for name in found.form().needed)
    return [
        Column("measure", [str(name) for name in found["measure"].values]),
        *([Column("of", found["measure_of"].values.tolist())] if any(found["measure_of"].values) else []),
        Column("measured", seen, form=".5g"),
        Column("run", run, form=".5g"),
        Column("difference", seen - run, form=".3g"),
        Column("+-", sure, form=".2g"),
        Column("unit", [sign for sign, _ in shown]),
    ]


FORMS["Overlay"] = Form(
    _measures_of_both,
    "measure",
    ("measured_value", "simulated_value", "value_deviation"),
    facts=_channels,
    remarks=lambda it: [str(note) for note in np.atleast_1d(it.attrs.get("notes", []))],
    most=200,
)


# Several machines side by side.


def _machines(found: Answer, unit: str) -> list[Column]:
    """Deflections in one unit; what is left in percent of the vibration without balls.

    Deep chambers have no exact border, so that their table has the force on their bearings in its place.
    """
    far = np.nanmax(np.append(found["peak_deflection"].values, 0.0))
    speed, length = speed_axis(unit or "rpm"), length_axis(None, float(far) or 1e-6)
    with np.errstate(divide="ignore", invalid="ignore"):
        left = 100.0 * found["vibration"].values / found["vibration_without_balls"].values
    borders, worst = found["exact_border"].values, np.full(found.sizes["machine"], np.nan)
    best = found["exact_border_best_case"].values if "exact_border_best_case" in found else worst
    cells = [border_cell(border, speed.factor, other) for border, other in zip(borders, best, strict=True)]
    known = np.isfinite(borders) | (found["border_note"].values.astype(str) != "")
    last = (
        [Column("exact border", cells, speed.sign, ".4g")]
        if known.any() or "support_force" not in found
        else found.shown(unit, Shown("support_force", "bearing force", "N", ".3g"))
    )
    at = [
        Column(f"at {value * speed.factor:.4g} {speed.sign}", values * length.factor, length.sign, ".4g")
        for value, values in zip(found["speed"].values, found["deflection_at"].values.T, strict=True)
    ]
    return [
        *found.shown(unit, Shown("machine")),
        *at,
        Column("peak", found["peak_deflection"].values * length.factor, length.sign, ".4g"),
        *found.shown(unit, Shown("peak_speed", "peak at", form=".4g")),
        Column("left", left, "%", ".2f"),
        *found.shown(unit, Shown("settling_time", "settled after", "s", ".3g")),
        Column("verdict", _verdicts(found)),
        *last,
    ]


def _verdicts(found: Answer) -> list[str]:
    """In words, with the passage where it is worse than without balls."""
    pairs = zip(found["verdict"].values, found["stalled_balls"].values, strict=True)
    words = [f"{word}, {count} balls stalled" if count else str(word) for word, count in pairs]
    if "peak_without_balls" not in found:
        return words
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = found["peak_deflection"].values / found["peak_without_balls"].values
    worse = [worse_by(float(ratio)) for ratio in ratios]
    return [word + f", {much} on the way" * bool(much) for word, much in zip(words, worse, strict=True)]


def _with_a_column_for_each_speed(found: Answer) -> xr.Dataset:
    rows = found.drop_dims("bin", errors="ignore")
    if not rows.sizes.get("speed"):
        return rows.drop_dims("speed", errors="ignore")
    return rows.assign_coords(speed=[f"{speed:.6g} rad/s" for speed in rows["speed"].values])


def _border_notes(found: Answer) -> list[str]:
    """How they ran, why a border is not known, and what it ignores; one sentence for all machines of which it is true."""
    concerned: dict[str, list[str]] = {}
    for name, note in zip(found["machine"].values, found["border_note"].values, strict=True):
        concerned.setdefault(str(note), []).append(str(name))
    how = "runs of seed {seed}, which draws start angles that no file gives, to a tolerance of {tolerance:g}"
    ran = [how.format_map(found.attrs)] if "seed" in found.attrs else []
    return [*ran, *(f"{', '.join(names)}: {note}" for note, names in concerned.items() if note)]


FORMS["Comparison"] = Form(
    _machines,
    "machine",
    ("machine", "verdict", "peak_deflection", "vibration", "exact_border"),
    remarks=_border_notes,
    in_si=_with_a_column_for_each_speed,
)


# Stepped responses as a table: one row for each speed.


LITTLE = 0.05  # of the greatest amplitude without balls, below which nobody minds a greater one


class SteppedResponse(Answer):
    """Amplitudes speed by speed, up, down or both."""

    __slots__ = ()
    shown_as = Form(row_of="speed", most=12)
    WITHOUT = "amplitude_without_balls"

    def rows(self, name: str = "amplitude") -> list[tuple[str, list[float]]]:
        """Of each direction its name and the amplitudes (m) at all speeds."""
        whole = self[name] if "direction" in self.dims else self[name].expand_dims("direction")
        return [(str(name), row.tolist()) for name, row in zip(whole["direction"].values, whole.values, strict=True)]

    def columns(self, unit: str = "") -> list[Column]:
        """Speed, amplitude in each direction, and what the balls do."""
        amplitudes = [Column(f"amplitude {name}", [1e6 * value for value in row], "µm") for name, row in self.rows()]
        if self.WITHOUT in self:
            amplitudes += [
                Column(f"without balls {name}", [1e6 * value for value in row], "µm")
                for name, row in self.rows(self.WITHOUT)
            ]
        return [*self.shown(unit, Shown("speed", form=".6g")), *amplitudes, *self._motions()]

    def heading(self) -> str:
        """Of which machine, how it was stepped, and how it ended."""
        how = f"{self.attrs['dwell']:.4g} s at each speed, measured for {self.attrs['window']:.4g} s"
        return f"{self.attrs['machine_name']}: stepped response, {how}; {self.attrs['outcome']}{self._worse('; ')}"

    def remarks(self) -> Sequence[str]:
        """The greatest amplitude of each direction, and what was noted."""
        said = list(self.greatest(rpm_and_si))
        return [*said, *self.attrs.get("remarks", [])]

    def greatest(self, speed_text: Callable[[float], str]) -> list[str]:
        """A sentence for each direction that was measured, with its speed as ``speed_text`` writes it."""
        said = [*filter(None, [self._worse(), self._worst(speed_text)]), *self._stalled(speed_text)]
        for kind in ("amplitude", *[self.WITHOUT] * (self.WITHOUT in self)):
            for name, row in self.rows(kind):
                reached = [i for i, value in enumerate(row) if math.isfinite(value)]
                if reached:
                    peak = max(reached, key=lambda i: row[i])
                    at = speed_text(float(self["speed"].values[peak]))
                    held = ", without balls" * (kind == self.WITHOUT)
                    said.append(f"{name}{held}: greatest amplitude {length_text(row[peak])} at {at}")
        return said

    def _stalled(self, speed_text: Callable[[float], str]) -> Iterator[str]:
        """At which speeds balls were stalled, a sentence for each direction."""
        if "ball_motion" not in self:
            return
        motion, balls = self["ball_motion"], self.sizes["ball"]
        whole = motion if "direction" in self.dims else motion.expand_dims("direction")
        speeds, stalled = self["speed"].values, whole.values == list(whole.attrs["flag_meanings"]).index("stalled")
        for direction, counts in zip(whole["direction"].values, stalled.sum(axis=2), strict=True):
            rows = np.flatnonzero(counts)
            parts = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1) if rows.size else []
            ranges = [" to ".join(dict.fromkeys(speed_text(float(speeds[k])) for k in (p[0], p[-1]))) for p in parts]
            if ranges:
                most = f"{counts.max()} of {balls} balls" + " at most" * (len(set(counts[rows].tolist())) > 1)
                yield f"{direction}: {most} stalled at {', '.join(ranges)}"

    def _worst(self, speed_text: Callable[[float], str]) -> str:
        """At how many speeds the vibration is more than a tenth greater than without balls, and where most."""
        if self.WITHOUT not in self:
            return ""
        both = [np.atleast_2d(self[name].values) for name in ("amplitude", self.WITHOUT)]
        times = np.where(both[0] > LITTLE * np.nanmax(both[1]), both[0] / both[1], 0.0)
        count = int((np.nan_to_num(times) > GREATER).any(axis=0).sum())
        if not count:
            return ""
        leg, at = np.unravel_index(int(np.nanargmax(times)), times.shape)
        sizes = [length_text(float(one[leg, at])) for one in both]
        return (
            f"at {count} of {self.sizes['speed']} speeds the amplitude is more than a tenth greater than without balls, most at "
            f"{speed_text(float(self['speed'].values[at]))}: {sizes[0]}, without {sizes[1]}"
        )

    def _worse(self, joined: str = "") -> str:
        """That the passage is worse than without balls, if it is; of speeds that were measured with and without."""
        if self.WITHOUT not in self:
            return ""
        both = np.stack([self["amplitude"].values, self[self.WITHOUT].values])
        both = both[:, np.isfinite(both).all(axis=0)]
        text = passage_text(*both.max(axis=1)) if both.size else ""
        return f"{joined}{text}" if text else ""

    def has_table(self) -> bool:
        """Amplitudes over the speed must be there."""
        known = {"machine_name", "dwell", "window", "outcome"} <= set(self.attrs)
        return known and "amplitude" in self and "speed" in self["amplitude"].dims

    def _motions(self) -> list[Column]:
        if "motion" not in self:
            return []
        words = np.array([*self["motion"].attrs["flag_meanings"], "-"], dtype=object)
        whole = self["motion"] if "direction" in self.dims else self["motion"].expand_dims("direction")
        names = [f"balls {name}" for name, _ in self.rows()]
        return [Column(name, words[row].tolist()) for name, row in zip(names, whole.values, strict=True)]


# Balls followed through a film: how many pictures, how sure, and where they ended.


STILL = 0.02  # rad from picture to picture


def _film_facts(found: Answer) -> list[tuple[str, str]]:
    """Pictures, faults, deviation, speed and what happened."""
    time, faults = found["time"].values, [str(text) for text in found["fault"].values if text]
    facts = [("pictures", f"{time.size} from {time[0]:.4g} s to {time[-1]:.4g} s, {len(faults)} with a fault")]
    first = next((k for k, text in enumerate(found["fault"].values) if text), None)
    if first is not None:
        facts.append(("first fault", f"picture {first + 1} at {time[first]:.6g} s: {found['fault'].values[first]}"))
    speed = found["speed"].values[np.isfinite(found["speed"].values)]
    if speed.size:
        facts.append(("rotor speed", f"{_rpm(float(speed[0]))} to {rpm_and_si(float(speed[-1]))}"))
    if speed.size and time.size > 1 and float(np.median(speed) * np.median(np.diff(time))) < STILL:
        text = "the rotor seems to stand still or to turn backward; if a stroboscope makes it so, give first_speed"
        facts.append(("doubt", text))
    deviation = np.degrees(found["ball_angle_deviation"].values)
    if np.isfinite(deviation).any():
        facts.append(
            (
                "angles",
                f"standard deviation {np.nanmedian(deviation):.2g}° (median), at most {np.nanmax(deviation):.2g}°",
            )
        )
    facts.append(("impacts", f"{found.sizes.get('impact', 0)} between balls"))
    for at, name in zip(found["event_time"].values[:6], found["event_name"].values[:6], strict=True):
        facts.append(("event", f"{name} at {at:.4g} s"))
    if found.attrs.get("unsure_identities"):
        facts.append(("identity", f"not sure in {found.attrs['unsure_identities']} pictures: see identity_margin"))
    return facts


def _last_angles(found: Answer, _: str) -> list[Column]:
    """The last angle of each ball."""
    angle, deviation = found["ball_angle"].values, found["ball_angle_deviation"].values
    rows = [np.flatnonzero(np.isfinite(column)) for column in angle.T]
    last = [int(row[-1]) if row.size else -1 for row in rows]
    wrapped = [(np.degrees(angle[k, i]) + 180.0) % 360.0 - 180.0 if k >= 0 else np.nan for i, k in enumerate(last)]
    sure = [np.degrees(deviation[k, i]) if k >= 0 else np.nan for i, k in enumerate(last)]
    return [
        Column("ball", found["ball"].values.tolist()),
        Column("seen in", [int(row.size) for row in rows]),
        Column("last angle in the rotor", wrapped, "°", ".2f"),
        Column("standard deviation", sure, "°", ".2g"),
    ]


FORMS["BallFilm"] = Form(
    _last_angles,
    there=lambda it: "ball_angle" in it and it["ball_angle"].dims == ("time", "ball"),
    facts=_film_facts,
)

"""Runs as what a person asks first: how it ended, how fast, balanced or not, and what was kept."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from autobalancer.errors import AutobalancerError
from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import length_text, significant
from autobalancer.shown import rpm_and_si

if TYPE_CHECKING:
    from autobalancer.results.verdict.judged import Verdict

OF_VERDICT = ("residual unbalance", "greatest deflection", "unbalance jumps", "balls settle")  # rows of it
MANY = 4  # critical speeds
READ = 100_000_000  # bytes; the samples of a longer run are not read for a few lines of text


class Run(Answer):
    """A run of balls in races."""

    __slots__ = ()
    drawn_by = "run_up"
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
        return (f"more: ab.verdict(run), ab.measures(run), ab.plot.{self.drawn_by}(run)",)

    def verdict(self) -> Verdict:
        """The verdict on it."""
        from autobalancer.results.verdict.judged import verdict

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
        from autobalancer.results.verdict.text import verdict_lines

        try:
            found = self.verdict()
        except (AutobalancerError, KeyError, ValueError, IndexError) as reason:  # of a part of a run
            yield "verdict", f"none: {reason}" if isinstance(reason, AutobalancerError) else "none"
            return
        head, rows, _ = verdict_lines(found)
        yield "verdict", head
        if found.places:
            worst = max(found.places, key=lambda place: place.vibration)
            where = f" at {worst.name}" if len(found.places) > 1 else ""
            without = "" if np.isnan(worst.without_balls) else f"; without balls {length_text(worst.without_balls)}"
            yield "vibration", f"at most {length_text(worst.vibration)}{where}{without}"
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

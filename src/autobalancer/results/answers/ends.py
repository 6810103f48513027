"""The ends of runs from many starts as a table: how often each one comes, and what it leaves."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import length_text, moment_text
from autobalancer.results.verdict.text import worse_by
from autobalancer.shown import Column, rpm_and_si

LEFT = (  # variable, what it is called, how it is written, the value without balls
    ("residual_quantile", "residual unbalance", moment_text, "unbalance"),
    ("deflection_quantile", "deflection", length_text, "deflection_without_balls"),
    ("vibration_quantile", "vibration", length_text, "vibration_without_balls"),
    ("peak_quantile", "greatest deflection on the way", length_text, "peak_without_balls"),
)

HELD = "held by friction"


class Ends(Answer):
    """Ends of a machine at a speed, from many starts."""

    __slots__ = ()
    row_of, needed = "end", ("share",)

    def columns(self, unit: str = "") -> list[Column]:
        """The ends that came, their shares, and of random starts the intervals of these."""
        there = self.isel(end=np.flatnonzero(self["share"].values > 0.0))
        found = [Column("end", [str(end) for end in there["end"].values])]
        for name, head in (("share", "share"), ("share_low", "95 % from"), ("share_high", "95 % to")):
            if name in there:
                found.append(Column(head, 100.0 * there[name].values, "%", ".2f"))
        return found

    def heading(self) -> str:
        """Whose they are, and at which speed."""
        starts = int(self["state"].size)
        return f"{self.attrs.get('machine_name', 'machine')}: ends of {starts} starts at {rpm_and_si(float(self.attrs['speed']))}"

    def remarks(self) -> Sequence[str]:
        """Which verdicts they had, and what they leave."""
        return [*super().remarks(), *self.left()]

    def left(self) -> Iterator[str]:
        """Verdicts, balls that move, and quantiles of what the ends leave, a sentence each."""
        if "verdict_share" in self:
            shares = zip(self["verdict"].values, self["verdict_share"].values, strict=True)
            if self._held():
                yield f"{HELD}: the balls rest where friction stops them, near balance or far from it; see the verdict"
            yield "verdict: " + ", ".join(f"{word} {100.0 * share:.3g} %" for word, share in shares if share > 0.0)
        for plane, own in self.planes().items():
            ends = ", ".join(f"{name} {100.0 * share:.3g} %" for name, share in own["share"].items())
            middle, *_, most = own["residual_unbalance"].values()
            rest = f"; residual unbalance at rest: median {moment_text(middle)}, at most {moment_text(most)}"
            yield f"plane {plane}: {ends}{rest if middle == middle else ''}; without balls {moment_text(own['unbalance'])}"
        if "moving_share" in self and float(self["moving_share"]) > 0.0:
            yield f"balls still move at the end of {100.0 * float(self['moving_share']):.3g} % of the runs"
        for name, text, written, whole in LEFT:
            if name in self and np.isfinite(self[name].values[0]):
                middle, often, most = map(written, self[name].values)
                how = self.attrs.get("released", "released")
                beside = f"without balls {written(float(self[whole]))}"
                ratio = float(self[name].values[0]) / float(self[whole]) if float(self[whole]) > 0.0 else np.nan
                much = worse_by(ratio) if name == "peak_quantile" else ""
                half = f" (half of the runs at least {much})" * bool(much)
                yield f"{text}, {how}: median {middle}, 95 % below {often}, at most {most}; {beside}{half}"

    def planes(self) -> dict[str, dict[str, Any]]:
        """Of each of several planes the shares of its ends, quantiles of its residual and its unbalance, SI."""
        if self.sizes.get("plane", 0) < 2:
            return {}
        names, possible = list(self.attrs["plane_states"]), self["state"].size - int(self.attrs["overlapping"])
        quantiles = [str(float(q)) for q in self["quantile"].values]
        answer = {}
        for number, plane in enumerate(self["plane"].values.tolist()):
            own = self.isel(plane=number)
            counts = np.bincount(own["plane_state"].values.ravel(), minlength=len(names))
            shares = {name: int(count) / max(possible, 1) for name, count in zip(names, counts, strict=True)}
            answer[str(plane)] = {
                "share": {name: share for name, share in shares.items() if share and name != "overlapping start"},
                "residual_unbalance": dict(zip(quantiles, own["plane_residual_quantile"].values.tolist(), strict=True)),
                "unbalance": float(own["plane_unbalance"]),
            }
        return answer

    def _held(self) -> bool:
        return HELD in self["end"].values and float(self["share"].sel(end=HELD)) > 0.0

    def has_table(self) -> bool:
        """The states must be there too."""
        return super().has_table() and "state" in self and "speed" in self.attrs

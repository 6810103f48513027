"""Balls followed through a film: how many pictures, how sure, and where they ended."""

from __future__ import annotations

import numpy as np

from autobalancer.results.answers.answer import Answer
from autobalancer.shown import Column, rpm_and_si

STILL = 0.02  # rad from picture to picture


class BallFilm(Answer):
    """Angles of balls from a film."""

    __slots__ = ()
    drawn_by = "ball_film"
    row_of = "ball"
    needed = ()

    def has_table(self) -> bool:
        """Angles over time and ball must be there."""
        return "ball_angle" in self and self["ball_angle"].dims == ("time", "ball")

    def facts(self) -> list[tuple[str, str]]:
        """Pictures, faults, deviation, speed and what happened."""
        time, faults = self["time"].values, [str(text) for text in self["fault"].values if text]
        facts = [("pictures", f"{time.size} from {time[0]:.4g} s to {time[-1]:.4g} s, {len(faults)} with a fault")]
        first = next((k for k, text in enumerate(self["fault"].values) if text), None)
        if first is not None:
            facts.append(("first fault", f"picture {first + 1} at {time[first]:.6g} s: {self['fault'].values[first]}"))
        speed = self["speed"].values[np.isfinite(self["speed"].values)]
        if speed.size:
            facts.append(("rotor speed", f"{_rpm(speed[0])} to {rpm_and_si(float(speed[-1]))}"))
        if speed.size and time.size > 1 and float(np.median(speed) * np.median(np.diff(time))) < STILL:
            text = "the rotor seems to stand still or to turn backward; if a stroboscope makes it so, give first_speed"
            facts.append(("doubt", text))
        deviation = np.degrees(self["ball_angle_deviation"].values)
        if np.isfinite(deviation).any():
            facts.append(
                (
                    "angles",
                    f"standard deviation {np.nanmedian(deviation):.2g}° (median), at most {np.nanmax(deviation):.2g}°",
                )
            )
        if self.attrs.get("warnings"):
            facts.append(("doubt", str(self.attrs["warnings"])))
        facts.append(("impacts", f"{self.sizes.get('impact', 0)} between balls"))
        for at, name in zip(self["event_time"].values[:6], self["event_name"].values[:6], strict=True):
            facts.append(("event", f"{name} at {at:.4g} s"))
        if self.attrs.get("unsure_identities"):
            facts.append(("identity", f"not sure in {self.attrs['unsure_identities']} pictures: see identity_margin"))
        return facts

    def columns(self, unit: str = "") -> list[Column]:
        """The last angle of each ball."""
        angle, deviation = self["ball_angle"].values, self["ball_angle_deviation"].values
        rows = [np.flatnonzero(np.isfinite(column)) for column in angle.T]
        last = [int(row[-1]) if row.size else -1 for row in rows]
        wrapped = [(np.degrees(angle[k, i]) + 180.0) % 360.0 - 180.0 if k >= 0 else np.nan for i, k in enumerate(last)]
        sure = [np.degrees(deviation[k, i]) if k >= 0 else np.nan for i, k in enumerate(last)]
        return [
            Column("ball", self["ball"].values.tolist()),
            Column("seen in", [int(row.size) for row in rows]),
            Column("last angle in the rotor", wrapped, "°", ".2f"),
            Column("standard deviation", sure, "°", ".2g"),
        ]


def _rpm(speed: float) -> str:
    return f"{float(speed) * 30.0 / np.pi:.4g}"

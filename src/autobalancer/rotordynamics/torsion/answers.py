"""What the questions about torsion answer, as tables."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from autobalancer.results.answers.answer import Answer, at_speed
from autobalancer.shown import Column, rpm_and_si


class TorsionalModes(Answer):
    """Torsional natural frequencies."""

    __slots__ = ()
    row_of, needed, shown_in = "mode", ("name", "frequency", "damping_ratio", "angle_real"), "Hz"

    def columns(self, unit: str = "") -> list[Column]:
        """Name, frequency in ``unit``, damping ratio, and the angle of each part."""
        shape = [
            Column(str(part), self["angle_real"].values[:, i], form=".3g") for i, part in enumerate(self["part"].values)
        ]
        return [
            self.texts("name", "mode"),
            self.scaled("frequency", "frequency", unit),
            Column("damping ratio", 100.0 * self["damping_ratio"].values, "%", ".3g"),
            *shape,
        ]

    def remarks(self) -> Sequence[str]:
        """What is said where there is none."""
        return [*super().remarks(), *([] if self.sizes["mode"] else ["nothing oscillates"])]

    def heading(self) -> str:
        """Whose they are, and at which speed."""
        return f"{self.attrs.get('machine_name', 'drive')}: torsional natural frequencies {at_speed(self)}"


class TorsionalCriticalSpeeds(Answer):
    """Critical speeds of torsion."""

    __slots__ = ()
    row_of, needed = "critical", ("critical_speed", "harmonic", "name", "excited_by")

    def columns(self, unit: str = "") -> list[Column]:
        """Speed, order, shape and cause."""
        return [
            self.scaled("critical_speed", "critical speed", unit),
            Column("frequency over speed", self["harmonic"].values, form="g"),
            self.texts("name", "mode"),
            Column("excited by", [str(text) or "nothing here" for text in self["excited_by"].values], wraps=True),
        ]

    def damped_columns(self, unit: str = "") -> list[Column]:
        """Speed, order, shape and damping ratio where damped frequencies are met."""
        return [
            self.scaled("crossing_speed", "met at", unit),
            Column("frequency over speed", self["crossing_harmonic"].values, form="g"),
            self.texts("crossing_name", "mode"),
            Column("damping ratio", 100.0 * self["crossing_damping_ratio"].values, "%", ".3g"),
        ]

    def remarks(self) -> Sequence[str]:
        """Where frequencies with damping are met."""
        rows = zip(
            *(self[f"crossing_{name}"].values for name in ("speed", "harmonic", "name", "damping_ratio")), strict=True
        )
        met = [f"{rpm_and_si(w)} ({name}, {h:g} per turn, damping ratio {100.0 * d:.3g} %)" for w, h, name, d in rows]
        return [*super().remarks(), f"with damping: {'; '.join(met) or 'no frequency is met'}"]


class TorsionalResponse(Answer):
    """Torsion over the speed; the table has the greatest torque of each link."""

    __slots__ = ()
    drawn_by = "torsional_response"
    row_of, needed = "speed", ("link_torque", "twist")

    def columns(self, unit: str = "") -> list[Column]:
        """Each link and harmonic at the speed at which its torque is greatest."""
        torque = self["link_torque"].transpose("link", "harmonic", "speed").values
        rows = [(i, j, int(torque[i, j].argmax())) for i in range(torque.shape[0]) for j in range(torque.shape[1])]
        place = [at for *_, at in rows]
        twist = self["twist"].transpose("link", "harmonic", "speed").values
        at = self.isel(speed=place)
        return [
            Column("link", [str(self["link"].values[i]) for i, _, _ in rows], wraps=True),
            Column("frequency over speed", [float(self["harmonic"].values[j]) for _, j, _ in rows], form="g"),
            Column("greatest torque", np.array([torque[row] for row in rows]), "N m", ".4g"),
            Column("twist", np.degrees([twist[row] for row in rows]), "deg", ".4g"),
            at.scaled("speed", "at", unit),
        ]

    def has_table(self) -> bool:
        """Links, harmonics and speeds must be there."""
        return "link_torque" in self and set(self["link_torque"].dims) == {"speed", "harmonic", "link"}

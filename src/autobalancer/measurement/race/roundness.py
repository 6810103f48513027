"""Roundness of a race: a measured profile as a circle, its eccentricity, and waves with their uncertainty.

The profile r(phi) = R + sum of a_k cos(k (phi - alpha_k)) is fitted by least squares, so that points may stand at any angles.
Order 1 is the distance of the center from the axis of the measurement; from order 2 on the waves are those of the race. Waves
up to a number of undulations per revolution are kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from autobalancer.errors import QuestionError
from autobalancer.files.table import read_table
from autobalancer.results.answers.answer import Answer
from autobalancer.results.number_text import length_text
from autobalancer.results.provenance import provenance
from autobalancer.shown import Column
from autobalancer.units import texts_argument

Floats = NDArray[np.float64]
Center = Literal["axis", "setup"]
EXAMPLE = "angle [deg], radius [mm] (or: deviation [um])"
MOST = 60  # waves of a machine file
CLEAR = 3.0  # deviations from which on a wave is taken for one
FAR = 8.0  # robust standard deviations beyond which a point is no part of a race


def race_shape(
    angles: ArrayLike | str | Path,
    radii: ArrayLike | None = None,
    *,
    waves: int = 15,
    center: Center = "axis",
) -> RaceShape:
    """Circle, eccentricity and waves of a race from its measured profile.

    Parameters
    ----------
    angles
        In the rotor, rad, (n,), in any order over a whole turn; or a table with the columns ``angle`` and ``radius`` or
        ``deviation`` (of the radius).
    radii
        m, (n,), where angles are given.
    waves
        Undulations per revolution up to which the profile is kept.
    center
        Around what it was measured: ``"axis"`` of the rotor, so that order 1 is the eccentricity of the race; or a ``"setup"`` on
        which it was clamped anyhow, so that order 1 says nothing of the race and is taken away.

    Returns
    -------
    RaceShape
        Over ``order`` from 2: ``amplitude`` (m), ``crest`` (rad, of a crest in the rotor) and their one standard deviations; over
        ``point`` the ``profile`` without circle and eccentricity and what was ``fitted`` (m). ``radius``, ``eccentricity``,
        ``eccentricity_angle`` and deviations, ``roundness`` (greatest less least of the fitted profile, m) and ``scatter`` are
        attributes; ``machine_lines()`` has the lines of a machine file.

    Raises
    ------
    QuestionError
        If there are too few points, a gap in the turn is too wide, or a point lies far off; it names the angle.

    Source: least-squares circle and undulations per revolution as in ISO 12181; Spannan (2021), section 6.1.6.
    """
    phi, r, whole = _profile(angles, radii)
    if not 2 <= waves <= MOST:
        raise QuestionError(f"race_shape: waves: given {waves}; must be from 2 to {MOST}")
    if center not in ("axis", "setup"):
        raise QuestionError(f"race_shape: center: given {center!r}; must be 'axis' or 'setup'")
    order = np.argsort(phi)
    phi, r = phi[order], r[order]
    _check(phi, waves)
    rows = _rows(phi, waves)
    found = np.linalg.lstsq(rows, r, rcond=None)[0]
    left = r - rows @ found
    freedom = r.size - rows.shape[1]
    scatter = float(np.sqrt((left**2).sum() / freedom))
    robust = 1.4826 * float(np.median(np.abs(left)))
    worst = int(np.argmax(np.abs(left)))
    if robust > 0.0 and abs(left[worst]) > FAR * robust and abs(left[worst]) > 3.0 * scatter:
        raise QuestionError(
            f"race_shape: the point at {np.degrees(phi[worst]):.4g} deg is {1e6 * left[worst]:.3g} um off its neighbors, "
            f"{FAR:g} times as far "
            "as others scatter; dirt, or a wrong number: leave it out"
        )
    covariance = scatter**2 * np.linalg.inv(rows.T @ rows)
    return _answer(phi, r, rows, found, covariance, scatter, waves, center, whole)


def _profile(angles: ArrayLike | str | Path, radii: ArrayLike | None) -> tuple[Floats, Floats, bool]:
    """Angles, radii, and whether radii are whole ones and no deviations."""
    if isinstance(angles, (str, Path)):
        table = read_table(Path(angles), EXAMPLE)
        name = "radius" if "radius" in table.heads else "deviation"
        return np.mod(table.numbers("angle", "rad"), 2.0 * np.pi), table.numbers(name, "m"), name == "radius"
    phi = np.atleast_1d(np.asarray(texts_argument("angles", angles, "rad"), float))
    r = np.atleast_1d(np.asarray(texts_argument("radii", np.nan if radii is None else radii, "m"), float))
    if phi.ndim != 1 or phi.shape != r.shape or not (np.isfinite(phi).all() and np.isfinite(r).all()):
        raise QuestionError("race_shape: give as many finite radii as angles")
    return np.mod(phi, 2.0 * np.pi), r, bool(np.abs(r.mean()) > 10.0 * np.ptp(r))


def _check(phi: Floats, waves: int) -> None:
    least = 2 * waves + 3
    if phi.size < least:
        raise QuestionError(
            f"race_shape: given {phi.size} points; {waves} waves need at least {least}: measure more, or keep fewer waves"
        )
    gaps = np.diff(np.r_[phi, phi[0] + 2.0 * np.pi])
    wide = int(np.argmax(gaps))
    if gaps[wide] > 0.9 * np.pi / waves:
        raise QuestionError(
            f"race_shape: nothing was measured from {np.degrees(phi[wide]):.4g} to "
            f"{np.degrees(phi[wide] + gaps[wide]):.4g} deg; {waves} waves "
            f"need a point at least every {0.9 * 180.0 / waves:.3g} deg: measure there, or keep fewer waves"
        )


def _rows(phi: Floats, waves: int) -> Floats:
    k = np.arange(1, waves + 1)
    return np.concatenate([np.ones((phi.size, 1)), np.cos(np.outer(phi, k)), np.sin(np.outer(phi, k))], axis=1)


def _answer(
    phi: Floats,
    r: Floats,
    rows: Floats,
    found: Any,
    covariance: Any,
    scatter: float,
    waves: int,
    center: Center,
    whole: bool,
) -> RaceShape:
    k = np.arange(1, waves + 1)
    cosine, sine = found[1 : waves + 1], found[waves + 1 :]
    amplitude, crest = np.hypot(cosine, sine), np.arctan2(sine, cosine) / k
    spread = np.sqrt(0.5 * (np.diag(covariance)[1 : waves + 1] + np.diag(covariance)[waves + 1 :]))
    with np.errstate(divide="ignore"):
        turned = np.minimum(spread / np.where(amplitude > 0.0, amplitude, np.inf), np.pi / np.sqrt(3.0)) / k
    round_part = rows[:, [0, 1, waves + 1]] @ found[[0, 1, waves + 1]]
    fine = _rows(np.linspace(0.0, 2.0 * np.pi, 1440, endpoint=False), waves)
    shape = np.delete(fine, [0, 1, waves + 1], axis=1) @ np.delete(found, [0, 1, waves + 1])
    over, points = ("order",), ("point",)
    data = {
        "amplitude": (over, amplitude[1:], "amplitude of the wave", "m"),
        "amplitude_deviation": (over, spread[1:], "its standard deviation", "m"),
        "crest": (over, crest[1:], "angle of a crest in the rotor", "rad"),
        "crest_deviation": (over, turned[1:], "its standard deviation", "rad"),
        "profile": (points, r - round_part, "radius less circle and eccentricity", "m"),
        "fitted": (points, rows @ found - round_part, "sum of the waves", "m"),
    }
    answer = xr.Dataset(
        {name: (dims, values, {"long_name": text, "units": unit}) for name, (dims, values, text, unit) in data.items()},
        {
            "order": ("order", k[1:], {"long_name": "undulations per revolution", "units": "1"}),
            "angle": ("point", phi, {"long_name": "angle in the rotor", "units": "rad"}),
        },
    )
    warnings = []
    if scatter > 0.5 * max(amplitude[1:].max(), 1e-12):
        warnings.append(
            f"points scatter by {1e6 * scatter:.3g} um about {waves} waves, as much as the greatest wave: keep more "
            "waves, or measure better"
        )
    if center == "setup":
        warnings.append(f"an eccentricity of {1e6 * amplitude[0]:.3g} um of the setup was taken away")
    answer.attrs = {
        "title": "Shape of a race", **provenance(), "radius": float(found[0]) if whole else float("nan"),
        "radius_deviation": float(np.sqrt(covariance[0, 0])), "eccentricity": float(amplitude[0]),
        "eccentricity_angle": float(crest[0]), "eccentricity_deviation": float(spread[0]), "center": center,
        "roundness": float(np.ptp(shape)), "scatter": scatter, "waves": waves, "warnings": "\n".join(warnings),
    }  # fmt: skip
    return RaceShape.of(answer)


# The shape of a race as a table of its waves, and as lines of a machine file.


class RaceShape(Answer):
    """Waves of a measured race."""

    __slots__ = ()
    drawn_by = "race_shape"
    row_of = "order"
    needed: ClassVar[tuple[str, ...]] = ("amplitude", "crest")

    def columns(self, unit: str = "") -> list[Column]:
        """Amplitude and crest of each wave with their standard deviations."""
        turn = 180.0 / np.pi
        return [
            Column("waves", self["order"].values.tolist()),
            Column("amplitude", 1e6 * self["amplitude"].values, "µm", ".3g"),
            Column("+-", 1e6 * self["amplitude_deviation"].values, "µm", ".2g"),
            Column("crest at", np.mod(turn * self["crest"].values, 360.0 / self["order"].values), "deg", ".1f"),
            Column("+-", turn * self["crest_deviation"].values, "deg", ".2g"),
        ]

    def facts(self) -> list[tuple[str, str]]:
        """Circle, center and roundness."""
        told = [("roundness", f"{length_text(float(self.attrs['roundness']))} from the lowest to the highest point")]
        if np.isfinite(self.attrs["radius"]):
            radius, sure = 1e3 * float(self.attrs["radius"]), length_text(float(self.attrs["radius_deviation"]))
            told.append(("radius", f"{radius:.6g} mm +- {sure}"))
        of = "of the race" if self.attrs["center"] == "axis" else "of the setup, taken away"
        size, way = float(self.attrs["eccentricity"]), np.degrees(float(self.attrs["eccentricity_angle"])) % 360.0
        sure = length_text(float(self.attrs["eccentricity_deviation"]))
        told.append(("eccentricity", f"{length_text(size)} +- {sure} at {way:.0f} deg, {of}"))
        told.append(("points scatter by", length_text(float(self.attrs["scatter"]))))
        return told

    def has_table(self) -> bool:
        """The circle must be known, too."""
        return super().has_table() and {"radius", "eccentricity", "roundness", "scatter"} <= set(self.attrs)

    def machine_lines(self) -> str:
        """Lines for a race of a machine file: waves that are clear of their uncertainty, and the eccentricity of the race."""
        lines = []
        if np.isfinite(self.attrs["radius"]):
            lines.append(f'race_radius = "{1e3 * float(self.attrs["radius"]):.5f} mm"')
        if self.attrs["center"] == "axis" and self.attrs["eccentricity"] > CLEAR * self.attrs["eccentricity_deviation"]:
            lines.append(f'eccentricity = "{1e6 * float(self.attrs["eccentricity"]):.4g} um"')
            lines.append(
                f'eccentricity_angle = "{np.degrees(float(self.attrs["eccentricity_angle"])) % 360.0:.5g} deg"'
            )
        clear = self["amplitude"].values > CLEAR * self["amplitude_deviation"].values
        waves = [
            f'    {{ order = {int(k)}, amplitude = "{1e6 * a:.4g} um", angle = "{np.degrees(crest) % (360.0 / k):.5g} deg" }},'
            for k, a, crest, one in zip(
                self["order"].values, self["amplitude"].values, self["crest"].values, clear, strict=True
            )
            if one
        ]
        if waves:
            lines += ["harmonics = [", *waves, "]"]
        return "\n".join(lines) + "\n"

    def remarks(self) -> Sequence[str]:
        """What to be careful about."""
        return [line for line in str(self.attrs.get("warnings", "")).split("\n") if line]

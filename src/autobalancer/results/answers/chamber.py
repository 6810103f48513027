"""Studies of deep chambers as a table: the vertical amplitude over balls and friction."""

from __future__ import annotations

import json
from itertools import product

import numpy as np
import xarray as xr

from autobalancer.results.answers.answer import Answer
from autobalancer.results.display_units import length_axis
from autobalancer.tables import Column

SHOWN = "vertical_amplitude"


class ChamberStudy(Answer):
    """Measures of many runs over chambers, friction, and numbers of balls."""

    __slots__ = ()

    def columns(self, unit: str = "") -> list[Column]:
        """A row for each chamber and friction, a column for each number of balls; seeds are averaged."""
        values = self[SHOWN].mean("seed", skipna=True) if "seed" in self[SHOWN].dims else self[SHOWN]
        values = values.transpose("layers", "friction", ...)
        length = length_axis(None, float(np.nanmax(values.values, initial=0.0)))
        rows = list(product(self["layers"].values, self["friction"].values))
        table = values.values.reshape(len(rows), -1) * length.factor
        heads = [f"{count} balls" for count in self["balls"].values] if "balls" in values.dims else ["mean amplitude"]
        return [
            Column("chamber", [str(layer) for layer, _ in rows]),
            Column("friction", [float(friction) for _, friction in rows], form="g"),
            *(Column(head, table[:, k], length.sign, ".4g") for k, head in enumerate(heads)),
        ]

    def remarks(self) -> list[str]:
        """What the table has, and over what it is a mean."""
        over = f", mean over {self.sizes['seed']} seeds" if self.sizes.get("seed", 1) > 1 else ""
        return [f"the table has {SHOWN}{over}"]

    def has_table(self) -> bool:
        """The amplitude over chambers and friction must be there."""
        return SHOWN in self and {"layers", "friction"} <= set(self[SHOWN].dims) <= {
            "layers",
            "friction",
            "balls",
            "seed",
        }


# Designs of a deep chamber as a table: those that ran in full, the best first.


SIGNS = {"m": ("µm", 1e6), "kg m": ("g mm", 1e6), "Pa": ("MPa", 1e-6), "s": ("s", 1.0), "N": ("N", 1.0), "1": ("", 1.0)}


class ChamberDesigns(Answer):
    """Designs over their numbers: what they are, where they stopped and why, and what full runs of the best left."""

    __slots__ = ()
    drawn_by = "chamber_designs"

    def best(self) -> xr.Dataset:
        """Those that ran in full, the best first."""
        places = self["place"].values
        order = np.argsort(places)[: int(np.isfinite(places).sum())]
        return self.isel(design=order)

    def facts(self) -> list[tuple[str, str]]:
        """How many designs each stage left, and the limits."""
        stages = [str(stage) for stage in self["stage"].values]
        ruled = sum(
            bool(reason) and stage == "bounds" for stage, reason in zip(stages, self["reason"].values, strict=True)
        )
        ran = int(np.isfinite(self["place"].values).sum())
        counts = (
            f"{len(stages)}: closed forms ruled out {ruled}, short runs {len(stages) - ruled - ran}; {ran} ran in full"
        )
        limits = [
            f"{name.replace('_', ' ')} {_limit(self, name, value)}"
            for name, value in json.loads(self.attrs["limits"]).items()
        ]
        sizes = ", ".join(f"{1e6 * size:.6g}" for size in self["unbalance"].values)
        return [
            ("designs", counts),
            ("unbalance", f"{sizes} g mm"),
            ("limits", "; ".join(limits) if limits else "none"),
            ("meet all limits", str(int(self["meets"].sum()))),
        ]

    def columns(self, unit: str = "") -> list[Column]:
        """One row for each design that ran in full."""
        found = self.best()
        length = length_axis("um", 1.0)
        pick_up = [
            f"{100.0 * share:.0f} % ({100.0 * low:.0f} to {100.0 * high:.0f})"
            for share, low, high in zip(
                *(found[name].values for name in ("pick_up", "pick_up_low", "pick_up_high")), strict=True
            )
        ]
        fronts = zip(found["pareto_mass"].values, found["pareto_settling"].values, strict=True)
        return [
            Column("design", [str(text) for text in found["label"].values], wraps=True),
            Column("ball mass", found["total_mass"].values, "kg", ".3g"),
            Column("mean", found["vibration_mean"].values * length.factor, length.sign, ".4g"),
            Column("worst", found["worst_vibration"].values * length.factor, length.sign, ".4g"),
            Column("turning", found["worst_synchronous"].values * length.factor, length.sign, ".4g"),
            Column("carried", pick_up),
            Column("settled", found["worst_settling_time"].values, "s", ".3g"),
            Column("peak", 1e3 * found["worst_run_up_peak"].values, "mm", ".3g"),
            Column("bearing", found["worst_bearing_force"].values, "N", ".3g"),
            Column("hardest", 1e-3 * found["worst_contact_force"].values, "kN", ".3g"),
            Column(
                "Pareto",
                ["".join((" mass" if a else "", " settling" if b else "")).strip() or "-" for a, b in fronts],
                wraps=True,
            ),
            Column("misses", [str(text) or "-" for text in found["missed"].values], wraps=True),
        ]

    def remarks(self) -> list[str]:
        """What few runs allow to say."""
        runs = self.sizes["seed"]
        share, many = 100.0 * float(self.attrs["worse_than_worst"]), "filling" if runs == 1 else "fillings"
        return [
            f"{runs} {many}: at most {share:.0f} % of all fillings are worse than the worst one, with 95 % confidence; "
            f"ranges of shares have the same confidence"
        ]

    def in_si(self) -> xr.Dataset:
        """One row for each design."""
        return self.drop_dims(["unbalance", "seed"])

    def has_table(self) -> bool:
        """All designs with their places must be there."""
        return {"label", "place", "stage", "worst_vibration"} <= set(self) and self["label"].dims == ("design",)


def _limit(found: xr.Dataset, name: str, value: float) -> str:
    if name == "pick_up":
        return f"at least {100.0 * value:.3g} %"
    sign, factor = SIGNS[found[f"worst_{name}"].attrs["units"]]
    return f"at most {value * factor:.4g} {sign}"

"""What a study of a chamber says as a whole: means over seeds and over ranges, and what it takes to carry the balls."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from autobalancer.errors import QuestionError
from autobalancer.results.answers.chamber_study import ChamberStudy
from autobalancer.results.answers.labeled import Labeled

OPTIMAL = {"deep": (8, 50), "single": (3, 10)}  # ranges of figure 12 of Pakuła (2021)


def over_seeds(study: xr.Dataset) -> xr.Dataset:
    """Every measure of ``study`` as its mean over the seeds, ``<measure>_spread`` as their standard deviation, and ``runs``.

    A run that failed, or has no such measure, is left out; with fewer than two the spread is nan.
    """
    if "seed" not in study.dims:
        return study
    names = _measures(study)
    found = xr.Dataset(attrs=study.attrs)
    for name in names:
        found[name] = study[name].mean("seed", skipna=True, keep_attrs=True)
        found[f"{name}_spread"] = _spread(study[name])
    if names:
        found["runs"] = _counted(study[names[0]], "seed")
    return ChamberStudy.of(found)


def optimal_means(study: xr.Dataset, ranges: Mapping[str, tuple[int, int]] | None = None) -> xr.Dataset:
    """Means of the amplitudes over the numbers of balls in a range for each of ``layers`` (Pakuła 2021, figure 12).

    ``ranges`` has the least and the greatest number of each of the ``layers`` of ``study``; by default those of the source.

    Returns
    -------
    xarray.Dataset
        Over ``layers`` and ``friction``: means of the amplitudes over balls and seeds, ``<amplitude>_spread``, the standard
        deviation over the seeds of the mean of one seed, and ``runs``, how many of the study are in each.

    Raises
    ------
    QuestionError
        If the study has no number of balls in a range.
    """
    chosen = {**OPTIMAL, **(ranges or {})}
    names = [name for name in _measures(study) if name.endswith(("_amplitude", "_synchronous"))]
    several = study if "seed" in study.dims else study[names].expand_dims(seed=[0])
    pieces = []
    for layer in study["layers"].values:
        low, high = chosen[str(layer)]
        within = several[names].sel(layers=layer, balls=(study["balls"] >= low) & (study["balls"] <= high))
        if within.sizes["balls"] == 0:
            raise QuestionError(f"ranges: the study has no number of balls from {low} to {high} for {str(layer)!r}")
        each = within.mean("balls", skipna=True, keep_attrs=True)
        mean = each.mean("seed", skipna=True, keep_attrs=True)
        for name in names:
            mean[f"{name}_spread"] = _spread(each[name])
        mean["runs"] = _counted(within[names[0]], "balls", "seed")
        pieces.append(mean)
    return ChamberStudy.of(xr.concat(pieces, "layers", coords="minimal", compat="override"))


def pick_up_borders(study: xr.Dataset, share: float = 0.9) -> xr.Dataset:
    """The least friction and number of balls at which balls are carried around instead of staying at the bottom.

    Parameters
    ----------
    study
        From :func:`amplitudes`.
    share
        Share of the balls that must go around, in the mean over the seeds.

    Returns
    -------
    xarray.Dataset
        ``least_friction`` over ``layers`` and ``balls``, and ``least_balls`` over ``layers`` and ``friction``: the least
        values of the study with which they do; nan where none of them is enough.
    """
    if not 0.0 < share <= 1.0:
        raise QuestionError(f"share: given {share:g}; must be above 0, at most 1")
    carried = over_seeds(study)["share_carried"] >= share
    found = xr.Dataset()
    for name, along in (("least_friction", "friction"), ("least_balls", "balls")):
        least = study[along].where(carried).min(along, skipna=True)
        found[name] = least.assign_attrs(long_name=f"least {along} with which {share:.0%} of the balls go around")
    return Labeled.of_run(study, "Borders of being carried", found)


def _measures(study: xr.Dataset) -> list[str]:
    return [str(name) for name, values in study.data_vars.items() if values.dtype.kind == "f"]


def _counted(values: xr.DataArray, *over: str) -> xr.DataArray:
    return values.notnull().sum(over).drop_attrs().assign_attrs(units="1", long_name="number of runs")


def _spread(values: xr.DataArray) -> xr.DataArray:
    enough = values.notnull().sum("seed") > 1
    # where there is one run, or none, numpy would warn of what is meant
    with np.errstate(invalid="ignore", divide="ignore"):
        spread = values.where(enough, 0.0).std("seed", ddof=min(1, values.sizes["seed"] - 1), skipna=True)
    units = values.attrs.get("units", "")
    return spread.where(enough).assign_attrs(units=units, long_name="standard deviation over the seeds")

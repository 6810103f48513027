"""Which scatter drives the scatter of a result: Sobol' indices of a plan made for them, rank correlations of any other."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from autobalancer.errors import QuestionError
from autobalancer.machine.path import dimension_of
from autobalancer.random_numbers import generator
from autobalancer.results.answers.studied import Sensitivity, Studied
from autobalancer.results.provenance import provenance
from autobalancer.results.shares import Z
from autobalancer.studies.study.spec import START, Study

Floats = NDArray[np.float64]
RESAMPLED = 500  # bootstrap samples of an interval
FEWEST = 20  # draws
SPEARMAN = 1.06  # variance of Fisher's z of a rank correlation, times n - 3 (Fieller, Hartley and Pearson 1957)


def sensitivity(study: xr.Dataset, quantity: str) -> Sensitivity:
    """How much each input of a study adds to the scatter of a quantity.

    Parameters
    ----------
    study
        A result of :func:`autobalancer.study`. With ``plan = "sensitivity"`` there are Sobol' indices, else rank correlations.
    quantity
        A number of each member, such as ``"peak_deflection"``, ``"settling_time"`` or ``"balanced"``.

    Returns
    -------
    xarray.Dataset
        Over ``input``, with a grid also over ``point``. Sobol' indices: ``first`` (share of the variance by the input alone) and
        ``total`` (share that is gone if it is known, with all in which it takes part). Else ``rank_correlation``
        (Spearman). Each with ``_low`` and ``_high``, the ends of its 95 % interval. ``attrs["draws"]`` says how many counted.

    Raises
    ------
    QuestionError
        If the study has no such quantity, nothing in it scatters, too few draws have a number, or all numbers are equal.

    Notes
    -----
    Sobol' indices by Saltelli et al. (2010) for the first and Jansen (1999) for the total, with intervals by bootstrap.
    Random starts of the balls are one input, ``start``. Draws without a number do not count.
    """
    known = [
        str(name) for name in study.data_vars if study[name].dims == ("member",) and study[name].dtype.kind in "fib"
    ]
    if quantity not in known:
        raise QuestionError(f"quantity: given {quantity!r}; this study has {', '.join(known)}")
    inputs = list(map(str, np.atleast_1d(study.attrs.get("inputs", []))))  # a file keeps a list of one as a text
    sobol = study.attrs.get("plan") == "sensitivity"
    columns = {} if sobol else {name: study[_dimension(name)].values for name in inputs if name != START}
    _refuse_inputs(inputs, sobol, [name for name, values in columns.items() if values.dtype.kind not in "fi"])
    points = np.unique(study["point"].values)
    found = [
        (_indices if sobol else _ranks)(
            study.isel(member=np.flatnonzero(study["point"].values == point)), quantity, inputs
        )
        for point in points
    ]
    inputs = inputs if sobol else [name for name in inputs if name != START]
    result = xr.Dataset(
        coords={"input": ("input", [_dimension(name) for name in inputs]), "point": ("point", points)},
        attrs={
            "title": f"Sensitivity of {quantity}",
            **provenance(),
            "quantity": quantity,
            "quantity_text": str(study[quantity].attrs.get("long_name", quantity)),
            "study_name": study.attrs.get("study_name", "study"),
            "draws": [int(one.pop("draws")) for one in found],
            "remarks": [] if sobol else _remarks(study),
        },
    )
    for name in found[0]:
        result[name] = (
            ("point", "input"),
            np.array([one[name] for one in found]),
            {"long_name": TEXTS[name], "units": "1"},
        )
    if isinstance(study, Studied) and points.size > 1:
        result = result.assign_coords(at=("point", study.point_texts()))
    if points.size == 1:
        result = result.isel(point=0, drop=True)
    return Sensitivity.of(result)


def _remarks(study: xr.Dataset) -> list[str]:
    """What rank correlations leave out."""
    found = []
    if START in np.atleast_1d(study.attrs.get("inputs", [])):
        found.append("random starts of the balls are not among the inputs; with plan = 'sensitivity' they are")
    if json.loads(study.attrs.get("study", "{}")).get("correlation"):
        found.append("inputs that were drawn together borrow rank correlation from one another")
    return found


TEXTS = {
    f"{name}{end}": f"{text}{words}"
    for name, text in (
        ("first", "share of the variance by the input alone"),
        ("total", "share of the variance in which the input takes part"),
        ("rank_correlation", "rank correlation (Spearman)"),
    )
    for end, words in (
        ("", ""),
        ("_low", ", lower end of its 95 % interval"),
        ("_high", ", upper end of its 95 % interval"),
    )
}


def _indices(study: xr.Dataset, quantity: str, inputs: list[str]) -> dict[str, Any]:
    width = len(inputs) + 2
    values = study[quantity].values.astype(float)
    values = values[: values.size // width * width].reshape(-1, width)
    values = values[np.isfinite(values).all(axis=1)]
    count = values.shape[0]
    _enough(count, values, quantity)
    first, total = _of(values)
    take = generator(0).integers(0, count, (RESAMPLED, count))
    again = np.array([_of(values[rows]) for rows in take])  # (resampled, 2, inputs)
    low, high = np.quantile(again, (0.025, 0.975), axis=0)
    return {
        "first": first,
        "first_low": low[0],
        "first_high": high[0],
        "total": total,
        "total_low": low[1],
        "total_high": high[1],
        "draws": count,
    }


def _of(values: Floats) -> tuple[Floats, Floats]:
    """First and total indices from runs with the inputs A, B and A with one of B, (samples, inputs + 2)."""
    middle = values[:, :2].mean()
    a, b, changed = values[:, :1] - middle, values[:, 1:2] - middle, values[:, 2:] - middle
    variance = values[:, :2].var()
    if not variance > 0.0:
        return np.zeros(changed.shape[1]), np.zeros(changed.shape[1])
    return (b * (changed - a)).mean(axis=0) / variance, ((a - changed) ** 2).mean(axis=0) / (2.0 * variance)


def _ranks(study: xr.Dataset, quantity: str, inputs: list[str]) -> dict[str, Any]:
    from scipy.stats import spearmanr

    values = study[quantity].values.astype(float)
    known = np.isfinite(values)
    count = int(known.sum())
    _enough(count, values[known], quantity)
    columns = [study[_dimension(name)].values[known] for name in inputs if name != START]
    middle = np.array([float(spearmanr(column, values[known]).statistic) for column in columns])
    half = Z * np.sqrt(SPEARMAN / (count - 3))
    z = np.arctanh(np.clip(middle, -1.0 + 1e-15, 1.0 - 1e-15))
    return {
        "rank_correlation": middle,
        "rank_correlation_low": np.tanh(z - half),
        "rank_correlation_high": np.tanh(z + half),
        "draws": count,
    }


def refuse_without_sensitivity(study: Study) -> None:
    """Refuse a study that :func:`sensitivity` could say nothing of, before it runs.

    Raises
    ------
    QuestionError
        If nothing scatters that can be ranked, or there are too few draws.
    """
    texts = [name for name, one in study.scatter.items() if any(isinstance(v, str) for v in getattr(one, "values", ()))]
    _refuse_inputs(study.inputs, study.plan == "sensitivity", texts)
    if study.members < FEWEST:
        raise QuestionError(f"sensitivity: members: given {study.members}; at least {FEWEST} are needed")


def _refuse_inputs(inputs: list[str], sobol: bool, texts: list[str]) -> None:
    if not inputs:
        raise QuestionError("sensitivity: nothing scatters in this study; give distributions under 'vary'")
    if not sobol and set(inputs) == {START}:
        raise QuestionError(
            "sensitivity: only starts are random here; the plan 'sensitivity' says what they add, and distributions under 'vary' "
            "are ranked by any plan"
        )
    if not sobol and texts:
        raise QuestionError(f"sensitivity: {texts[0]!r} has texts, which have no ranks; take the plan 'sensitivity'")


def _enough(count: int, values: Floats, quantity: str) -> None:
    if count < FEWEST:
        raise QuestionError(f"quantity {quantity!r}: only {count} draws have a number; at least {FEWEST} are needed")
    if not np.ptp(values) > 0.0:
        raise QuestionError(f"quantity {quantity!r}: is the same in all draws, so nothing drives its scatter")


def _dimension(name: str) -> str:
    return name if name == START else dimension_of(name)

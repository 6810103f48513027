"""Files of balancing runs: TOML, every quantity with its unit or in SI."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.text import read_toml
from autobalancer.machine.part import unknown_key
from autobalancer.measurement.balancing.runs import BalanceRun, Reading, TrialMass

TOP = ("name", "description", "phase", "angles", "deviation", "runs")
RUN = ("name", "readings", "masses", "trim")
READING = ("amplitude", "phase", "sensor", "speed", "amplitude_deviation", "phase_deviation")
MASS = ("plane", "mass", "angle")


def load_balance_runs(path: str | Path) -> tuple[BalanceRun, ...]:
    """Read the runs of a balancing job.

    Parameters
    ----------
    path
        A TOML file with a list ``runs``; the keys of its entries are those of :class:`~autobalancer.measure.BalanceRun`, of its
        lists ``readings`` and ``masses`` those of :class:`~autobalancer.measure.Reading` and
        :class:`~autobalancer.measure.TrialMass`. ``phase``, ``angles`` and ``deviation`` may stand above them, and mean what
        they mean in :func:`~autobalancer.measure.balance`.

    Raises
    ------
    QuestionError
        If the file or an entry cannot be read; it names the run.
    """
    return given_runs(path)[0]


def given_runs(runs: Sequence[BalanceRun] | str | Path) -> tuple[tuple[BalanceRun, ...], dict[str, Any]]:
    """Runs, and what else a file says of all of them."""
    if not isinstance(runs, (str, Path)):
        return tuple(runs), {}
    path = Path(runs)
    data = read_toml(path)
    _check(data, TOP, f"{path}")
    entries = _tables(data, "runs", f"{path}")
    if not entries:
        raise QuestionError(f"{path}: no runs; write each one under its own line [[runs]]")
    found = []
    for number, entry in enumerate(entries, 1):
        where = f"{path}: run {str(entry.get('name', number))!r}"
        _check(entry, RUN, where)
        found.append(
            BalanceRun(
                str(entry.get("name", number)),
                [
                    _made(Reading, one, READING, ("amplitude",), f"{where}: readings[{n}]")
                    for n, one in _each(entry, "readings", where)
                ],
                [
                    _made(TrialMass, one, MASS, ("plane", "mass"), f"{where}: masses[{n}]")
                    for n, one in _each(entry, "masses", where)
                ],
                bool(entry.get("trim", False)),
            )
        )
    return tuple(found), {key: data[key] for key in ("name", "phase", "angles", "deviation") if key in data}


def _each(entry: dict[str, Any], key: str, where: str) -> list[tuple[int, dict[str, Any]]]:
    return list(enumerate(_tables(entry, key, where), 1))


def _tables(entry: dict[str, Any], key: str, where: str) -> list[dict[str, Any]]:
    found = entry.get(key, [])
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise QuestionError(f"{where}: {key}: must be a list of tables, such as {key} = [{{ ... }}]")
    return found


def _check(entry: dict[str, Any], allowed: tuple[str, ...], where: str) -> None:
    for key in entry:
        if key not in allowed:
            raise QuestionError(f"{where}: {key}: {unknown_key(key, allowed)}")


def _made(kind: Any, entry: dict[str, Any], allowed: tuple[str, ...], needed: tuple[str, ...], where: str) -> Any:
    _check(entry, allowed, where)
    for key in needed:
        if key not in entry:
            raise QuestionError(f"{where}: {key}: missing; it has no default")
    try:
        return kind(**entry)
    except AutobalancerError as error:
        raise type(error)(f"{where}: {error}") from None

"""Kinds of machines, balls in races and deep chambers: how one is recognized, and what answers for it, in one table.

A further kind is an entry here. What answers is named by its module and imported when it is used.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from inspect import signature, unwrap
from typing import Any

from autobalancer.errors import QuestionError


@dataclass(frozen=True)
class Kind:
    """One kind of machine.

    Attributes
    ----------
    words
        What it is called in a message.
    machine
        Class of its machines, with its module.
    key
        Key that tells its machine files; empty of the kind that a file is of without such a key.
    variable
        Variable that tells its runs, likewise.
    run
        Class of its runs.
    instead
        What is said of a machine of this kind where a question is for another kind.
    homes
        By the name of a question the function that answers it, with its module.
    measures
        By its name what ``run_measures`` gives alone, over time or at every place.
    """

    words: str
    machine: str
    key: str
    variable: str
    run: str
    instead: str
    homes: Mapping[str, str]
    measures: Mapping[str, str]

    def __getitem__(self, question: str) -> Callable[..., Any]:
        function: Callable[..., Any] = _imported({**self.measures, **self.homes}[question])
        return function

    @property
    def part(self) -> Any:
        """Class of its machines."""
        return _imported(self.machine)

    def answer(self, name: str, subject: Any, options: Mapping[str, Any]) -> Any:
        """What the function of a question says of a machine or run.

        Raises
        ------
        QuestionError
            For an option that it does not have; the message lists those that there are.
        """
        function = self[name]
        refuse_unknown(name, options, arguments_of(function)[1:], self.words)
        return function(subject, **options)


RACES = Kind(
    "balls in races",
    "machine.machine.Machine",
    "",
    "",
    "Run",
    "its balls run in races, and this question is for deep chambers, which have 'chambers' in their file, as the sample "
    "deep_chamber; for races there are sweep and basin",
    {
        "simulate": "simulation.run.simulate_races",
        "check": "stability.summary.summary",
        "verdict": "results.verdict.verdict",
        "design": "studies.design.design.design",
        "run_measures": "results.measure_table.measures",
        "scene": "plots.animation.race_scene",
        "picture": "plots.run.run_up.run_up",
        "row": "studies.compare.race_row",
        "layout": "sketch.layout_of",
        "packed": "app.view.packed.packed_races",
    },
    {
        **{
            name: f"results.time_series.{name}"
            for name in ("vibration", "static_deflection", "residual_unbalance", "support_forces")
        },
        **{
            name: f"results.measure_table.{name}"
            for name in (
                "deflection_envelope",
                "residual_vibration",
                "peak_deflection",
                "settling_time",
                "break_away_speed",
                "ball_angle_to_unbalance",
            )
        },
    },
)
CHAMBERS = Kind(
    "deep chambers",
    "machine.chamber.ChamberMachine",
    "chambers",
    "body_position",
    "ChamberRun",
    "its balls move freely in chambers, and this question is for balls in races. For chambers there are check, simulate, "
    "plot and animate, and for many runs chamber amplitudes (in Python ab.chamber.amplitudes)",
    {
        "simulate": "simulation.chamber.chamber_run.simulate_chamber",
        "check": "simulation.chamber.chamber_summary.chamber_summary",
        "verdict": "simulation.chamber.chamber_verdict.chamber_verdict",
        "design": "studies.design.chambers.chamber_design",
        "run_measures": "results.chamber_measures.chamber_measures",
        "scene": "plots.chamber_view.chamber_scene",
        "picture": "plots.chamber_runs.chamber_run",
        "row": "studies.compare.chamber_row",
        "layout": "sketch.chamber_layout",
        "packed": "app.view.packed.packed_chamber",
    },
    {
        name: f"results.chamber_measures.{name}"
        for name in ("collision_statistics", "balls_unbalance", "residual_of_balls")
    },
)


def machine_kind(thing: Any) -> Kind:
    """The kind of a machine, of its class, of the content of a machine file, or of a run."""
    if isinstance(thing, Mapping):  # datasets are such, too
        mark = CHAMBERS.variable if hasattr(thing, "data_vars") else CHAMBERS.key
        return CHAMBERS if mark in thing else RACES
    name = (thing if isinstance(thing, type) else type(thing)).__name__
    return CHAMBERS if name == CHAMBERS.machine.rpartition(".")[2] else RACES


def arguments_of(function: Callable[..., Any]) -> list[str]:
    """Names of the arguments of a function, also of those that it takes by a record of options."""
    names: list[str] = []
    for parameter in signature(function).parameters.values():
        if parameter.kind is parameter.VAR_KEYWORD:
            record = str(parameter.annotation).removeprefix("Unpack[").removesuffix("]")
            names += unwrap(function).__globals__[record].__annotations__
        else:
            names.append(parameter.name)
    return names


def refuse_unknown(name: str, options: Mapping[str, Any], known: Sequence[str], words: str) -> None:
    """Refuse options that a question to what is called ``words`` does not have.

    Raises
    ------
    QuestionError
        With those that there are.
    """
    for option in options:
        if option not in known:
            raise QuestionError(f"{name}: no argument {option!r} for {words}; there are {', '.join(known)}")


def _imported(home: str) -> Any:
    module, _, name = home.rpartition(".")
    return getattr(import_module(f"autobalancer.{module}"), name)

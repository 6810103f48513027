"""Paths into a machine, such as ``balancers[1].races[1].drag.damping``: value, unit, label and dimension."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator
from difflib import get_close_matches
from itertools import pairwise
from typing import Any, NamedTuple

from autobalancer.errors import QuestionError
from autobalancer.machine import DiscoidalDrag, ViscousDrag
from autobalancer.machine.balancer.fluid import Fluid
from autobalancer.machine.balancer.race import Balls
from autobalancer.machine.balancer.resolved import Friction
from autobalancer.machine.keys import parts_at
from autobalancer.machine.machine import Machine, Unbalance
from autobalancer.machine.part import Part, quantity_of, symbol_of
from autobalancer.machine.rotors.planar import PlanarRotor

_STEP = re.compile(r"([a-z_]+)((?:\[\d+\])*)")


def path_steps(path: str) -> list[str | int]:
    """Keys and places of a path; places are counted from 0.

    Raises
    ------
    QuestionError
        If it cannot be read.
    """
    steps: list[str | int] = []
    for piece in path.split("."):
        match = _STEP.fullmatch(piece)
        if match is None:
            raise QuestionError(
                f"parameter {path!r}: cannot read {piece!r}; write it like 'balancers[1].races[1].drag.damping'"
            )
        steps.append(match[1])
        steps += [int(number) - 1 for number in re.findall(r"\d+", match[2])]
    return steps


def entry_at(machine: Part, path: str) -> Any:
    """What stands at a path: a number, a text, a part, a tuple of parts.

    Raises
    ------
    QuestionError
        If there is nothing; the message says what there is, and which paths may have been meant.
    """
    owner: Any = machine
    for step in path_steps(path):
        _refuse(machine, owner, step, path)
        owner = getattr(owner, step) if isinstance(step, str) else owner[step]
    return owner


def with_entry(machine: Part, path: str, value: Any) -> Any:
    """A copy with ``value`` at a path; only what the path goes through is made and checked again.

    Raises
    ------
    QuestionError
        If there is nothing at the path.
    MachineError
        If the value is impossible there.
    """
    return _changed(machine, machine, path_steps(path), value, path)


def unit_at(path: str, root: type[Part] = Machine) -> str:
    """SI unit of the entry at a path of any machine; empty for a plain number, or where no machine has such an entry."""
    held = (quantity_of(part, key) for part, key in _keys_at(path, root))
    return next((quantity.unit for quantity in held if quantity is not None), "")


def bounds_at(path: str, root: type[Part] = Machine) -> tuple[float, float]:
    """Least and greatest value of the entry at a path of any machine; infinite where it has none."""
    held = (quantity_of(part, key) for part, key in _keys_at(path, root))
    bounds = next((quantity for quantity in held if quantity is not None), None)
    if bounds is None:
        return -math.inf, math.inf
    return sys.float_info.min if bounds.positive else 0.0 if bounds.non_negative else -math.inf, bounds.most


def symbol_at(path: str, root: type[Part] = Machine) -> str:
    """Symbol of the key at a path of any machine (LaTeX); empty where there is none."""
    return next((symbol for part, key in _keys_at(path, root) if (symbol := symbol_of(part, key))), "")


def _keys_at(path: str, root: type[Part]) -> list[tuple[type[Part], str]]:
    """The parts that may hold the last key of a path, and this key."""
    parts: tuple[type[Part], ...] = (root,)
    result: list[tuple[type[Part], str]] = []
    try:
        steps = path_steps(path)
    except QuestionError:
        return []
    for step in steps:
        if isinstance(step, str):
            result = [(part, step) for part in parts if step in part.model_fields]
            parts = tuple(inner for part, key in result for inner in parts_at(part, key))
    return result


def label_of_path(path: str) -> str:
    """What a person calls it: ``drag damping of race 1, balancer 1``, ``stiffness of support 2``, ``rotor damping``."""
    steps = path_steps(path)
    if isinstance(steps[-1], int):
        return path
    lists = [
        f"{_one(key)} {place + 1}" for key, place in pairwise(steps) if isinstance(key, str) and isinstance(place, int)
    ]
    last = max((i for i, step in enumerate(steps) if isinstance(step, int)), default=-1)
    inner = [str(step).replace("_", " ") for step in steps[last + 1 :]]
    return " ".join(inner) + (f" of {', '.join(reversed(lists))}" if lists else "")


def dimension_of_path(path: str) -> str:
    """Its name as a dimension of a dataset."""
    return path.replace("[", "_").replace("]", "").replace(".", "_")


def _one(key: Any) -> str:
    word = str(key).replace("_", " ")
    return {"bodies": "body", "balls": "ball group"}.get(word, word.removesuffix("s"))


def _refuse(machine: Part, owner: Any, step: str | int, path: str) -> None:
    if isinstance(step, str):
        if not isinstance(owner, Part) or step not in type(owner).model_fields:
            raise QuestionError(f"parameter {path!r}: no {step!r} there; {_there(owner)}{did_you_mean(machine, path)}")
    elif not isinstance(owner, tuple) or not 0 <= step < len(owner):
        count = len(owner) if isinstance(owner, tuple) else 0
        raise QuestionError(f"parameter {path!r}: entry {step + 1} does not exist; there are {count}, counted from 1")


def _there(owner: Any) -> str:
    """What a part has in place of a key that it has not."""
    if isinstance(owner, Part):
        return f"there is {', '.join(type(owner).model_fields)}"
    if isinstance(owner, tuple) and owner and isinstance(owner[0], Part):
        return f"it is a list; choose an entry, [1]{'' if len(owner) == 1 else f' to [{len(owner)}]'}"
    return "there is nothing"


def _changed(machine: Part, owner: Any, steps: list[str | int], value: Any, path: str) -> Any:
    if not steps:
        return value
    step, rest = steps[0], steps[1:]
    _refuse(machine, owner, step, path)
    if isinstance(step, str):
        entry = _changed(machine, getattr(owner, step), rest, value, path)
        return type(owner)(**{**{key: getattr(owner, key) for key in owner.model_fields_set}, step: entry})
    return (*owner[:step], _changed(machine, owner[step], rest, value, path), *owner[step + 1 :])


# The paths of a machine that somebody may have meant by a name that is none.


MOST = 4  # paths in one message


def did_you_mean(machine: Part, path: str) -> str:
    """The end of a message: ``"; did you mean 'drive.profile.speed'?"``; empty where nothing is near."""
    key = path.rpartition(".")[2].partition("[")[0]
    paths = list(parameter_paths(machine))
    keys = {place.rpartition(".")[2].partition("[")[0] for place in paths}
    inside = sorted(other for other in keys if len(key) > 2 and (f"_{key}" in other or f"{key}_" in other))
    near = [key] if key in keys else [*inside, *get_close_matches(key, keys - set(inside), n=2, cutoff=0.8)]
    suggestions = [place for one in near for place in paths if place.rpartition(".")[2].partition("[")[0] == one]
    if not suggestions:
        return ""
    more = f" (and {len(suggestions) - MOST} more)" if len(suggestions) > MOST else ""
    return f"; did you mean {' or '.join(map(repr, suggestions[:MOST]))}{more}?"


def parameter_paths(owner: Any, start: str = "") -> Iterator[str]:
    """Paths of all entries, entries counted from 1; of lists of numbers the whole list."""
    if isinstance(owner, Part):
        for key in type(owner).model_fields:
            path = f"{start}.{key}" if start else key
            yield path
            yield from parameter_paths(getattr(owner, key), path)
    elif isinstance(owner, tuple):
        for number, entry in enumerate(owner, start=1):
            if isinstance(entry, Part):
                yield f"{start}[{number}]"
                yield from parameter_paths(entry, f"{start}[{number}]")


# Plain names of quantities, such as ``viscosity``, and what an axis calls a parameter: text, unit and symbol of its
# key.


JOINT_MARK = "&"  # joins quantities and paths that change in proportion


class PlainName(NamedTuple):
    """What a quantity is called, and the key from which unit and symbol come."""

    text: str
    part: type[Part]
    key: str

    @property
    def unit(self) -> str:
        """SI, empty for a plain number."""
        quantity = quantity_of(self.part, self.key)
        return quantity.unit if quantity is not None else ""


QUANTITIES = {
    "viscosity": PlainName("kinematic viscosity of the fluid", Fluid, "viscosity"),
    "drag": PlainName("drag torque of a ball over its speed", ViscousDrag, "damping"),
    "ball_mass": PlainName("mass of a ball", Balls, "mass"),
    "ball_diameter": PlainName("diameter of a ball", Balls, "diameter"),
    "count": PlainName("number of balls", Balls, "count"),
    "unbalance": PlainName("unbalance", Unbalance, "moment"),
    "damping": PlainName("damping of the supports", PlanarRotor, "damping"),
    "stiffness": PlainName("stiffness of the supports", PlanarRotor, "stiffness"),
    "temperature": PlainName("temperature of the fluid", Fluid, "temperature"),
    "plateau": PlainName("drag coefficient at high Reynolds numbers", DiscoidalDrag, "plateau"),
    "rolling_resistance": PlainName("rolling resistance of the balls", Friction, "rolling_resistance"),
}


def parts_of(name: str) -> list[str]:
    """The quantities and paths that change together under one name."""
    return [part.strip() for part in name.split(JOINT_MARK)]


def text_of(name: str) -> str:
    """What a person calls a quantity or path."""
    first, *others = parts_of(name)
    if others:
        return f"{text_of(first)} (in proportion: {', '.join(map(text_of, others))})"
    if name in QUANTITIES:
        return QUANTITIES[name].text
    return "rotor speed" if name == "speed" else label_of_path(name)


def si_unit_of(name: str) -> str:
    """SI unit of a quantity or path, of several the first; empty for a plain number and where no machine has such an entry."""
    name, *_ = parts_of(name)
    if name in QUANTITIES:
        return QUANTITIES[name].unit
    return "rad/s" if name == "speed" else unit_at(name)


def axis_attributes(name: str) -> dict[str, str]:
    """Attributes of a coordinate along which a parameter changes: ``long_name``, ``units`` and, if it has one, ``symbol``."""
    axis_attributes = {"long_name": text_of(name), "units": si_unit_of(name).replace("*", " ")}
    known = QUANTITIES.get(name)
    symbol = "" if len(parts_of(name)) > 1 else symbol_of(known.part, known.key) if known else symbol_at(name)
    return {**axis_attributes, "symbol": symbol} if symbol else axis_attributes


def dimension_of(name: str) -> str:
    """The name of a quantity or path as a dimension of a dataset."""
    return "_and_".join(map(dimension_of_path, parts_of(name)))

"""What all parts of a machine have in common: frozen, complete, checked, and honest about what is wrong."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self, get_args

from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    PlainValidator,
    Tag,
    ValidationError,
    model_validator,
)
from pydantic.fields import FieldInfo
from pydantic_core import CoreSchema, core_schema

from autobalancer.errors import AutobalancerError, KeyPath, MachineError, Problem, QuestionError, UnitError
from autobalancer.units import shortened, to_si
from autobalancer.units.quantity import ends, is_range, range_values


class Part(BaseModel):
    """A frozen, validated piece of a machine; all numbers in SI, written with a unit if wished."""

    model_config = ConfigDict(frozen=True, extra="forbid", validate_default=False)
    refused_as: ClassVar[type[AutobalancerError]] = MachineError

    def __init__(self, **data: Any) -> None:
        try:
            super().__init__(**data)
        except ValidationError as error:
            raise self.refused_as.of(type(self).__name__, _problems(error, type(self))) from None

    def __setattr__(self, name: str, value: Any) -> None:
        if name in type(self).model_fields:
            raise MachineError(
                f"{type(self).__name__}.{name}: given {shortened(value)}; a machine is not changed in place. Take "
                "ab.with_parameter(machine, path, value), which gives a changed copy, such as "
                "ab.with_parameter(machine, 'rotor.mass', '12 kg')"
            )
        super().__setattr__(name, value)


class Question(Part):
    """A table of a file that asks something, such as a study: read and checked as the parts of a machine are.

    In Python its values may also be given in the order of their keys.
    """

    refused_as = QuestionError

    def __init__(self, *values: Any, **data: Any) -> None:
        super().__init__(**dict(zip(list(type(self).model_fields)[: len(values)], values, strict=True)), **data)

    def contradictions(self) -> Iterable[Problem]:
        """All that its keys say and that cannot be together: the path and what is wrong there."""
        return ()

    @model_validator(mode="after")
    def _goes_together(self) -> Self:
        if problems := list(self.contradictions()):
            raise QuestionError.of("", problems)
        return self


_TAGGED = {"rotor", "drive", "profile"}  # fields whose kind pydantic puts into the path
_TAGGED_LISTS = {"excitations"}  # ... and those in which it follows the number of an entry
_TAGGED_PAIRS = {("contact", "restitution"), ("contact", "history")}  # ... a field that has a tag in some machines only


def _problems(error: ValidationError, part: type[BaseModel]) -> list[Problem]:
    problems: list[Problem] = []
    short: list[Problem] = []
    for entry in error.errors():
        path = tuple(step for number, step in enumerate(entry["loc"]) if not _is_tag(entry["loc"], number))
        cause = entry.get("ctx", {}).get("error")
        if isinstance(cause, AutobalancerError):
            problems += [(path + inner, message) for inner, message in cause.problems]
        elif cause is not None:
            problems.append((path, str(cause)))
        elif entry["type"] == "too_short":
            short.append((path, "given an empty list; give at least one entry"))
        elif entry["type"] == "union_tag_invalid" and "_form" in entry["ctx"]["discriminator"]:
            forms = entry["ctx"]["expected_tags"].replace("'<", "a ").replace(">'", "").replace(", ", " or ")
            problems.append((path, f"given {shortened(entry['input'])}; must be {forms}"))
        elif entry["type"] == "union_tag_invalid":
            about = entry["ctx"]
            key = about["discriminator"].strip("'")
            problems.append(((*path, key), f"given {about['tag']!r}; must be one of {about['expected_tags']}"))
        else:
            problems.append((path, _plain(entry, part)))
    # a list of faulty entries is also reported as too short; say only what is wrong with the entries
    return problems + [(path, text) for path, text in short if not any(p[: len(path)] == path for p, _ in problems)]


def _is_tag(loc: KeyPath, number: int) -> bool:
    in_list = number > 1 and isinstance(loc[number - 1], int) and loc[number - 2] in _TAGGED_LISTS
    if loc[number] in FORMS:
        return True
    return in_list or (number > 0 and (loc[number - 1] in _TAGGED or loc[number - 1 : number + 1] in _TAGGED_PAIRS))


WANTED = {  # what pydantic says in the words of its types
    **dict.fromkeys(("model_type", "dict_type"), "must be a table"),
    **dict.fromkeys(("tuple_type", "list_type"), "must be a list"),
    **dict.fromkeys(("int_type", "int_from_float", "int_parsing"), "must be a whole number"),
    **dict.fromkeys(("float_type", "float_parsing"), "must be a number"),
    "greater_than_equal": "must be {ge} or more",
    "less_than_equal": "must be {le} or less",
}


def _plain(entry: Any, part: type[BaseModel]) -> str:
    kind, given = entry["type"], entry.get("input")
    if kind == "missing":
        return "missing; it has no default"
    if kind == "extra_forbidden":
        return unknown_key(str(entry["loc"][-1]), sorted(part.model_fields))
    if kind == "union_tag_not_found":
        name = entry["ctx"]["discriminator"].strip("'")
        tags = _tags(part.model_fields[str(entry["loc"][0])].annotation, name)
        return f"given {shortened(given)}; it has no '{name}', which must be one of {', '.join(tags)}"
    wanted = WANTED.get(kind) or f"{entry['msg'][0].lower()}{entry['msg'][1:]}"
    return f"given {shortened(given)}; {wanted.format(**entry.get('ctx', {}))}"


def unknown_key(argument: str, allowed: Sequence[str]) -> str:
    """What to say of a key that there is not, with those that look like it."""
    near = get_close_matches(argument.lower(), allowed, n=2)
    meant = f"did you mean {' or '.join(map(repr, near))}? " if near else ""
    return f"unknown key; {meant}allowed here: {', '.join(allowed)}"


def _tags(annotation: Any, name: str) -> list[str]:
    """The values of the discriminator ``name`` of every part within an annotation, one of a list of parts too."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [repr(annotation.model_fields[name].default)] if name in annotation.model_fields else []
    return [tag for inner in get_args(annotation) for tag in _tags(inner, name)]


class Family(NamedTuple):
    """Stands in ``Annotated``: the parts that an entry may be, where a reader of its own tells them apart."""

    parts: tuple[type[Part], ...]


FORMS = ("<text>", "<list>", "<table>")


def _form(value: Any) -> str:
    """Whether a text, a list or a table stands there."""
    return FORMS[1 if isinstance(value, (list, tuple)) else 2 if isinstance(value, (Mapping, Part)) else 0]


TEXT, LIST, TABLE = map(Tag, FORMS)
ByForm = Discriminator(_form)  # tells apart what may be one of a text, a list and a table, each with its tag


def key(
    meaning: str,
    default: Any = ...,
    *,
    symbol: str = "",
    value: str = "",
    default_text: str = "",
    known: str = "",
    of_ball: bool = False,
) -> Any:
    """A key of a part: what it means, its default, and its symbol in formulas (LaTeX) if it has one.

    Help, JSON schema, tables of the documentation and labels of axes take all of these from here. ``value`` and
    ``default_text`` say what may stand there, and what holds without it, where type and default do not.

    Of what acts on balls, ``known`` declares the theories that know it, ``"at_rest stalled"`` or ``"none"``, in place of an
    entry in ``assembly/terms.py``. A number ``of_ball`` goes as it is to the field of this name of ``BALL`` in
    ``kernels/records.py``.
    """
    said = {"symbol": symbol, "value": value, "default": default_text, "known": known, "of_ball": "yes" * of_ball}
    extra = {name: text for name, text in said.items() if text}
    return Field(default, description=meaning, json_schema_extra=extra or None)  # type: ignore[arg-type]


def quantity_of(part: type[Part], name: str) -> Quantity | None:
    """Unit and bounds of a key of a part; ``None`` where it is no quantity."""
    field = part.model_fields[name]
    return _quantity_in((field.annotation, *field.metadata))


def symbol_of(part: type[Part], name: str) -> str:
    """Symbol of a key in formulas (LaTeX); empty if it has none."""
    return key_note(part.model_fields[name], "symbol")


def key_note(field: FieldInfo, what: str) -> str:
    """What :func:`key` was given beside meaning and default; empty if it was not."""
    extra = field.json_schema_extra
    return str(extra.get(what, "")) if isinstance(extra, dict) else ""


@cache
def keys_noted(part: type[Part], what: str) -> dict[str, str]:
    """The keys of a part to which :func:`key` was given this, and what it is."""
    return {name: note for name, field in part.model_fields.items() if (note := key_note(field, what))}


def _quantity_in(hints: tuple[Any, ...]) -> Quantity | None:
    for hint in hints:
        inner = (*get_args(hint), *getattr(hint, "__metadata__", ()))
        quantity = hint if isinstance(hint, Quantity) else _quantity_in(inner)
        if quantity is not None:
            return quantity
    return None


LONGEST_NAME = 200
CONTROL = ("Cc", "Zl", "Zp", "Cs")  # Unicode categories of what steers a terminal, ends a line, or is no character


def _label(value: Any) -> str:
    """A text in one line that a terminal and a picture can show."""
    if not isinstance(value, str):
        raise ValueError(f"given {shortened(value)}; must be a text")
    if len(value) > LONGEST_NAME:
        raise ValueError(f"given {shortened(value)}; must not have more than {LONGEST_NAME} characters")
    if any(unicodedata.category(sign) in CONTROL for sign in value):
        raise ValueError(f"given {shortened(value)}; must be one line of characters that can be shown")
    return value


def _name(value: Any) -> str:
    if isinstance(value, str) and not value.strip():
        raise ValueError(f"given {value!r}; must not be empty")
    return _label(value)


def as_tuple(value: Any) -> Any:
    """A single entry where a list is expected counts as a list of one."""
    return value if isinstance(value, (list, tuple)) else (value,)


Label = Annotated[str, PlainValidator(_label, json_schema_input_type=str)]
Name = Annotated[str, PlainValidator(_name, json_schema_input_type=str)]


class _Listed:
    """Marks a list in which a single entry stands for a list of one, for the reader and in the JSON schema."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(as_tuple, handler(source))

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        several = handler(schema)
        return {"anyOf": [several["items"], several]}


Listed = _Listed()


# A quantity that a key of a machine holds: its unit, its bounds, and how it is read.


Shape = Literal["one", "one or a pair", "three", "range", "values", "values or range"]


class Range(NamedTuple):
    """A quantity from one end to the other, SI; both are one where a single value was given."""

    low: float
    high: float


@dataclass(frozen=True, repr=False)
class Quantity:
    """Reads a number in the SI ``unit``, or a text with a unit, and refuses what is out of bounds.

    ``most`` is the greatest value allowed. ``shape`` says how many numbers there are: one, one or a pair along x and y,
    three along x, y and z, a range (a value, or a table with ``from`` and ``to``), or values, which may also be a text such as
    ``"500:3000 rpm:200"``. Stands in ``Annotated[float, Quantity("kg", positive=True)]``.
    """

    unit: str
    positive: bool = False
    non_negative: bool = False
    most: float = math.inf
    shape: Shape = "one"

    def __call__(self, value: Any) -> Any:
        """One number, a tuple of numbers, or a range, in SI."""
        if isinstance(value, Mapping) and "range" in self.shape:
            return self._range(value)
        if self.shape == "range" and is_range(value):
            value = ends("range", value, self.unit)
        if self.shape == "range" and isinstance(value, (list, tuple)) and len(value) == 2:
            return self._range(dict(zip(("from", "to"), value, strict=True)))
        if self.shape == "range":
            return Range(*([self.one(value)] * 2))
        if "values" in self.shape:
            listed = range_values("range", value, self.unit).tolist() if is_range(value) else as_tuple(value)
            if not listed:
                raise ValueError("given an empty list; give at least one value")
            return tuple(self._at(number, entry) for number, entry in enumerate(listed))
        if self.shape == "three":
            if not isinstance(value, (list, tuple)) or len(value) != 3:
                given = f"{len(value)} values" if isinstance(value, (list, tuple)) else repr(value)
                raise ValueError(f"given {given}; give three, along x (the rotor), y and z")
        elif self.shape == "one" or not isinstance(value, (list, tuple)):
            return self.one(value)
        elif len(value) != 2:
            raise ValueError(f"given {len(value)} values; give one, or two (along x and y)")
        return tuple(self.one(entry) for entry in value)

    def _range(self, value: Mapping[str, Any]) -> Range:
        if set(value) != {"from", "to"}:
            wanted = "values, or" if "values" in self.shape else "one value, or"
            raise ValueError(f"given {shortened(dict(value))}; must be {wanted} a table with 'from' and 'to'")
        result = Range(self._at("from", value["from"]), self._at("to", value["to"]))
        if result.low > result.high or ("values" in self.shape and result.low == result.high):
            raise MachineError.of(
                "",
                [
                    (("from",), f"given {shortened(value['from'])}; must be below 'to'"),
                    (("to",), f"given {shortened(value['to'])}; must be above 'from'"),
                ],
            )
        return result

    def _at(self, step: str | int, value: Any) -> Any:
        try:
            return self.one(value)
        except (ValueError, UnitError) as reason:
            raise MachineError(str(reason), (step,)) from None

    def one(self, value: Any) -> Any:
        """A single number in SI."""
        number = to_si(value, self.unit)
        if math.isfinite(self.most) and not (self._within(number) and number <= self.most):
            low = "greater than 0 and at most" if self.positive else "between 0 and"
            raise ValueError(f"given {number:g}; must be {low} {self.most:g}")
        if self.positive and not number > 0.0:
            raise ValueError(f"given {shortened(value)}; must be greater than zero")
        if not self._within(number):
            raise ValueError(f"given {shortened(value)}; must not be negative")
        wrong = plausible(number, self.unit, self.positive)
        if wrong:
            raise ValueError(f"given {shortened(value)}; {wrong}")
        return number

    def _within(self, number: float) -> bool:
        return number > 0.0 if self.positive else number >= 0.0 if self.non_negative else True

    def __repr__(self) -> str:
        return f"Quantity({self.words!r})"

    @property
    def words(self) -> str:
        """Unit and bounds, such as ``kg, > 0``."""
        unit = self.unit.replace("*", " ").replace("^2", "²").replace("^3", "³") or "number"
        low = ", > 0" if self.positive else ", ≥ 0" if self.non_negative else ""
        high = f", ≤ {self.most:g}" if math.isfinite(self.most) else ""
        single = f"{unit}{low}{high}"
        return {
            "one": single,
            "one or a pair": f"{single}; one, or a pair along x and y",
            "three": f"three of {single}",
            "range": f"{single}; one, or from and to",
            "values": single,
            "values or range": f"{single}, or from and to",
        }[self.shape]

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        number: dict[str, Any] = {"type": "number"}
        if self.positive:
            number["exclusiveMinimum"] = 0
        elif self.non_negative:
            number["minimum"] = 0
        if math.isfinite(self.most):
            number["maximum"] = self.most
        single: dict[str, Any] = {"anyOf": [number, {"type": "string"}], "unit": self.unit}
        if self.shape == "one":
            return single
        count = {"one or a pair": (2, 2), "three": (3, 3)}.get(self.shape)
        limits = {"minItems": count[0], "maxItems": count[1]} if count else {"minItems": 1}
        several = {"type": "array", "items": single, **limits}
        table = {"type": "object", "properties": {"from": single, "to": single}, "required": ["from", "to"]}
        ways = {"range": [single, table], "values or range": [single, several, table]}
        return several if self.shape == "three" else {"anyOf": ways.get(self.shape, [single, several])}


def _amount(argument: Any) -> Any:
    if isinstance(argument, bool) or not (isinstance(argument, str) or hasattr(argument, "__float__")):
        raise ValueError(f"given {shortened(argument)}; give a number in SI or a text with a unit")
    return argument if isinstance(argument, str) else float(argument)


Amount = Annotated[
    float, PlainValidator(_amount, json_schema_input_type=float | str)
]  # its unit is known with the machine
Mass = Annotated[float, Quantity("kg", positive=True)]
Length = Annotated[float, Quantity("m", positive=True)]
Offset = Annotated[float, Quantity("m", non_negative=True)]
Position = Annotated[float, Quantity("m")]
Angle = Annotated[float, Quantity("rad")]
Speed = Annotated[float, Quantity("rad/s")]
Acceleration = Annotated[float, Quantity("rad/s^2", positive=True)]
Velocity = Annotated[float, Quantity("m/s")]
Time = Annotated[float, Quantity("s", non_negative=True)]
Duration = Annotated[float, Quantity("s", positive=True)]
Stiffness = Annotated[float | tuple[float, float], Quantity("N/m", positive=True, shape="one or a pair")]
ForceSize = Annotated[float, Quantity("N", positive=True)]
Rate = Annotated[float, Quantity("rad/s", positive=True)]
ShearRate = Annotated[float, Quantity("1/s", positive=True)]
MagneticMoment = Annotated[float, Quantity("A*m^2", positive=True)]
SpringRate = Annotated[float, Quantity("N/m", positive=True)]
Damping = Annotated[float | tuple[float, float], Quantity("N*s/m", non_negative=True, shape="one or a pair")]
Torque = Annotated[float, Quantity("N*m")]
AngularDamping = Annotated[float, Quantity("N*m*s", non_negative=True)]
UnbalanceMoment = Annotated[float, Quantity("kg*m", non_negative=True)]
Inertia = Annotated[float, Quantity("kg*m^2", positive=True)]
MassInertia = Annotated[float, Quantity("kg*m^2", non_negative=True)]
CoupleMoment = Annotated[float, Quantity("kg*m^2", non_negative=True)]
Density = Annotated[float, Quantity("kg/m^3", positive=True)]
Viscosity = Annotated[float, Quantity("m^2/s", positive=True)]
Temperature = Annotated[float, Quantity("K", positive=True)]
Gravity = Annotated[float, Quantity("m/s^2", non_negative=True)]
Ratio = Annotated[float, Quantity("", non_negative=True)]
Positive = Annotated[float, Quantity("", positive=True)]
PoissonRatio = Annotated[float, Quantity("", non_negative=True, most=0.5)]


# How large and how small a quantity of a machine can be: bounds that no machine comes near.
#
# Beyond them a value is a slip, and numbers made of it leave the range in which a computer works.


SMALLEST = 1e-30  # of what must be greater than zero, in SI
LARGEST = 1e30
BOUNDS = {  # SI unit: smallest of what must be greater than zero, largest
    "kg": (1e-18, 1e15),
    "m": (1e-9, 1e6),
    "rad": (SMALLEST, 1e6),
    "rad/s": (SMALLEST, 1e9),
    "s": (1e-15, 1e12),
    "m/s": (SMALLEST, 1e9),
    "m/s^2": (SMALLEST, 1e12),
    "kg/m^3": (1e-18, 1e9),
    "m^2/s": (1e-15, 1e9),
    "K": (1e-3, 1e6),
    "": (SMALLEST, 1e15),
}


def plausible(number: float, unit: str, positive: bool) -> str:
    """What is wrong with the size of a quantity in the SI ``unit``; nothing if it is within its bounds."""
    low, high = BOUNDS.get(unit, (SMALLEST, LARGEST))
    if abs(number) > high:
        return f"must not be larger than {high:g} {unit}".rstrip()
    if positive and number < low:
        return f"must not be smaller than {low:g} {unit}".rstrip()
    return ""

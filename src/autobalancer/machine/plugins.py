"""Leaves: parts of a machine of which there may be any number, each one file with its keys and its mathematics.

A family is a base class, such as :class:`~autobalancer.machine.balancer.force.Force`. Its leaves are found by the word of
their tag: built-in ones in the package ``autobalancer.<family>``, where the file has the name of the word, then those that were
registered, then those of entry points in the group ``autobalancer.<family>`` of any installed package. No list is extended.

The mathematics of a leaf are static methods that are functions of numbers; nothing here compiles or calls them.
"""

from __future__ import annotations

import pkgutil
import sys
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, ClassVar, TypeVar, Union, get_args, get_origin

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine.part import Part
from autobalancer.safe_file import as_path, not_to_read
from autobalancer.units import shortened

Some = TypeVar("Some", bound="type[Leaf]")

_registered: dict[tuple[str, str], type[Leaf]] = {}


class Leaf(Part):
    """A part that is one of a family, such as one force of all forces on balls.

    A leaf has a key with the name of ``tag``, a ``Literal`` of one word, and says for which version of the family's contract it
    was written: ``interface = 1``.
    """

    family: ClassVar[str]  # plural, as in the names of the package and the group of entry points
    one: ClassVar[str]  # what messages call one of them
    tag: ClassVar[str] = "kind"
    current: ClassVar[int] = 1  # version of the contract of this family
    interface: ClassVar[int]  # version for which a leaf was written

    @classmethod
    def word(cls) -> str:
        """The word in a machine file that means this leaf; empty of a base class."""
        field = cls.model_fields.get(cls.tag)
        return str(field.default) if field is not None and len(get_args(field.annotation)) == 1 else ""

    def numbers(self) -> dict[str, float]:
        """Its keys that are numbers, by name: what compiled mathematics get as ``own``; one that is not given is not a number."""
        wanted = {name: field for name, field in type(self).model_fields.items() if _is_number(field.annotation)}
        return {name: float("nan" if (value := getattr(self, name)) is None else value) for name in wanted}


def _is_number(annotation: Any) -> bool:
    """Whether one number may stand there, and nothing else but none."""
    ways = get_args(annotation) if get_origin(annotation) in (Union, UnionType) else (annotation,)
    kinds = {getattr(way, "__origin__", way) for way in ways}  # what is annotated, without the annotation
    return kinds != {NoneType} and kinds <= {float, int, bool, NoneType}


def register(leaf: Some) -> Some:
    """Make a leaf of your own known to machine files; also as a decorator of its class.

    Parameters
    ----------
    leaf
        A class that inherits from the base class of a family, such as ``autobalancer.machine.Force``.

    Returns
    -------
    type
        The same class.

    Raises
    ------
    MachineError
        If it is not such a class, was written for another version, or has the name of a built-in one.
    """
    _refuse_strange(leaf, "register")
    family, word = leaf.family, leaf.word()
    if word in _built_in(family):
        raise MachineError(
            f"register: {leaf.__name__} has the {leaf.tag} {word!r}, which is a {leaf.one} of autobalancer; take another word"
        )
    _registered[family, word] = leaf
    return leaf


def find(base: type[Leaf], word: Any) -> type[Leaf]:
    """The leaf of a family with this word.

    Raises
    ------
    MachineError
        If there is none; the message has the nearest words and all known ones.
    """
    if isinstance(word, str):
        if word in _built_in(base.family):
            return _in_package(base, word)
        if (base.family, word) in _registered:
            return _registered[base.family, word]
        if word in (points := _points(base.family)):
            return _installed(base, word, points[word])
    near = get_close_matches(str(word).lower(), known(base), n=2)
    meant = f"did you mean {' or '.join(map(repr, near))}? " if near else ""
    raise MachineError.of(
        base.__name__,
        [
            (
                (base.tag,),
                f"given {shortened(word)}; {meant}must be one of {', '.join(map(repr, known(base)))}. One of your own must be "
                "loaded first: --load FILE on the command line, ab.laws.register in Python",
            )
        ],
    )


def known(base: type[Leaf]) -> tuple[str, ...]:
    """The words of all leaves of a family: built-in, registered, installed."""
    registered = [word for family, word in _registered if family == base.family]
    return tuple(dict.fromkeys([*_built_in(base.family), *registered, *_points(base.family)]))


def leaves_of(base: type[Leaf]) -> Iterator[type[Leaf]]:
    """All built-in and registered leaves of a family; installed ones when they are used."""
    for word in _built_in(base.family):
        yield _in_package(base, word)
    for (family, _), leaf in _registered.items():
        if family == base.family:
            yield leaf


def _is_known(leaf: Leaf) -> bool:
    """Installed packages come last, because asking for them takes milliseconds."""
    return (
        leaf.word() in _built_in(leaf.family)
        or (leaf.family, leaf.word()) in _registered
        or leaf.word() in _points(leaf.family)
    )


@cache
def _built_in(family: str) -> tuple[str, ...]:
    package = import_module(f"autobalancer.{family}")
    return tuple(sorted(entry.name for entry in pkgutil.iter_modules(package.__path__)))


def _in_package(base: type[Leaf], word: str) -> type[Leaf]:
    module = import_module(f"autobalancer.{base.family}.{word}")
    return next(
        value
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, base) and value.word() == word
    )


def _points(family: str) -> dict[str, Any]:
    return {point.name: point for point in entry_points(group=f"autobalancer.{family}")}


def _installed(base: type[Leaf], word: str, point: Any) -> type[Leaf]:
    of = f"entry point {word!r} of {point.dist.name if point.dist is not None else 'a package'}"
    try:
        leaf = point.load()
    except Exception as reason:
        raise MachineError(f"{of}: cannot be loaded: {type(reason).__name__}: {reason}") from None
    _refuse_strange(leaf, of)
    if leaf.family != base.family or leaf.word() != word:
        raise MachineError(f"{of}: is the {leaf.one} {leaf.word()!r}; it must be the {base.one} {word!r}")
    _registered[base.family, word] = leaf
    return _registered[base.family, word]


def _refuse_strange(leaf: Any, said: str) -> None:
    if not (isinstance(leaf, type) and issubclass(leaf, Leaf)) or not hasattr(leaf, "family"):
        raise MachineError(
            f"{said}: given {shortened(leaf)}; must be a class that inherits from a base class such as autobalancer.machine.Force"
        )
    if not leaf.word():
        raise MachineError(
            f"{said}: {leaf.__name__} has no word for machine files; give it a line such as "
            f"{leaf.tag}: Literal['my_{leaf.one}'] = 'my_{leaf.one}'"
        )
    written = getattr(leaf, "interface", None)
    if written is None:
        raise MachineError(
            f"{said}: {leaf.__name__} does not say for which version it was written; this autobalancer has version "
            f"{leaf.current} of the contract of {leaf.family}: write interface = {leaf.current} if it follows that"
        )
    if written != leaf.current:
        raise MachineError(
            f"{said}: {leaf.__name__} was written for version {written} of the contract of {leaf.family}, this autobalancer "
            f"has version {leaf.current}; take a version of one that fits the other"
        )


def _unchangeable(leaf: Leaf) -> Leaf:
    """The same leaf; one with a list, say, is refused: a machine never changes, and answers are found again by its numbers."""
    for name in type(leaf).model_fields:
        value = getattr(leaf, name)
        try:
            hash(value)
        except TypeError:
            raise MachineError.of(
                type(leaf).__name__,
                [
                    (
                        (name,),
                        f"its values are of the type {type(value).__name__}, which can be changed; its class must describe "
                        "them as a tuple, such as tuple[float, ...]",
                    )
                ],
            ) from None
    return leaf


@dataclass(frozen=True)
class OneOf:
    """Reads a leaf of a family from its table: stands in ``Annotated[Force, OneOf(Force)]``."""

    base: type[Leaf]

    def __call__(self, value: Any) -> Leaf:
        """A leaf as it is, or one from a table with its tag."""
        if isinstance(value, self.base):
            if not _is_known(value):
                register(type(value))
            return _unchangeable(value)
        tag = self.base.tag
        if not isinstance(value, dict):
            raise ValueError(f"given {shortened(value)}; must be a table with a {tag!r}")
        if tag not in value:
            raise ValueError(
                f"given {shortened(value)}; it has no {tag!r}, which must be one of {', '.join(map(repr, known(self.base)))}"
            )
        return _unchangeable(find(self.base, value[tag])(**value))

    @property
    def parts(self) -> tuple[type[Leaf], ...]:
        """All that may stand there, for tables of keys and for the schema."""
        return tuple(leaves_of(self.base))

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return {"anyOf": [handler(leaf.__pydantic_core_schema__) for leaf in self.parts]}


# Files in Python with leaves of one's own, executed because the user names them.


def load(path: str | Path) -> list[type[Leaf]]:
    """Execute a Python file and register all forces, drag laws, friction laws, joints and shear laws that it defines.

    A machine file never executes anything; this function does because it is asked to, as the option ``--load`` of the command
    line.

    Parameters
    ----------
    path
        A file that defines classes such as those on the page on forces.

    Returns
    -------
    list of type
        The classes, which machine files now may name.

    Raises
    ------
    QuestionError
        If the file cannot be read or executed, defines none, or one that was written for another version or has the name of
        a built-in one.
    """
    path = as_path(path).resolve()
    if missing := not_to_read(path):
        raise QuestionError(f"{path}: {missing}")
    name = f"own_{path.stem}"
    spec = spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise QuestionError(f"{path}: is not a Python file; its name must end in .py")
    module = module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as reason:
        del sys.modules[name]
        places = [entry.lineno for entry in traceback.extract_tb(reason.__traceback__) if entry.filename == str(path)]
        line = getattr(reason, "lineno", None) or (places[-1] if places else None)
        where = f"line {line}: " if line else ""
        raise QuestionError(f"{path}: {where}{type(reason).__name__}: {reason}") from None
    own = [value for value in vars(module).values() if isinstance(value, type) and value.__module__ == name]
    leaves = [value for value in own if issubclass(value, Leaf) and value.word()]
    if not leaves:
        raise QuestionError(
            f"{path}: defines no force, drag law, friction law, joint or shear law: no class with a word for machine files"
        )
    try:
        return [register(leaf) for leaf in leaves]
    except MachineError as reason:
        raise QuestionError(f"{path}: {str(reason).removeprefix('register: ')}") from None

"""The files that come with the package: sample machines, published rigs, measurements, and recipes that work with them."""

from __future__ import annotations

import re
import shlex
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from autobalancer.errors import CatalogError, QuestionError
from autobalancer.machine.schema import schema_line
from autobalancer.safe_file import write_text_safely

_DATA = Path(str(files("autobalancer"))) / "catalog" / "data"
KINDS = ("machines", "rigs", "measurements", "studies", "designs")
RECIPES = ("recipes",)


def sample_names(kind: str) -> tuple[str, ...]:
    """Names of the samples of one kind, ascending."""
    return tuple(sorted({path.stem for path in _files(kind)}))


def sample_files(name: str, kinds: tuple[str, ...] = KINDS) -> tuple[Path, ...]:
    """The files of a sample; a table that belongs to a file comes behind it, and so do the samples that it names.

    Raises
    ------
    CatalogError
        If there is no sample of this name.
    """
    found = [path for kind in kinds for path in _files(kind) if path.stem == name]
    if not found:
        known = "; ".join(f"{kind} {', '.join(sample_names(kind))}" for kind in kinds)
        noun = "recipe" if kinds == RECIPES else "sample"
        raise CatalogError(f"no {noun} is called {name!r}; there are {known}")
    if kinds == RECIPES:
        return (*found, *(path for sample in recipe(name).samples for path in sample_files(sample)))
    found.sort(key=lambda path: (path.suffix != ".toml", path.suffix))
    described = (path.read_text(encoding="utf-8") for path in found if path.suffix == ".toml")
    named = {name for text in described for name in re.findall(r'"(\w+\.(?:csv|toml))"', text)}
    others = (path for kind in KINDS[:3] for path in _files(kind) if path.name in named)
    return tuple(dict.fromkeys((*found, *others)))


def example_path(name: str) -> Path:
    """Where the file of a sample is within the package, to read it there.

    Parameters
    ----------
    name
        Of a sample machine, a published rig or a measurement.

    Raises
    ------
    CatalogError
        If there is no sample of this name.
    """
    return sample_files(name)[0]


def write_example(name: str, folder: str | Path = ".", kinds: tuple[str, ...] = KINDS) -> tuple[Path, ...]:
    """Copy the file of a sample, and what belongs to it, into a folder.

    Parameters
    ----------
    name
        Of a sample machine, a published rig, a measurement or, with these ``kinds``, a recipe.
    folder
        Is made if there is none.
    kinds
        Among which it is sought.

    Returns
    -------
    tuple of Path
        The files; one that is there already with this content is left as it is.

    Raises
    ------
    CatalogError
        If there is no sample of this name.
    QuestionError
        If a file of the same name with another content is there.
    """
    texts = {Path(folder) / path.name: path.read_text(encoding="utf-8") for path in sample_files(name, kinds)}
    for path, text in texts.items():
        if path.exists() and not (
            path.is_file() and re.sub(rb"\A#:schema .*\n", b"", path.read_bytes()) == text.encode()
        ):
            raise QuestionError(
                f"{path}: is there already with another content; move it, or choose another name or folder"
            )
    for path, text in texts.items():
        if not path.exists():
            write_text_safely(
                path, schema_line(path.parent, tomllib.loads(text)) + text if path.suffix == ".toml" else text
            )
    return tuple(texts)


def beside(folder: Path, name: str | Path) -> Path:
    """A file that another one names, seen from its folder; samples name others of any kind."""
    if folder.resolve().parent == _DATA.resolve() and not (folder / name).exists():
        return next((path for kind in KINDS for path in _files(kind) if path.name == str(name)), folder / name)
    return folder / name


def sample_hint(path: Path) -> str:
    """How to get the sample that has the name of a missing file; empty if none has."""
    if not any(path.name == known.name for kind in KINDS for known in _files(kind)):
        return ""
    return f"; 'autobalancer example {path.stem}' writes the sample of this name"


def _files(kind: str) -> list[Path]:
    return [path for path in sorted((_DATA / kind).iterdir()) if path.suffix in (".toml", ".csv", ".md")]


# Recipes: a question, commands with what their output has in it, and the answer, as a page that people and programs read.


@dataclass(frozen=True)
class Step:
    """A command, or lines of Python, and texts that its output has in it: words and numbers, blanks do not count."""

    command: str
    expected: tuple[str, ...]
    python: bool = False


@dataclass(frozen=True)
class Recipe:
    """A page with a title, a question, steps and an answer."""

    name: str
    title: str
    question: str
    steps: tuple[Step, ...]
    answer: str

    @property
    def samples(self) -> tuple[str, ...]:
        """The samples that its commands write."""
        words = [shlex.split(step.command) for step in self.steps if step.command.startswith("autobalancer example ")]
        return tuple(dict.fromkeys(name for line in words for name in line[2:]))


def recipe(name: str) -> Recipe:
    """The recipe of this name, read.

    Raises
    ------
    CatalogError
        If there is none.
    """
    path = next((path for path in _files(RECIPES[0]) if path.stem == name), None)
    if path is None:
        raise CatalogError(f"no recipe is called {name!r}; there are {', '.join(sample_names(RECIPES[0]))}")
    head, *blocks = re.split(
        r"^```(\w*)\n(.*?)^```\n", path.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL
    )
    title, _, question = head.removeprefix("# ").partition("\n")
    steps: list[Step] = []
    for language, block in zip(blocks[::3], blocks[1::3], strict=True):
        if language == "python":
            steps.append(Step(block, tuple(re.findall(r"^print\(.*\)  # (.*)$", block, re.MULTILINE)), python=True))
        for typed in block.split("$ ")[1:] if language == "console" else ():
            command, *expected = typed.replace("\\\n", " ").splitlines()
            steps.append(Step(command, tuple(filter(None, expected))))
    return Recipe(name, title, " ".join(question.split()), tuple(steps), blocks[-1].strip())

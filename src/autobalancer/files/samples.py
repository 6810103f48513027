"""The files that come with the package: sample machines, published rigs, measurements."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from pathlib import Path

from autobalancer.errors import CatalogError, QuestionError
from autobalancer.safe_file import write_text_safely

_DATA = Path(str(files("autobalancer"))) / "catalog" / "data"
KINDS = ("machines", "rigs", "measurements", "studies", "designs")
NAMING = ("studies", "designs")  # kinds whose files name a machine


def sample_names(kind: str) -> tuple[str, ...]:
    """Names of the samples of one kind, ascending."""
    return tuple(sorted({path.stem for path in _files(kind)}))


def sample_files(name: str) -> tuple[Path, ...]:
    """The files of a sample; a table that belongs to a file comes behind it, and so does what a study or a design names.

    Raises
    ------
    CatalogError
        If there is no sample of this name.
    """
    sample_files = [path for kind in KINDS for path in _files(kind) if path.stem == name]
    if not sample_files:
        known = "; ".join(f"{kind} {', '.join(sample_names(kind))}" for kind in KINDS)
        raise CatalogError(f"no sample is called {name!r}; there are {known}")
    sample_files.sort(key=lambda path: (path.suffix != ".toml", path.suffix))
    requested = [tomllib.loads(path.read_text(encoding="utf-8")) for path in sample_files if path.parent.name in NAMING]
    named = {one["machine"] for one in requested} | {one["rotor"]["receptance"] for one in requested if "rotor" in one}
    return (*sample_files, *(path for kind in KINDS[:3] for path in _files(kind) if path.name in named))


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


def write_example(name: str, folder: str | Path = ".") -> tuple[Path, ...]:
    """Copy the file of a sample, and a table that belongs to it, into a folder.

    Parameters
    ----------
    name
        Of a sample machine, a published rig or a measurement.
    folder
        Is made if there is none.

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
    texts = {Path(folder) / path.name: path.read_text(encoding="utf-8") for path in sample_files(name)}
    for path, text in texts.items():
        if path.exists() and not (path.is_file() and path.read_bytes() == text.encode()):
            raise QuestionError(
                f"{path}: is there already with another content; move it, or choose another name or folder"
            )
    for path, text in texts.items():
        if not path.exists():
            write_text_safely(path, text)
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
    return [path for path in sorted((_DATA / kind).iterdir()) if path.suffix in (".toml", ".csv")]

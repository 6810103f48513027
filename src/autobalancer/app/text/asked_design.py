"""What is wrong with the text of a design's specification, key by key, in the words of its reader."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from autobalancer.app.text.asked import MachineAsked, key_at_fault, machine_asked, refuse_files, tables_of
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.files.samples import example_path, sample_names
from autobalancer.studies.design.reading import read_spec
from autobalancer.studies.design.spec import Spec

MOST = 2000  # runs of a candidate on the page
Find = Callable[[str], Path | None]  # a measured file of the user by its name


@dataclass(frozen=True)
class DesignReading:
    """A text that was read: the specification, or what is wrong with it and the key where."""

    of: MachineAsked
    spec: Spec | None = None
    message: str = ""
    key: str = ""
    measured: Path | None = None  # the receptance that it names


def read_design_text(text: str, page: str, find: Find = lambda _name: None) -> DesignReading:
    """Read the text of a specification; ``page`` is the text of the machine of the page.

    What is wrong is an answer, not an error. ``find`` gives measured files of the user; those of the package are known.
    """
    data, wrong = tables_of(text)
    if data is None:
        return DesignReading(MachineAsked(), None, wrong)
    rotor = data.get("rotor")
    alone = "machine" not in data and isinstance(rotor, dict)
    of = MachineAsked(file="") if alone else machine_asked(data, page, rigs=True)
    if of.machine is None and not alone:
        return DesignReading(of, None, of.message, "machine")
    measured = None
    try:
        refuse_files(data)
        asked: dict[str, Any] = {**data} if alone else {**data, "machine": of.machine}
        if isinstance(rotor, dict) and "receptance" in rotor:
            measured = _measured(str(rotor["receptance"]), find)
            asked["rotor"] = {**rotor, "receptance": measured}
        spec = read_spec(asked)
        if spec.search.members > MOST:
            raise QuestionError(f"search.members: given {spec.search.members}; on the page at most {MOST} run")
    except AutobalancerError as error:
        message = str(error).removeprefix("specification: ")
        return DesignReading(of, None, message, key_at_fault(message), measured)
    return DesignReading(of, spec, measured=measured)


def _measured(name: str, find: Find) -> Path:
    """The file of a receptance: one of the package, or of the user.

    Raises
    ------
    QuestionError
        If there is none of this name.
    """
    found = find(name)
    if found is not None:
        return found
    stem = name.rpartition(".")[0]
    if stem in sample_names("measurements") and example_path(stem).name == name:
        return example_path(stem)
    known = ", ".join(sorted(f"{one}.csv" for one in sample_names("measurements") if "hammer" in one))
    raise QuestionError(
        f"rotor.receptance: given {name[:60]!r}; name a file of the page Measured, or a sample of the package: {known}"
    )

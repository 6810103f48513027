"""Files in Python with forces, joints, laws of drag, friction or shear of one's own, executed because the user names them."""

from __future__ import annotations

import sys
import traceback
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

from autobalancer.errors import MachineError, QuestionError
from autobalancer.machine.plugins import Leaf, register
from autobalancer.safe_file import as_path, not_to_read


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

"""Results wherever they are: a file, or a run in an archive."""

from __future__ import annotations

from pathlib import Path

import xarray as xr

from autobalancer.errors import ResultError
from autobalancer.results.archive.folder import Archive
from autobalancer.results.archive.run import RunFolder
from autobalancer.results.store import load_run
from autobalancer.safe_file import as_path


def open_run(path: str | Path) -> xr.Dataset:
    """A result file read into memory, or the folder of a run in an archive, whose samples are read when used.

    Raises
    ------
    ResultError
        If there is neither, or it cannot be read. For the folder of a whole archive it names the runs.
    """
    path = as_path(path)
    if not path.is_dir():
        return load_run(path)
    if not (path / "run.json").exists():
        names = Archive(path).names()
        runs = f"an archive; choose one of its runs: {', '.join(str(path / name) for name in names)}"
        raise ResultError(f"{path}: is {runs if names else 'a folder without a run in it'}")
    return RunFolder(path).samples()

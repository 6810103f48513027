"""What the commands on the pages print, from running them."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

from typer.testing import CliRunner

from autobalancer.cli import app
from autobalancer.files.samples import KINDS, sample_names, write_example

MACHINES = Path(__file__).resolve().parents[1] / "machines"
COMMANDS = {
    "check_discoidal": "check discoidal.toml",
    "check_annotated": "check annotated.toml",
    "check_chamber": "check chamber.toml",
    "check_design": "check design.toml",
    "run_design": "simulate design.toml --out design.nc",
    "check_wrong": "check wrong.toml",
    "check_misfit": "check misfit.toml",
    "check_thin_oil": "check thin_oil.toml",
    "catalog_friction": "catalog friction",
    "run_discoidal": "simulate discoidal.toml --out run.nc",
}


def pages() -> dict[str, str]:
    """The commands as typed where the samples and the files of the pages are, with output and, if not 0, exit code."""
    with TemporaryDirectory() as folder:
        for kind in KINDS:
            for name in sample_names(kind):
                write_example(name, folder)
        for file in MACHINES.glob("*.toml"):
            shutil.copy(file, folder)
        with chdir(folder):
            return {f"{name}.txt": _transcript(command) for name, command in COMMANDS.items()}


def _transcript(command: str) -> str:
    plain = {"COLUMNS": "92", "NO_COLOR": "1", "TERM": "dumb"}
    with patch.dict(os.environ, plain), patch.object(sys, "argv", ["autobalancer"]):
        result = CliRunner().invoke(app, shlex.split(command))
    if result.exit_code not in (0, 2):
        raise RuntimeError(f"autobalancer {command}: {result.output}") from result.exception
    shown = result.output if result.exit_code else result.stdout
    lines = [line.rstrip() for line in shown.strip().splitlines()]
    ending = [] if result.exit_code == 0 else ["$ echo $?", str(result.exit_code)]
    return "\n".join([f"$ autobalancer {command}", *lines, *ending]) + "\n"

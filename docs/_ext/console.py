"""What the commands on the pages print, from running them."""

from __future__ import annotations

import os
import shlex
import sys
from contextlib import chdir
from pathlib import Path
from unittest.mock import patch

from typer.testing import CliRunner

from autobalancer.cli import app

ROOT = Path(__file__).resolve().parents[2]
COMMANDS = {
    "check_discoidal": "check examples/machines/discoidal.toml",
    "check_annotated": "check docs/machines/annotated.toml",
    "check_chamber": "check docs/machines/chamber.toml",
    "check_design": "check docs/machines/design.toml",
    "run_design": "run docs/machines/design.toml --out out/design.nc",
    "check_wrong": "check docs/machines/wrong.toml",
    "check_misfit": "check docs/machines/misfit.toml",
    "check_thin_oil": "check docs/machines/thin_oil.toml",
    "catalog_friction": "catalog friction",
    "run_discoidal": "run examples/machines/discoidal.toml --out out/run.nc",
}


def pages() -> dict[str, str]:
    """The commands as typed at the top of a checkout, each with its output and, if not 0, its exit code."""
    return {f"{name}.txt": _transcript(command) for name, command in COMMANDS.items()}


def _transcript(command: str) -> str:
    plain = {"COLUMNS": "92", "NO_COLOR": "1", "TERM": "dumb"}
    with chdir(ROOT), patch.dict(os.environ, plain), patch.object(sys, "argv", ["autobalancer"]):
        result = CliRunner().invoke(app, shlex.split(command))
    if result.exit_code not in (0, 2):
        raise RuntimeError(f"autobalancer {command}: {result.output}") from result.exception
    shown = result.output if result.exit_code else result.stdout
    lines = [line.rstrip() for line in shown.strip().splitlines()]
    ending = [] if result.exit_code == 0 else ["$ echo $?", str(result.exit_code)]
    return "\n".join([f"$ autobalancer {command}", *lines, *ending]) + "\n"

"""Names of users and runs: checked, so that no path leaves the folder of its user."""

from __future__ import annotations

import re
import secrets
from datetime import UTC, datetime
from pathlib import Path

from autobalancer.errors import QuestionError

LOCAL = "local"  # the user of a server without tokens
USER = re.compile(r"[a-z0-9][a-z0-9_-]{0,31}")
RUN = re.compile(r"\d{8}-\d{6}-[0-9a-f]{6}")


def user_folder(root: Path, user: str) -> Path:
    """The folder of a user.

    Raises
    ------
    QuestionError
        If the name is not possible.
    """
    if not USER.fullmatch(user):
        raise QuestionError(
            f"user {user[:40]!r}: not possible; take up to 32 small letters, digits, '-' and '_', a letter or digit first"
        )
    return root / user


def run_folder(home: Path, name: str) -> Path:
    """The folder of a run in that of its user.

    Raises
    ------
    QuestionError
        If the name is not one that :func:`new_name` makes.
    """
    if not RUN.fullmatch(name):
        raise QuestionError(f"run {name[:40]!r}: not the name of a run")
    return home / "runs" / name


def new_name() -> str:
    """A new name of a run: date, time (UTC) and six random digits."""
    return f"{datetime.now(UTC):%Y%m%d-%H%M%S}-{secrets.token_hex(3)}"

"""A command that tries the places of its files before it computes."""

from __future__ import annotations

from typing import Any

from typer.core import TyperCommand

OUTPUTS = ("out", "plot", "means", "carried")


class Command(TyperCommand):
    """Refuses a file that cannot be written before the work is done, not after it."""

    def invoke(self, ctx: Any) -> Any:
        from autobalancer.safe_file import ready_to_write

        given = (ctx.params.get(name) for name in OUTPUTS)
        ready_to_write(*(path for path in given if path is not None and path.suffix))
        return super().invoke(ctx)

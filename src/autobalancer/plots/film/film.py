"""A film on disk that shows itself in a notebook."""

from __future__ import annotations

from base64 import b64encode
from pathlib import Path

EMBEDDED = 30_000_000  # bytes of a film that a notebook takes into itself


class Film(type(Path())):  # type: ignore[misc]
    """The path of a film; a notebook shows the film in place of the path."""

    def _repr_html_(self) -> str | None:
        kind = self.suffix.lower().removeprefix(".")
        if kind not in ("mp4", "gif") or not self.is_file() or self.stat().st_size > EMBEDDED:
            return None
        data = b64encode(self.read_bytes()).decode("ascii")
        if kind == "gif":
            return f'<img src="data:image/gif;base64,{data}" style="max-width:100%">'
        return f'<video controls loop muted style="max-width:100%" src="data:video/mp4;base64,{data}"></video>'

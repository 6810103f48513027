"""Pictures of the gallery that were made without pyplot, as all pictures of the package are."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from weakref import WeakSet

from sphinx_gallery.scrapers import figure_rst

from autobalancer.plots.style import Picture

shown: WeakSet[Picture] = WeakSet()


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """What a cell draws, under a name or in its last line, once."""
    paths = []
    for value in list(block_vars["example_globals"].values()):
        if isinstance(value, Picture) and value not in shown:
            shown.add(value)
            paths.append(str(Path(next(block_vars["image_path_iterator"]))))
            value.savefig(paths[-1], dpi=110)
    return str(figure_rst(paths, gallery_conf["src_dir"]))

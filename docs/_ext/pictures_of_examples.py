"""For sphinx-gallery: the figures of an example, which pyplot does not know because they are made without it."""

from __future__ import annotations

from typing import Any

from sphinx_gallery.scrapers import figure_rst

from autobalancer.plots.style import Picture


def scrape(block: Any, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the figure that is the value of a block, or that it gave a name, once each."""
    names = []
    for figure in list(block_vars["example_globals"].values()):
        if isinstance(figure, Picture) and not getattr(figure, "in_gallery", False):
            path = next(block_vars["image_path_iterator"])
            figure.savefig(path, dpi=110)
            figure.in_gallery = True
            names.append(path)
    return str(figure_rst(names, gallery_conf["src_dir"])) if names else ""


def _get_sg_image_scraper() -> Any:
    return scrape

"""Catalogs: bearings, ball materials and fluids, each entry with its source and its doubts.

The tables are files in ``catalog/data``; they are read when first asked for and kept. All values handed out
are SI.
"""

from autobalancer.public_names import public as _public

__getattr__, __dir__, __all__ = _public("catalog", globals())

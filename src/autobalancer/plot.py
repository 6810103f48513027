"""Pictures of runs and results, each a Matplotlib figure; ``style`` is their common look."""

from autobalancer.public_names import public as _public

__getattr__, __dir__, __all__ = _public("plot", globals())

"""Deep chambers: archives of runs, studies over ball number and friction, measures of their own."""

from autobalancer.public_names import public as _public

__getattr__, __dir__, __all__ = _public("chamber", globals())

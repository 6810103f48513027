"""Closed-form physical laws on plain numbers and arrays, each with its source.

SI in, SI out: meter, kilogram, second, kelvin. A law knows no machine, no file and no catalog; it may be used
on its own. What lies outside the range in which a law was published is refused with a ``QuestionError``.
"""

from autobalancer.public_names import public as _public

__getattr__, __dir__, __all__ = _public("laws", globals())

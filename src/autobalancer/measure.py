"""From measured data to numbers: signals, receptances, decays, ball angles, drag and rolling resistance."""

from autobalancer.public_names import public as _public

__getattr__, __dir__, __all__ = _public("measure", globals())

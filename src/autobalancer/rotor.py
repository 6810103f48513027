"""The rotor itself: modes, critical speeds, responses, and which rotor has measured ones."""

from autobalancer.public_names import public as _public

__getattr__, __dir__, __all__ = _public("rotor", globals())

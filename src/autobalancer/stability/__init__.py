"""From which speed on the balancer works, how sure that is, and what happens otherwise.

One room for each question; from the bottom up: ``host``, ``states``, then ``friction``, ``averaged``, ``stall`` and
``continuation``, then ``periodic``, then ``maps``, ``basins`` and ``diagrams``, then ``summary``.
"""

from autobalancer.public_names import public as _public

__getattr__, __dir__, __all__ = _public("stability", globals())

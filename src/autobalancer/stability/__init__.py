"""From which speed on the balancer works, how sure that is, and what happens otherwise.

One room for each question; from the bottom up: ``host``, ``states``, then ``friction``, ``averaged``, ``stall`` and
``continuation``, then ``periodic``, then ``borders``, ``basins`` and ``diagrams``, then ``summary``.
"""

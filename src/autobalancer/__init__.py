"""Automatic ball balancers: describe the machine, simulate it, see what the balls do.

    >>> import autobalancer as ab
    >>> machine = ab.example("discoidal")
    >>> run = ab.simulate(machine)
    >>> print(ab.verdict(run))
    >>> figure = ab.plot.run_up(run)

The first questions are functions of the package itself; the others are in its namespaces:

- ``ab.plot``: pictures of runs and results
- ``ab.stability``: border speeds, stability maps, steady states and branches
- ``ab.rotor``: modes, critical speeds, responses, identification
- ``ab.chamber``: studies of deep chambers
- ``ab.flow``: the fluid in a race, and the drag on a ball in it
- ``ab.measure``: from measured data to numbers
- ``ab.catalog``: bearings, fluids, materials, friction, rigs and sample machines
- ``ab.laws``: closed formulas on plain numbers, and your own laws

``dir()`` of each lists its names; ``help()`` of a name explains it. A name is imported when it is first used, so that
``import autobalancer`` is light and has no side effects.
"""

from autobalancer.public_names import public as _public

__version__ = "0.2.0"
__getattr__, __dir__, __all__ = _public("", globals())
del _public

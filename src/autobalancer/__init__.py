"""Automatic ball balancers: describe the machine, simulate it, see what the balls do.

    >>> import autobalancer as ab
    >>> machine = ab.example("discoidal")
    >>> run = ab.simulate(machine)
    >>> print(ab.verdict(run))
    >>> figure = ab.plot.run_up(run)

The public names are those of ``dir(autobalancer)`` and of its namespaces, such as ``ab.plot`` and ``ab.stability``; each
is imported when it is first used, so that ``import autobalancer`` is light and has no side effects.
"""

from autobalancer.namespace import public as _public

__version__ = "0.2.0"
__getattr__, __dir__, __all__ = _public("", globals())
del _public

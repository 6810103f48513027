"""A choice between two numbers that both are known: the form of a branch that also serves several lanes at once."""

from __future__ import annotations

from autobalancer.kernels.wide import select

where = select  # (condition, one, other): ``one`` if the condition holds, else ``other``

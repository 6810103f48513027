"""Rooted trees and the order conditions of Runge-Kutta methods (Butcher 1963; Hairer et al. 1993, section II.2)."""

from __future__ import annotations

from functools import cache
from itertools import combinations_with_replacement

import numpy as np

Tree = tuple["Tree", ...]  # a root and the trees that hang on it


@cache
def trees(order: int) -> tuple[Tree, ...]:
    """All rooted trees with so many nodes."""
    return tuple(tuple(sorted(t)) for t in _forests(order - 1, order - 1))


def _forests(nodes: int, largest: int) -> list[Tree]:
    if nodes == 0:
        return [()]
    found: list[Tree] = []
    for size in range(min(nodes, largest), 0, -1):
        for count in range(1, nodes // size + 1):
            for rest in _forests(nodes - count * size, size - 1):
                found += [chosen + rest for chosen in combinations_with_replacement(trees(size), count)]
    return found


def density(tree: Tree) -> float:
    """gamma: nodes times the densities of the trees that hang on the root."""
    result = float(nodes(tree))
    for branch in tree:
        result *= density(branch)
    return result


def nodes(tree: Tree) -> int:
    return 1 + sum(nodes(branch) for branch in tree)


def elementary(tree: Tree, a: np.ndarray) -> np.ndarray:
    """Phi of every stage."""
    result = np.ones(len(a))
    for branch in tree:
        result = result * (a @ elementary(branch, a))
    return result


def order_of(weights: np.ndarray, a: np.ndarray, highest: int, *, x: float = 1.0) -> int:
    """Greatest order up to ``highest`` to which sum(weights Phi) = x^nodes / gamma holds for all trees."""
    for order in range(1, highest + 1):
        for tree in trees(order):
            phi = elementary(tree, a)
            size = np.abs(weights) @ np.abs(phi) + 1.0
            if abs(weights @ phi - x**order / density(tree)) > 1e-12 * size:
                return order - 1
    return highest

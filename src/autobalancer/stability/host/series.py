"""Power series of a few terms, so that equations with products can be differentiated as they stand."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

Numbers = NDArray[Any]  # real or complex


class Series:
    """Coefficients of h^0, h^1 ...: arrays that broadcast. Missing ones are zero; products are cut after ``order``."""

    __array_ufunc__ = None  # arrays leave products with a series to the series

    def __init__(self, parts: list[Any], order: int) -> None:
        self.parts, self.order = parts[: order + 1], order

    def __getitem__(self, power: int) -> Any:
        return self.parts[power] if power < len(self.parts) else 0.0

    def __neg__(self) -> Series:
        return Series([-part for part in self.parts], self.order)

    def __add__(self, other: Series | Numbers | float) -> Series:
        if not isinstance(other, Series):
            return Series([self[0] + other, *self.parts[1:]], self.order)
        most = max(len(self.parts), len(other.parts))
        return Series([self[k] + other[k] for k in range(most)], self.order)

    def __sub__(self, other: Series | Numbers | float) -> Series:
        return self + -other

    def __mul__(self, other: Series | Numbers | float) -> Series:
        if not isinstance(other, Series):
            return Series([part * other for part in self.parts], self.order)
        most = min(len(self.parts) + len(other.parts) - 1, self.order + 1)
        return Series([self._product(other, k) for k in range(most)], self.order)

    def _product(self, other: Series, power: int) -> Any:
        first, last = max(power - len(other.parts) + 1, 0), min(power, len(self.parts) - 1)
        return sum(self.parts[j] * other.parts[power - j] for j in range(first, last + 1))

    __rmul__ = __mul__

"""Which runs of a catalogue: conditions such as ``friction >= 0.5 and balls in [8, 9]``."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Collection, Mapping
from typing import Any

from autobalancer.errors import QuestionError
from autobalancer.units import shortened

COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda value, among: value in among,
    ast.NotIn: lambda value, among: value not in among,
}
COMBINE: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
NODES: tuple[type[Any], ...] = (
    *(ast.BoolOp, ast.UnaryOp, ast.Compare, ast.BinOp, ast.Name, ast.Constant, ast.List, ast.Tuple),
    *(ast.boolop, ast.unaryop, ast.expr_context),
    *tuple(COMPARE),
    *tuple(COMBINE),
)
LONGEST = 500  # characters of a condition
FORM = 'write conditions such as "friction >= 0.5 and balls == 8", with and, or, not, in, numbers and quoted texts'


def condition(text: str, known: Collection[str]) -> Callable[[Mapping[str, Any]], bool]:
    """A function that says of a run, given as a mapping of names to values, whether ``text`` holds.

    A comparison with a value that a run does not have does not hold. Only comparisons and arithmetic are possible;
    nothing is executed.

    Raises
    ------
    QuestionError
        If the text is no condition, or names a value that none of ``known`` is.
    """
    try:
        if len(text) > LONGEST:
            raise ValueError
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise _no_condition(text) from None
    for node in ast.walk(tree):
        if isinstance(node, ast.Name) and node.id not in known:
            raise QuestionError(
                f"where: given {node.id!r}; the runs have {', '.join(sorted(known)) or 'no values yet'}"
            )
    _check(tree, text)
    return lambda row: _holds(tree, row, text)


def _check(node: ast.AST, text: str) -> None:
    for part in ast.walk(node):
        if not isinstance(part, NODES):
            raise _no_condition(text)


def _no_condition(text: str) -> QuestionError:
    return QuestionError(f"where: given {shortened(text)}; {FORM}")


def _holds(tree: ast.expr, row: Mapping[str, Any], text: str) -> bool:
    try:
        return bool(_value(tree, row))
    except (TypeError, RecursionError):
        raise _no_condition(text) from None


def _value(node: ast.AST, row: Mapping[str, Any]) -> Any:
    match node:
        case ast.Constant():
            return node.value
        case ast.Name():
            return row.get(node.id)
        case ast.List() | ast.Tuple():
            return [_value(entry, row) for entry in node.elts]
        case ast.BoolOp():
            test = all if isinstance(node.op, ast.And) else any
            return test(bool(_value(entry, row)) for entry in node.values)
        case ast.UnaryOp():
            return _unary(node, _value(node.operand, row))
        case ast.BinOp():
            left, right = _value(node.left, row), _value(node.right, row)
            return _combined(node.op, left, right)
        case ast.Compare():
            return _compared(node, row)
    return None


def _combined(sign: ast.operator, left: Any, right: Any) -> Any:
    """Arithmetic with numbers; nothing where a value is missing, or divided by zero."""
    if left is None or right is None:
        return None
    if not all(isinstance(value, (int, float)) for value in (left, right)):
        raise TypeError
    try:
        return COMBINE[type(sign)](left, right)
    except ArithmeticError:
        return None


def _unary(node: ast.UnaryOp, value: Any) -> Any:
    if isinstance(node.op, ast.Not):
        return not value
    if value is None:
        return None
    if not isinstance(value, (int, float)):
        raise TypeError
    return -value if isinstance(node.op, ast.USub) else value


def _compared(node: ast.Compare, row: Mapping[str, Any]) -> bool:
    left = _value(node.left, row)
    for kind, other in zip(node.ops, node.comparators, strict=True):
        right = _value(other, row)
        if left is None or right is None:
            return False
        try:
            if not COMPARE[type(kind)](left, right):
                return False
        except TypeError:
            raise QuestionError(f"where: {left!r} and {right!r} cannot be compared; {FORM}") from None
        left = right
    return True

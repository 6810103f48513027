"""Results that are asked for again by machines that differ in other things, such as the matrices of a rotor and its modes.

What is remembered is a pure function of what stands in its key. Parts and arrays are known by identity, because nobody changes
them in place; they are kept with the result, so that nothing else can take their place in memory.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from threading import Lock
from typing import Any, TypeVar

Result = TypeVar("Result")


def remembered(
    most: int, by: Callable[..., tuple[Any, ...]] = lambda *given: given
) -> Callable[[Callable[..., Result]], Callable[..., Result]]:
    """A function that remembers its results for the last ``most`` different keys; no argument is given by name.

    ``by`` says what of the arguments is the key, by default all of them. Numbers, texts and bytes are known by their value (0.0
    and -0.0 differ), tuples by their entries, all else by identity.
    """

    def decorate(make: Callable[..., Result]) -> Callable[..., Result]:
        known: dict[Any, tuple[Any, Result]] = {}
        lock = Lock()

        @wraps(make)
        def found(*given: Any) -> Result:
            named = by(*given)
            key = _key(named)
            with lock:
                if key in known:
                    known[key] = known.pop(key)  # the last one to be forgotten
                    return known[key][1]
            result = make(*given)
            with lock:
                known[key] = named, result
                while len(known) > most:
                    del known[next(iter(known))]
            return result

        return found

    return decorate


def _key(value: Any) -> Any:
    if type(value) is tuple:
        return tuple([_key(entry) for entry in value])
    if isinstance(value, float):
        return value.hex()
    if value is None or isinstance(value, (int, str, bytes)):
        return value
    return id(value)

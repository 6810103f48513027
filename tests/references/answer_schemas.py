"""JSON schemas of what commands print with ``--json``, made from the answers themselves: types, units, meanings.

``ANSWERS=write pytest tests/test_command_language.py -n 0 -k fits_80`` writes the file of the package anew.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from functools import reduce
from typing import Any

import numpy as np
import xarray as xr

from autobalancer.machine.schema import ANSWERS, DIALECT

WRITES = os.environ.get("ANSWERS") == "write"
NUMBER = {"$ref": "#/$defs/number"}  # which may be unknown or infinite
KINDS = {bool: "boolean", int: "integer", str: "string", type(None): "null"}


def schema_of(plain: Any, answer: Any = None) -> dict[str, Any]:
    """The schema of a value as JSON; a dataset ``answer`` gives units and meanings of what has the same name."""
    if isinstance(plain, Mapping):
        known = answer.variables if isinstance(answer, xr.Dataset) else {}
        inner = {name: schema_of(plain[name]) | (_about(known[name]) if name in known else {}) for name in plain}
        return {"type": "object", "properties": {str(name): inner[name] for name in sorted(inner, key=str)}}
    if isinstance(plain, np.ndarray) and plain.dtype.kind in "iuf" and plain.ndim:
        return reduce(lambda inner, _: {"type": "array", "items": inner}, range(plain.ndim), NUMBER)
    if isinstance(plain, (list, tuple, set, np.ndarray)) and (not isinstance(plain, np.ndarray) or plain.ndim):
        items = [schema_of(one) for one in list(plain)[:50]]
        return {"type": "array", "items": reduce(merged, items)} if items else {"type": "array"}
    plain = plain.item() if isinstance(plain, (np.generic, np.ndarray)) else plain
    return NUMBER if isinstance(plain, float) else {"type": KINDS.get(type(plain), "string")}


def _about(variable: Any) -> dict[str, Any]:
    found = {"unit": variable.attrs.get("units"), "description": variable.attrs.get("long_name")}
    dims = {"dimensions": [str(dim) for dim in variable.dims]} if variable.dims else {}
    return {name: str(text) for name, text in found.items() if text} | dims


def merged(one: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """What fits both; the first one, where it does already."""
    if one == other or not other or not one:
        return one or other
    kinds = {kind for schema in (one, other) for kind in _kinds(schema)}
    kinds -= {"integer", "null"} if "number" in kinds else set()
    found = {name: value for name, value in (other | one).items() if name not in ("type", "$ref", "anyOf")}
    if kinds == {"number"}:
        found |= NUMBER
    elif "number" in kinds:
        found |= {"anyOf": [NUMBER, {"type": sorted(kinds - {"number"})}]}
    else:
        found["type"] = min(kinds) if len(kinds) == 1 else sorted(kinds)
    if "items" in one and "items" in other:
        found["items"] = merged(one["items"], other["items"])
    parts = [schema.get("properties", {}) for schema in (one, other)]
    if any(parts):
        names = sorted({*parts[0], *parts[1]})
        found["properties"] = {name: merged(*(part.get(name, {}) for part in parts)) for name in names}
    return found


def _kinds(schema: Mapping[str, Any]) -> list[str]:
    if "$ref" in schema:
        return ["number"]
    kinds = schema["anyOf"][1]["type"] + ["number"] if "anyOf" in schema else schema["type"]
    return list(kinds) if isinstance(kinds, list) else [kinds]


def shipped() -> dict[str, Any]:
    """The schemas in the package, by command."""
    return dict(json.loads(ANSWERS.read_text(encoding="utf-8"))["$defs"])


def write(schemas: Mapping[str, Any]) -> None:
    """Put these schemas into the package, one line for each command."""
    numbers = [{"type": ["number", "null"]}, {"enum": ["Infinity", "-Infinity"]}]
    number = {"description": "null where it is not known", "anyOf": numbers}
    lines = [
        f"{json.dumps(name)}:{json.dumps(schema, separators=(',', ':'), ensure_ascii=False)}"
        for name, schema in [*sorted(schemas.items()), ("number", number)]
    ]
    head = f'{{"$schema":"{DIALECT}","title":"What commands print with --json","$defs":{{'
    ANSWERS.write_text(head + "\n" + ",\n".join(lines) + "\n}}\n", encoding="utf-8")

"""Numbers of kernels have names."""

from __future__ import annotations

from importlib import import_module
from pkgutil import walk_packages

import numpy as np
import pytest

from autobalancer import kernels
from autobalancer.kernels.fields import Field, Record

MODULES = [
    found.name for found in walk_packages(kernels.__path__, "autobalancer.kernels.") if found.name.endswith("records")
]


@pytest.mark.parametrize("module", MODULES)
def test_every_number_of_a_record_has_a_unit_and_a_meaning(module: str) -> None:
    for name, record in vars(import_module(module)).items():
        for field in record.fields if isinstance(record, Record) else ():
            assert field.unit or np.issubdtype(field.kind, np.integer), (name, field.name)
            assert len(field.meaning) > 2, (name, field.name)


def test_who_changes_a_row_changes_the_rows_it_is_of() -> None:
    point = Record(Field("mass", "kg", "of the point"), Field("position", "m", "of the point", (3,)))
    points = point.rows(4)
    points[2].mass, points[2].position[1] = 5.0, 7.0
    assert points.mass.tolist() == [0.0, 0.0, 5.0, 0.0]
    assert points.position[2].tolist() == [0.0, 7.0, 0.0]


def test_a_row_refuses_a_name_that_its_record_does_not_have() -> None:
    point = Record(Field("mass", "kg", "of the point"))
    assert point.row(mass=2.0).mass == np.float64(2.0)
    with pytest.raises(AttributeError, match="no field weight"):
        point.row(weight=2.0)

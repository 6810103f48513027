"""Files with a wrong thing at any place: refused in words, never a fault of the program."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import pytest
from jsonschema import Draft202012Validator

import autobalancer as ab
from autobalancer.errors import AutobalancerError, QuestionError
from autobalancer.machine.part import Question
from autobalancer.measurement.balancing.runs import BalanceJob
from autobalancer.measurement.film.setup import FilmSetup
from autobalancer.measurement.load_signals import ChannelFile
from autobalancer.measurement.run_up_fit import RunUpFile
from autobalancer.studies.design.design_file import read_spec
from autobalancer.studies.study.study_file import read_study

ODD: list[Any] = [None, -1, [], [[1]], {"from": 1}]
MACHINE = ab.example("discoidal")
STUDY = """
members = 4
duration = "1 s"
show = ["peak_deflection"]
results = ["run"]
correlation = [{ between = ["stiffness", "damping"], value = 0.3 }]
joint = [{ names = ["unbalances[1].radius"], covariance = [[1e-6]], mean = ["90 mm"] }]
stop = { of = "peak_deflection", half_width = "1 um", at = 0.5, statistic = "quantile" }

[vary]
viscosity = ["5 mm^2/s"]
stiffness = { distribution = "normal", standard_deviation = "5 %", low = "1 kN/m" }
damping = { distribution = "log-normal", factor = 1.2 }
"unbalances[1].mass" = { distribution = "triangular", low = "1 g", mode = "2 g", high = "3 g" }
"ball_angle[1]" = { distribution = "discrete", values = ["1 rad", "2 rad"], weights = [1, 2] }
"rotor.mass" = { distribution = "tolerance", plus_minus = "1 %", shape = "uniform" }
"""


FILM = """
orbit_radius = "70 mm"
ball_diameter = "12 mm"
balls = 2
distortion = [0.1]
race_center = ["1 mm", 0]
marks = [{ place = ["40 mm", 0], radius = "2 mm", pixel = [1, 2] }, { place = [0, 0.04], radius = "2 mm", pixel = [3, 4] },
         { place = [-0.04, 0], radius = "2 mm", pixel = [5, 6] }, { place = [0, -0.03], radius = "2 mm", pixel = [7, 8] }]
rotor_marks = [{ place = ["20 mm", 0], radius = "2 mm" }]
"""


def places(table: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    for key, value in table.items() if isinstance(table, dict) else enumerate(table):
        yield (*path, key)
        if isinstance(value, (dict, list)):
            yield from places(value, (*path, key))


def with_odd(table: dict[str, Any], path: tuple[Any, ...], value: Any, *, machine: bool = True) -> dict[str, Any]:
    changed: Any = copy.deepcopy(table)
    part = changed
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = value
    return {**changed, "machine": MACHINE} if machine else changed


@pytest.mark.parametrize(
    ("read", "text"),
    [
        (FilmSetup, FILM),
        (
            ChannelFile,
            '[channels.x]\ncolumn = "ai0"\nunit = "V"\ndirection = 45\n[channels.clock]\nquantity = "time"\n',
        ),
        (BalanceJob, ab.catalog.example_path("two_plane_job").read_text(encoding="utf-8")),
        (RunUpFile, ab.catalog.example_path("rodrigues_critical_speeds").read_text(encoding="utf-8")),
    ],
)
def test_a_measured_file_is_read_or_refused_with_the_path_of_the_key_by_its_schema_too(
    read: type[Question], text: str
) -> None:
    table = tomllib.loads(text)
    schema = Draft202012Validator(read.model_json_schema())
    assert schema.is_valid(table)
    read(**table)
    for path in places(table):
        for value in ODD[1:]:
            odd = with_odd(table, path, value, machine=False)
            if schema.is_valid(odd):
                continue  # what only the reader can know, such as a number of balls, it may refuse
            with pytest.raises(QuestionError) as raised:
                read(**odd)
            assert any(one[:1] == path[:1] for one, _ in raised.value.problems), (path, value)


@pytest.mark.parametrize("name", ["study", "centrifuge_design"])
def test_whatever_stands_at_any_place_is_read_or_refused_in_words(name: str) -> None:
    text = STUDY if name == "study" else ab.catalog.example_path(name).read_text(encoding="utf-8")
    read: Callable[[dict[str, Any]], Any] = read_study if name == "study" else read_spec
    table = tomllib.loads(text)
    table.pop("machine", None)
    read({**table, "machine": MACHINE})
    for path in places(table):
        for value in ODD:
            with suppress(AutobalancerError):
                read(with_odd(table, path, value))

"""Several machines side by side, and the variants of the race in figure 2.5 of Spannan (2021)."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from tests.references.chamber_machines import small_machine
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError, RangeWarning, UnitError
from autobalancer.studies.compare import compare

pytestmark = pytest.mark.filterwarnings("ignore::autobalancer.errors.RangeWarning")  # the rig's law of drag is linear

PLAIN, PINS, SPRINGS = (ab.catalog.example_path(f"variant_{name}") for name in ("plain", "pins", "springs"))


@pytest.fixture(scope="module")
def three():
    return compare([PLAIN, PINS, SPRINGS], at=["40 rad/s", "500 rad/s"])


def test_a_row_has_the_measures_of_the_machine_by_itself(three):
    run = ab.simulate(PLAIN, save=[ab.Envelope(500), ab.LastRevolutions()])
    alone = ab.run_measures(run)
    row = three.sel(machine="Plain race")
    assert float(row["peak_deflection"]) == float(alone["peak_deflection"])
    assert float(row["settling_time"]) == float(alone["settling_time"].max())
    assert str(row["verdict"].values) == ab.verdict(run).word == "balanced"


def test_below_the_critical_speed_free_balls_add_to_the_unbalance_and_pins_keep_them_from_it(three):
    mass, stiffness, damping, speed, unbalance = 12.27 + 2 * 6.669e-3, 44654.0, 68.37, 40.0, 5.5e-3 * 0.108
    rotor = speed**2 / abs(stiffness - mass * speed**2 + 1j * damping * speed)
    deflection = three["deflection_at"].sel(speed=40.0)
    assert float(deflection.sel(machine="Pins")) == pytest.approx(
        unbalance * rotor, rel=1e-2
    )  # pockets give way a little
    both = (
        unbalance + 2 * 6.669e-3 * 0.07695
    )  # the balls lie beside the heavy place, since they touch, and move to it yet
    assert 0.97 < float(deflection.sel(machine="Plain race")) / (both * rotor) < 1.0


def test_a_passage_that_balls_make_worse_stands_beside_the_verdict(three):
    ratio = three["peak_deflection"] / three["peak_without_balls"]
    held = ab.simulate(PLAIN, hold_balls=True, save=[ab.Envelope(500), ab.LastRevolutions()])
    assert float(three["peak_without_balls"][0]) == float(ab.run_measures(held)["peak_deflection"])
    assert ratio.values == pytest.approx([2.25, 1.0, 1.36], abs=0.01)  # pins keep the balls apart until they balance
    (words,) = (column.values for column in three.columns() if column.head == "verdict")
    assert list(words) == [
        "balanced, 2.25 times as much on the way",
        "balanced",
        "partly balanced, 36.2 % worse on the way",
    ]


def test_springs_between_the_balls_do_not_let_them_balance(three):
    assert str(three["verdict"].sel(machine="Springs along the race").values) == "partly balanced"
    assert float(three["vibration"].sel(machine="Springs along the race")) > 1e-5
    assert float(three["vibration"].sel(machine="Pins")) < 1e-9


def test_a_speed_that_the_rotor_never_has_is_not_known(three):
    assert np.isnan(three["deflection_at"].sel(speed=500.0)).all()


def test_the_border_is_that_of_the_machine(three):
    (border,) = ab.stability.borders(PLAIN, only=["exact border"])
    assert float(three["exact_border"].sel(machine="Plain race")) == border.speed
    assert math.isfinite(border.speed)


def test_a_range_that_was_left_is_said_of_each_machine():
    with pytest.warns(RangeWarning) as said:
        compare({"one": PLAIN, "other": PLAIN}, duration="12 s")
    about = [str(warning.message) for warning in said if warning.category is RangeWarning]
    assert [text.partition(": the Reynolds number")[0] for text in about] == ["one", "other"]


def test_machines_of_one_name_no_machine_and_speeds_that_are_none_are_refused():
    with pytest.raises(QuestionError, match="several are called 'Plain race'"):
        compare([PLAIN, PLAIN])
    with pytest.raises(QuestionError, match="at least one machine"):
        compare([])
    with pytest.raises(QuestionError, match="at: given inf rad/s; must be finite"):
        compare([PLAIN], at=np.inf)
    with pytest.raises(UnitError, match=r"at\[2\]: given '40 m'"):
        compare([PLAIN], at=["40 rad/s", "40 m"])
    assert list(compare({"one": PLAIN, "other": PLAIN}, duration="1 s")["machine"].values) == ["one", "other"]


def test_the_command_prints_the_table_and_draws_it(tmp_path):
    picture = tmp_path / "variants.png"
    asked = ["compare", str(PLAIN), str(PINS), "--at", "40 rad/s", "--plot", str(picture), "--csv"]
    result = CliRunner().invoke(app, asked)
    assert result.exit_code == 0, result.output
    head, plain, pins = result.stdout.strip().splitlines()[:3]
    assert head.startswith("machine,at 382 rpm [mm],peak [mm]")
    assert plain.startswith("Plain race,")
    assert pins.startswith("Pins,")
    assert picture.exists()


def test_the_command_prints_json_in_si_with_the_names_of_the_result(three):
    asked = ["compare", str(PLAIN), str(PINS), "--at", "40 rad/s", "--json"]
    answer = json.loads(CliRunner().invoke(app, asked).stdout)
    assert answer["machine"] == ["Plain race", "Pins"]
    assert answer["speed"] == [40.0]
    assert answer["exact_border"] == three["exact_border"].values[:2].tolist()
    assert answer["peak_deflection"] == three["peak_deflection"].values[:2].tolist()
    assert np.shape(answer["deflection_at"]) == (2, 1)


def test_a_file_of_values_has_a_row_for_each_machine_in_si(three, tmp_path):
    ab.save_run(three, tmp_path / "three.csv")
    head, plain, *others = (tmp_path / "three.csv").read_text(encoding="utf-8").splitlines()
    assert len(others) == 2
    row = dict(zip(head.split(","), plain.split(","), strict=False))  # notes at the end have commas of their own
    assert row["machine"] == "Plain race"
    assert float(row["peak_deflection [m]"]) == float(three["peak_deflection"][0])
    assert float(row["deflection_at[40 rad/s] [m]"]) == float(three["deflection_at"][0, 0])
    ab.save_run(three.isel(speed=0, bin=0), tmp_path / "cut.csv")
    assert "deflection_at [m]" in (tmp_path / "cut.csv").read_text(encoding="utf-8")
    ab.save_run(compare([PLAIN], duration="1 s"), tmp_path / "one.csv")
    assert (tmp_path / "one.csv").read_text(encoding="utf-8").startswith("machine,peak_deflection [m],")


def test_a_comparison_shows_itself_as_a_table(three):
    assert "Springs along the race" in repr(three)
    assert "<table>" in three._repr_html_()


def test_deep_chambers_are_compared_by_their_verdicts_measures_and_bearing_forces():
    drive = {"kind": "speed", "profile": {"kind": "constant", "speed": 150.0}}
    three = small_machine(name="three balls", drive=drive)
    five = ab.chamber.variant(three, balls=5, friction=0.5).model_copy(update={"name": "five balls"})
    found = compare([three, five], at=[150.0], duration=0.2, workers=1)
    run = ab.simulate(three, duration=0.2)
    said, row = ab.verdict(run), found.sel(machine="three balls")
    assert str(row["verdict"].values) == said.word
    assert float(row["vibration"]) == said.places[0].vibration
    assert float(row["peak_deflection"]) == said.peak.deflection == float(row["deflection"].max())
    assert float(row["support_force"]) == max(one.vibrating for one in said.supports) > 0.0
    late = np.abs(found["deflection"].values[0][found["time_in_run"].values[0] > 0.1]).max()
    assert float(row["deflection_at"][0]) == pytest.approx(late, rel=1e-12)
    heads = [column.head for column in found.columns()]
    assert "bearing force" in heads
    with pytest.raises(QuestionError, match=r"^compare: given a run of deep chambers, or a result that is no run"):
        ab.compare(run, run)
    assert "exact border" not in heads
    assert [text[:14] for text in found.remarks()] == ["runs of seed 0"]
    assert ab.plot.answer(found).axes[0].get_title(loc="left") == "three balls"

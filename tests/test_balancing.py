"""Influence coefficients: published examples, exactness, conventions, uncertainty and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import QuestionError
from autobalancer.measure import BalanceRun, Reading, TrialMass, balance, four_run, load_balance_runs

MM_S, G = 1e-3, 1e-3


def vector(text: str) -> complex:
    """``3@45``: size and angle in degrees."""
    size, angle = text.split("@")
    return complex(float(size) * np.exp(1j * np.radians(float(angle))))


def read(values: list[complex] | np.ndarray) -> list[Reading]:
    return [Reading(abs(v), float(np.angle(v)), sensor=str(n)) for n, v in enumerate(values, 1)]


def vaughan_two_planes() -> list[BalanceRun]:
    """Readings of Vaughan, Static and Dynamic Balancing, Brüel & Kjær, mm/s, two bearings."""
    return [
        BalanceRun("original", read([vector("7.2@238"), vector("13.5@296")])),
        BalanceRun("trial 1", read([vector("4.9@114"), vector("9.2@347")]), [TrialMass("1", "2.5 g")]),
        BalanceRun("trial 2", read([vector("4.0@79"), vector("12.0@292")]), [TrialMass("2", "2.5 g")]),
    ]


def runs_of(
    original: np.ndarray, influence: np.ndarray, *, left_on: bool = False, names: str = "abcd"
) -> list[BalanceRun]:
    """Runs of a linear rotor with one trial mass of 1 kg in each plane after the other."""
    on, found = np.zeros(influence.shape[1], complex), [BalanceRun("original", read(original))]
    for p in range(influence.shape[1]):
        on = on * left_on
        on[p] = 1.0
        masses = [TrialMass(names[q], abs(m), float(np.angle(m))) for q, m in enumerate(on) if m]
        found.append(BalanceRun(f"trial {p + 1}", read(original + influence @ on), masses))
    return found


def masses(found) -> np.ndarray:
    return found["correction"].values * np.exp(1j * found["correction_angle"].values)


def some_rotor(sensors: int = 4, planes: int = 2, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    both = rng.standard_normal((sensors, planes + 1)) + 1j * rng.standard_normal((sensors, planes + 1))
    return both[:, 0], both[:, 1:]


def test_the_single_plane_example_of_vaughan_comes_out_to_the_printed_digit():
    # 2.01 g at -30.8 deg, as pyPRB 1.0 prints for these readings
    found = balance(
        [
            BalanceRun("0", [Reading("3.4 mm/s", "116 deg")]),
            BalanceRun("1", [Reading("1.8 mm/s", "42 deg")], [TrialMass("disk", "2 g", "0 deg")]),
        ]
    )
    assert round(float(found.correction[0]) / G, 2) == 2.01
    assert round(float(np.degrees(found.correction_angle[0])), 1) == -30.8


def test_the_two_plane_example_of_vaughan_comes_out_to_the_printed_digit():
    # 2.95 g at 50.2 deg and 2.84 g at -81.9 deg, as pyPRB 1.0 prints
    found = balance(vaughan_two_planes())
    assert np.round(found.correction.values / G, 2).tolist() == [2.95, 2.84]
    assert np.round(np.degrees(found.correction_angle.values), 1).tolist() == [50.2, -81.9]
    assert found.residual.max() < 1e-12


def test_two_planes_agree_with_an_independent_program():
    peer = pytest.importorskip("pyPRB")
    original, influence = some_rotor(2)
    runs = [original, original + influence[:, 0], original + influence[:, 1]]
    v = [[peer.VibrationVector(abs(z), float(np.degrees(np.angle(z)))) for z in run] for run in runs]
    trial = [peer.MassVector(1.0, 0.0), peer.MassVector(1.0, 0.0)]
    job = peer.DynamicBalancing(*v[0], *v[1], *v[2], trial_mass_1=trial[0], trial_mass_2=trial[1])
    other = [m.amplitude * np.exp(1j * np.radians(m.phase)) for m in job.compute_compensation()]
    np.testing.assert_allclose(masses(balance(runs_of(original, influence))), other, rtol=1e-9)


def test_the_least_squares_example_of_goodman_comes_out_to_the_printed_digit():
    # Goodman (1964): three readings, two planes, 0.81 and 1.48 at 0 deg, as the tests of hsbalance quote it
    influence = np.array([[3, -2], [5, -2], [5, -3]], complex)
    found = balance(runs_of(np.array([1, -1, 0], complex), influence))
    np.testing.assert_allclose(np.round(masses(found), 2), [0.81, 1.48])


def test_a_trial_mass_left_on_gives_the_printed_corrections_of_feese_and_grazier():
    # Balance This! (2004), two planes, four probes, first trial weight left on: 15.3 at 3 deg, 6.6 at 113 deg
    aft, forward = TrialMass("aft", 11.1, "35 deg"), TrialMass("forward", 3.7, "135 deg")
    found = balance(
        [
            BalanceRun("original", read([vector(t) for t in (".68@32", ".56@86", "1.94@231", "2.07@335")])),
            BalanceRun("1", read([vector(t) for t in ("1.31@1", "1.25@75", ".93@251", "1@342")]), [aft]),
            BalanceRun("2", read([vector(t) for t in (".54@9", ".52@75", ".81@196", ".9@296")]), [aft, forward]),
        ]
    )
    assert np.round(found.correction.values, 1).tolist() == [15.3, 6.6]
    assert np.round(np.degrees(found.correction_angle.values)).tolist() == [3.0, 113.0]


FOILES = """9.8@117 17@124 7.2@114 38.5@77 55@259
2.7@43 14.3@317 4.5@213 14.3@270 45@118
12.5@323 25@261 15.2@158 30@238 124@21
22.4@92 32.6@45 23.3@315 27.8@210 138@349
26@94 40.3@9 25@330 34@213 107@349
40.3@355 43@144 29.6@61 65.4@322 90@280
20.6@339 32.3@152 36.7@41 61.8@322 58@354
12.6@226 37.6@52 18.8@153 26@176 108@201
13.4@209 26.9@76 47.5@98 71.7@312 88@190
13.4@154 22.4@307 52@299 102@165 56@48
5.4@24 7.2@199 22.4@2 27.8@99 73@158"""


@pytest.mark.parametrize(
    ("largest", "printed"),
    [
        (None, ["4.42@88", "2.92@352", "1.588@322", "1.928@304"]),
        (3.402, ["3.402@91", "2.325@354", "1.361@318", "1.786@305"]),
    ],
)
def test_the_least_greatest_residual_is_not_above_that_of_foiles_allaire_and_gunter(largest, printed):
    # (2000), eleven readings, four planes; their coefficients are printed to two or three digits, so are the corrections
    table = np.array([[vector(t) for t in line.split()] for line in FOILES.splitlines()])
    influence, original = table[:, :4], table[:, 4]
    found = balance(runs_of(original, influence), goal="greatest", largest=largest)
    theirs = np.array([vector(t) for t in printed])
    assert found.residual.max() <= np.abs(original + influence @ theirs).max()
    assert largest is None or found.correction.max() <= largest * (1.0 + 1e-9)
    assert np.abs(masses(found) - theirs).max() < 0.06 * np.abs(theirs).max()


@pytest.mark.parametrize("left_on", [False, True])
def test_the_vibration_with_masses_in_holes_is_that_of_the_rotor_with_just_these(left_on):
    original, influence = some_rotor(3)
    runs, stock = runs_of(original, influence, left_on=left_on), ["300 g", "0.5 kg"]
    found = balance(runs, holes=9, stock=stock, deviation=0.01)

    def seen(word: str) -> np.ndarray:
        """What the rotor does with the parts of the corrections, or of the changes, on it."""
        on = found.run_mass.values[-1] * np.exp(1j * found.run_mass_angle.values[-1]) * (word == "change")
        for p, name in enumerate("ab"):
            parts = found.isel(part=found.part_of.values == f"{word} in plane {name}")
            assert set(parts.part_mass.values.tolist()) <= {0.3, 0.5}
            on[p] += (parts.part_mass * np.exp(1j * parts.part_angle)).sum().item()
        return original + influence @ on

    def said(name: str) -> np.ndarray:
        return found[name].values * np.exp(1j * found[f"{name}_phase"].values)

    np.testing.assert_allclose(said("residual"), seen("correction"), atol=1e-12)
    assert ("left_on_residual" in found) == left_on
    if left_on:
        np.testing.assert_allclose(said("left_on_residual"), seen("change"), atol=1e-12)
    # splitting adds to what the exact masses leave, and masses of any size add nothing
    exact, any_size = balance(runs, deviation=0.01), balance(runs, holes=9, deviation=0.01)
    assert (found.residual**2).sum() > 1.1 * (exact.residual**2).sum()
    np.testing.assert_allclose(any_size.residual, exact.residual, rtol=1e-9)
    assert f"to {1e6 * float(found.residual[0]):.0f} +- " in dict(found.facts())["sensor 1"]
    with pytest.raises(QuestionError, match="stock: given without holes"):
        balance(runs, stock=stock)


@pytest.mark.parametrize("left_on", [False, True])
def test_a_linear_rotor_comes_to_rest_whether_trial_masses_stay_on_or_not(left_on):
    original, influence = some_rotor(2)
    found = balance(runs_of(original, influence, left_on=left_on))
    np.testing.assert_allclose(original + influence @ masses(found), 0.0, atol=1e-12)
    # what is on the rotor in the last run comes off, or stays and only the change is put on
    said = dict(found.facts())["masses of the runs"]
    on = found.run_mass.values[-1] * np.exp(1j * found.run_mass_angle.values[-1])
    assert said.count(" in plane ") == np.count_nonzero(on) == 1 + left_on
    assert said.startswith("either take off") == left_on
    change = found.change.values * np.exp(1j * found.change_angle.values)
    np.testing.assert_allclose(original + influence @ (on + change), 0.0, atol=1e-12)
    np.testing.assert_allclose(
        found.influence.values * np.exp(1j * found.influence_phase.values), influence, atol=1e-12
    )


def test_lags_and_angles_against_rotation_are_the_mirror_image_of_leads():
    original, influence = some_rotor()
    plain = balance(runs_of(original, influence))
    mirrored = [
        BalanceRun(
            run.name,
            [Reading(one.amplitude, -one.phase, one.sensor) for one in run.readings],
            [TrialMass(mass.plane, mass.mass, -mass.angle) for mass in run.masses],
        )
        for run in runs_of(original, influence)
    ]
    other = balance(mirrored, phase="lag", angles="against rotation")
    np.testing.assert_allclose(other.correction, plain.correction)
    np.testing.assert_allclose(other.correction_angle, -plain.correction_angle)


def test_speeds_are_channels_of_their_own_and_weights_favor_a_sensor():
    original, influence = some_rotor(3, 1)
    runs = [
        BalanceRun(run.name, [Reading(r.amplitude, r.phase, "left", f"{1000 * n} rpm") for n, r in enumerate(run.readings, 1)],
                   run.masses)
        for run in runs_of(original, influence)
    ]  # fmt: skip
    found = balance(runs)
    a, v = influence[:, 0], original
    assert masses(found)[0] == pytest.approx(-(a.conj() @ v) / (a.conj() @ a))
    heavy = balance(runs_of(original, influence), weights={"1": 1e4})
    assert masses(heavy)[0] == pytest.approx(-v[0] / a[0], rel=1e-6)


def test_stated_deviations_are_those_of_many_repeated_jobs():
    original, influence = some_rotor(3, 2, seed=5)
    share, rng = 0.01, np.random.default_rng(1)
    stated = balance(runs_of(original, influence), deviation=share)
    exact = np.array([original, original + influence[:, 0], original + influence[:, 1]])
    split = balance(runs_of(original, influence), deviation=share, holes=8, stock=["200 g", "500 g"])
    on = [sum(split.part_mass.values[own] * np.exp(1j * split.part_angle.values[own]))
          for own in (split.part_of.values == f"correction in plane {name}" for name in "ab")]  # fmt: skip
    seen, left = [], []
    for _ in range(400):
        noise = (rng.standard_normal(exact.shape) + 1j * rng.standard_normal(exact.shape)) * share * np.abs(exact)
        v = exact + noise
        columns = np.column_stack([v[1] - v[0], v[2] - v[0]])
        seen.append(np.linalg.lstsq(columns, -v[0], rcond=None)[0])
        left.append(v[0] + columns @ on)
    off = np.sqrt(0.5 * (np.abs(left - (original + influence @ on)) ** 2).mean(axis=0))
    np.testing.assert_allclose(split.residual_deviation, off, rtol=0.1)  # 800 numbers: 2.5 %, thrice over three sensors
    scatter = np.std(np.abs(seen), axis=0)
    np.testing.assert_allclose(
        stated.correction_deviation, scatter, rtol=0.15
    )  # 400 jobs: 3.5 %, twice over both, and curvature


def test_more_runs_than_needed_give_the_deviation_by_their_scatter():
    original, influence = some_rotor(3, 1)
    exact = runs_of(original, influence)
    again = BalanceRun("again", read(original * 1.01), [])
    found = balance([*exact, again])
    assert found.attrs["deviations_from"] == "scatter of the runs"
    assert 0.0 < float(found.correction_deviation[0]) < 0.03 * float(found.correction[0])
    assert "uncertainty is not known" in balance(exact).attrs["warnings"]


def test_a_trim_run_of_a_linear_rotor_asks_for_no_change_and_another_one_is_told():
    original, influence = some_rotor(2)
    first = balance(runs_of(original, influence), deviation=0.01)
    rough = np.round(masses(first), 1)
    on = [TrialMass(name, abs(m), float(np.angle(m))) for name, m in zip("ab", rough, strict=True)]
    trim = BalanceRun("trim", read(original + influence @ rough), on, trim=True)
    found = balance([*runs_of(original, influence), trim], deviation=0.01)
    np.testing.assert_allclose(masses(found), masses(first), rtol=1e-9)
    np.testing.assert_allclose(found.change * np.exp(1j * found.change_angle), masses(first) - rough, atol=1e-9)
    odd = BalanceRun("trim", read(original + influence @ rough + 5.0), on, trim=True)  # predicted +- 0.8
    assert (
        "trim run 'trim' does not follow"
        in balance([*runs_of(original, influence), odd], deviation=0.01).attrs["warnings"]
    )


def with_trim(share: float = 0.02, seed: int | None = None, put_on: float = 1.0, off: complex = 0.0):
    """10 mm/s at 0 deg, with 5 g at 90 deg 10 mm/s at 30 deg, and a trim run with ``put_on`` times the correction it names."""
    noise = np.zeros(3) if seed is None else share * np.random.default_rng(seed).standard_normal((3, 2)) @ [1.0, 1j]
    true = np.array([vector("10@0"), vector("10@30")])  # mm/s
    seen, trial = true * (1.0 + noise[:2]), 5.0 * np.exp(0.5j * np.pi)  # g
    named = -seen[0] / (seen[1] - seen[0]) * trial
    after = (true[0] + (true[1] - true[0]) / trial * put_on * named + off) * (1.0 + noise[2])
    runs = (("original", seen[0], 0.0), ("trial", seen[1], trial), ("trim", after, named))
    return balance(
        [
            BalanceRun(
                name,
                [Reading(f"{abs(v):.9g} mm/s", float(np.angle(v)))],
                [TrialMass("a", G * abs(m), float(np.angle(m)))] if m else [],
                trim=name == "trim",
            )
            for name, v, m in runs
        ],
        deviation=share,
    )


def alarms(found) -> bool:
    return "does not follow" in found.attrs["warnings"]


def test_a_trim_run_is_compared_with_the_deviation_of_its_difference_from_the_prediction():
    found = with_trim(off=0.3)
    # V0 + a w with w = -V0 / a: the errors of both readings, each times 1 / a w and so |V0 / (V1 - V0)| = 1.932
    prediction = 0.02 * 10.0 * np.sqrt(2.0) / np.abs(vector("1@30") - 1.0)
    assert float(found.misfit[-1, 0]) == pytest.approx(0.3 / np.hypot(prediction, 0.02 * 0.3), rel=1e-6)
    assert not alarms(found)
    assert np.isnan(found.misfit.values[:2]).all()  # no others say what these should be


@pytest.mark.parametrize("share", [0.01, 0.02])
def test_one_percent_of_correct_trim_runs_alarm_and_all_with_a_wrong_mass(share):
    told = [alarms(with_trim(share, seed)) for seed in range(60)]
    assert sum(told) <= 4  # 0.6 on average; more than 4 have a chance of 0.04 %
    assert all(alarms(with_trim(share, seed, put_on=1.0 + 40.0 * share)) for seed in range(10))


def test_runs_beyond_those_needed_are_compared_with_a_fit_without_them():
    original, influence = some_rotor(1, 1)
    once = runs_of(original, influence)
    odd = BalanceRun("odd", read(original + influence @ [0.5] + 0.05), [TrialMass("a", 0.5)])
    both, without = balance([*once, odd], deviation=0.01), balance(once, deviation=0.01)
    left = float(
        np.abs(odd.readings[0].amplitude * np.exp(1j * odd.readings[0].phase) - original - influence @ [0.5])[0]
    )
    sure = 0.01 * np.sqrt(
        odd.readings[0].amplitude ** 2 + (0.5 * without.reading.values**2).sum() * 0.5
    )  # the others give the mean of both
    np.testing.assert_allclose(both.misfit.values[-1, 0], left / sure, rtol=1e-6)
    np.testing.assert_allclose(both.misfit.values, both.misfit.values[-1, 0], rtol=1e-6)  # three runs, two unknowns
    # where only their scatter gives the deviation, few runs cannot alarm by chance
    assert not alarms(balance([*once, odd]))


def test_masses_in_planes_that_are_not_corrected_come_off_after_a_trim_run():
    original, influence = some_rotor(3)
    on = [TrialMass("a", 0.4, 0.3), TrialMass("b", 0.7, 1.0)]
    masses_on = np.array([0.4 * np.exp(0.3j), 0.7 * np.exp(1j)])
    trim = BalanceRun("trim", read(original + influence @ masses_on), on, trim=True)
    found = balance([*runs_of(original, influence), trim], planes=["a"], deviation=0.01)
    without = balance(runs_of(original, influence), planes=["a"], deviation=0.01)
    np.testing.assert_allclose(masses(found), masses(without), rtol=1e-9)
    np.testing.assert_allclose(found.residual, np.abs(original + influence[:, 0] * masses(found)), rtol=1e-9)
    assert "in plane b, which comes off, on" in dict(found.facts())["masses of the runs"]
    least = balance([*runs_of(original, influence), trim], planes=["a"], largest=0.1)  # of the whole correction
    assert float(least.correction[0]) == pytest.approx(0.1, rel=1e-6)


def test_sensors_of_different_kinds_are_shown_in_their_own_units():
    def both(displacement: str, velocity: str) -> list[Reading]:
        return [
            Reading(displacement, "0 deg", sensor="shaft"),
            Reading(velocity, "0 deg", sensor="case"),
        ]

    runs = [
        BalanceRun("0", both("4 mil pp", "2 mm/s rms")),
        BalanceRun("1", both("3 mil pp", "1.6 mm/s rms"), [TrialMass("a", "1 g")]),
    ]
    found = balance(runs, deviation=0.01, largest="1 g")
    facts = dict(found.facts())
    assert facts["sensor shaft"].startswith("4 to 3 +- ")
    assert facts["sensor shaft"].endswith("mil pp")
    assert facts["sensor case"].startswith("2 to 1.6 +- ")
    assert facts["sensor case"].endswith("mm/s rms")
    assert any("one over its greatest reading" in text for text in found.remarks())
    with pytest.raises(QuestionError, match="holes: given wrong; must be some of"):
        balance(runs, holes={"holes": 6, "wrong": 1})
    # more holes than three come nearer, and the answer says how many were tried
    few, more = (balance(runs, holes={"holes": 12, "masses": ["1.3 g"], "most": n}) for n in (3, 9))
    assert more.part_left[0] < few.part_left[0] / 2.0
    assert "the least with up to 3 holes" in dict(few.facts())["correction in plane a"]


def test_planes_that_act_alike_are_told_with_the_combination_that_is_not_seen():
    original, influence = some_rotor(4, 1)
    twins = np.column_stack([influence[:, 0], influence[:, 0] * (1.0 + 0.01 * np.arange(4))])
    assert "the planes act much alike" in balance(runs_of(original, twins)).attrs["warnings"]
    with pytest.raises(QuestionError, match="cannot be told apart"):
        balance(runs_of(original, np.column_stack([influence, influence])))
    one = balance(runs_of(original, np.column_stack([influence, influence])), planes=["a"])
    assert one.sizes["plane"] == 1


def again(original: np.ndarray, masses: np.ndarray | None = None, influence: np.ndarray | None = None) -> BalanceRun:
    """One run of the rotor with another unbalance, later."""
    if masses is None or influence is None:
        return BalanceRun("later", read(original))
    on = [TrialMass(name, abs(m), float(np.angle(m))) for name, m in zip("abcd", masses, strict=False)]
    return BalanceRun("later", read(original + influence @ masses), on)


@pytest.mark.parametrize("kept", ["answer", "file", "chain"])
def test_one_run_and_the_coefficients_of_an_earlier_job_balance_a_rotor_with_another_unbalance(kept, tmp_path):
    (original, influence), (new, _) = some_rotor(2), some_rotor(2, seed=9)
    earlier = balance(runs_of(original, influence), deviation=0.02)
    ab.save_run(earlier, tmp_path / "earlier.nc")
    source = earlier if kept == "answer" else tmp_path / "earlier.nc"
    if kept == "chain":  # an answer that itself used an earlier one
        ab.save_run(balance([again(original)], influence=source, deviation=0.02), source := tmp_path / "second.nc")
    found = balance([again(new)], influence=source, deviation=0.02)
    np.testing.assert_allclose(new + influence @ masses(found), 0.0, atol=1e-12)
    np.testing.assert_allclose(found.influence_deviation, earlier.influence_deviation)
    on = np.array([0.3 + 0.1j, -0.2j])  # masses that are on the rotor already
    changed = balance([again(new, on, influence)], influence=source)
    np.testing.assert_allclose(masses(changed), masses(found), rtol=1e-9)
    np.testing.assert_allclose(changed.change * np.exp(1j * changed.change_angle), masses(found) - on, atol=1e-9)


def test_deviations_of_a_one_run_balance_contain_those_of_the_coefficients():
    (original, influence), (new, _) = some_rotor(3, 2, seed=5), some_rotor(3, 2, seed=6)
    share, rng, size, angle = 0.01, np.random.default_rng(1), [], []
    true = np.linalg.lstsq(influence, -new, rcond=None)[0]
    for _ in range(60):
        noisy = []
        for run in (*runs_of(original, influence), again(new)):
            exact = np.array([r.amplitude * np.exp(1j * r.phase) for r in run.readings])
            noise = share * rng.standard_normal((2, exact.size))
            noisy.append(BalanceRun(run.name, read(exact * (1.0 + noise[0] + 1j * noise[1])), run.masses))
        found = balance(noisy[3:], influence=balance(noisy[:3], deviation=share), deviation=share)
        size += list((found.correction - np.abs(true)) / found.correction_deviation)
        angle += list(np.angle(masses(found) / true) / found.correction_angle_deviation)
    for off in (size, angle):  # 120 values each: 6.5 %, three times; planes share readings, so a little more
        assert np.sqrt(np.mean(np.square(off))) == pytest.approx(1.0, abs=0.25)


def test_a_run_out_is_taken_from_all_readings_to_the_printed_digit():
    # two planes at two bearings with a run-out of 12 at 30 deg: 1.95 at 239.5 deg and 0.89 at 139.1 deg, test/config.yaml of
    # hsbalance; without it 1.96 at -122 and 1.06 at 121 deg
    runs = [
        BalanceRun("original", read([vector("170@112"), vector("53@78")])),
        BalanceRun("1", read([vector("235@94"), vector("58@68")]), [TrialMass("a", 1.15)]),
        BalanceRun("2", read([vector("189@115"), vector("77@104")]), [TrialMass("b", 1.15)]),
    ]
    surface = [Reading(12.0, "30 deg", "1"), Reading(12.0, "30 deg", "2")]
    found = balance(runs, runout=surface, deviation=0.02)
    assert np.round(found.correction.values, 2).tolist() == [1.95, 0.89]
    assert np.round(np.degrees(found.correction_angle.values) % 360.0, 1).tolist() == [239.5, 139.1]
    assert found.residual.max() < 1e-12
    assert ("run-out", "subtracted from 6 readings") in found.facts()
    later, word = [BalanceRun("later", read([vector("60@20"), vector("80@40")]))], "had a run-out"
    assert ("run-out", "none is subtracted") in (bare := balance(later, influence=found)).facts()
    assert any(word in text for text in bare.remarks())
    whole = balance(later, influence=found, runout=surface[:1])
    assert ("run-out", "subtracted from 1 reading") in whole.facts()
    assert not any(word in text for text in whole.remarks())
    assert not any(word in text for text in balance(later, influence=balance(runs)).remarks())
    sure = balance(runs, runout=[r.model_copy(update={"amplitude_deviation": 5.0}) for r in surface], deviation=0.02)
    assert (sure.correction_deviation > found.correction_deviation).all()
    np.testing.assert_allclose(sure.influence_deviation, found.influence_deviation)  # in a difference it does not count
    trim = BalanceRun("trim", runs[0].readings, [TrialMass("a", 1e-12)], trim=True)
    np.testing.assert_allclose(masses(balance([*runs, trim], runout=surface)), masses(found), rtol=1e-6)


ONE_RUN = """
deviation = "1 %"
runout = [{ sensor = "x", amplitude = "2 um", phase = "10 deg" }]
influence = [{ plane = "fan", sensor = "x", mass = "5 g", amplitude = "20 um", phase = "30 deg" }]
[[runs]]
readings = [{ sensor = "x", amplitude = "40 um", phase = "100 deg" }]
"""


def test_coefficients_of_a_report_and_the_run_out_stand_in_the_file_of_a_job(tmp_path):
    (tmp_path / "job.toml").write_text(ONE_RUN)
    found = balance(tmp_path / "job.toml")
    wanted = -(vector("40@100") - vector("2@10")) / (vector("20@30") / 5.0)  # g
    assert masses(found)[0] / G == pytest.approx(wanted)
    assert 0.005 * abs(wanted) < float(found.correction_deviation[0]) / G < 0.03 * abs(wanted)
    assert "trial mass" not in found.attrs["warnings"]
    again = balance([BalanceRun("later", [Reading("40 um", "100 deg", "x")])], influence=tmp_path / "job.toml")
    assert masses(again)[0] / G == pytest.approx(-vector("40@100") / (vector("20@30") / 5.0))
    for old, new, words in (
        (
            'sensor = "x", amplitude = "2',
            'sensor = "y", amplitude = "2',
            "runout: no reading of sensor 'y'; there are 'x'",
        ),
        ('"2 um", phase = "10 deg"', '"2 um"', "runout: sensor 'x' has no phase"),
        ('"2 um"', '"2 mm/s"', "runout: sensor 'x' is in m/s, its readings in m"),
        (
            'sensor = "x", amplitude = "2 um"',
            'sensor = "x", speed = "300 rpm", amplitude = "2 um"',
            "leave the speed out",
        ),
        ('mass = "5 g"', 'mass = "0 g"', "influence of plane 'fan': given a mass of 0 kg; must be above zero"),
        ('sensor = "x", mass', 'sensor = "z", mass', "influence of plane 'fan': no reading of sensor 'z'"),
    ):
        (tmp_path / "job.toml").write_text(ONE_RUN.replace(old, new))
        with pytest.raises(QuestionError, match=words):
            balance(tmp_path / "job.toml")
    with pytest.raises(QuestionError, match="no coefficients of sensor '1'; there are those of sensor 'x'"):
        balance([BalanceRun("later", [Reading("4 um", "0 deg")])], influence=found)
    with pytest.raises(QuestionError, match="influence: given another result"):
        balance([BalanceRun("later", [Reading("4 um", "0 deg")])], influence=found.drop_vars("influence"))
    (tmp_path / "job.toml").write_text(ONE_RUN)
    with pytest.raises(QuestionError, match="keep one of both"):
        balance(tmp_path / "job.toml", influence=found)
    with pytest.raises(QuestionError, match=r"four-run: .*phases"):
        four_run(tmp_path / "job.toml")


def test_the_command_keeps_coefficients_and_uses_them_with_one_run(tmp_path):
    def cli(*words: str, code: int = 0) -> str:
        answer = CliRunner().invoke(app, words, env={"COLUMNS": "200"})
        assert answer.exit_code == code, answer.output
        return f"{answer.output} {answer.exception}"

    kept = tmp_path / "fan.nc"
    cli("measure", "balance", str(ab.catalog.example_path("two_plane_job")), "--out", str(kept))
    later = ab.catalog.example_path("later_run")
    said = cli("measure", "balance", str(later), "--influence", str(kept), "--deviation", "2 %",
               "--runout", "bearing 1: 0.5 mm/s @ 30 deg", "--plot", str(tmp_path / "b.png"))  # fmt: skip
    v = np.array([vector("5@20") - vector("0.5@30"), vector("4@80")])
    runs = np.array(
        [[vector(t) for t in line.split()] for line in ("7.2@238 13.5@296", "4.9@114 9.2@347", "4.0@79 12.0@292")]
    )
    wanted = np.linalg.solve((runs[1:] - runs[0]).T / 2.5, -v)
    assert all(f"{abs(w):.4g}" in said for w in wanted)
    assert "subtracted from 1 reading" in said
    assert "SENSOR: AMPLITUDE @ PHASE" in cli("measure", "balance", str(later), "--runout", "3 um", code=2)


def test_bad_runs_are_refused_with_their_names():
    original, influence = some_rotor(2)
    runs = runs_of(original, influence)
    twice = BalanceRun("trial 2", runs[2].readings, runs[1].masses)
    both = [TrialMass("a", 1.0), TrialMass("b", 1.0)]
    short = BalanceRun("t", runs[2].readings[:1], runs[2].masses)
    blind = BalanceRun("t", [Reading(1.0, sensor="1"), Reading(1.0, 0.0, "2")], runs[2].masses)
    pair = [BalanceRun("t", runs[1].readings, both), BalanceRun("u", runs[2].readings, both)]
    for given, words in (
        (runs[:1], "given 1 runs"),
        ([runs[0], runs[1], runs[1]], "two runs are called 'trial 1'"),
        ([runs[0], runs[1], short], "run 't' has no reading of sensor '2'"),
        ([runs[0], runs[1], blind], "run 't'.*no phase"),
        ([runs[0], *pair], "runs 't' and 'u' carry the same"),
        ([runs[0], pair[0]], "always change together"),
        (
            [runs[0], BalanceRun("t", runs[0].readings, runs[1].masses)],
            "run 't': the trial mass in plane 'a' changes the readings by",
        ),
    ):
        with pytest.raises(QuestionError, match=words):
            balance(given)
    with pytest.raises(QuestionError, match="plane 'a' carries the same masses in all runs"):
        balance([BalanceRun("0", runs[0].readings, twice.masses), twice])
    with pytest.raises(QuestionError, match="planes: 'c' is missing"):
        balance(runs, planes=["c"])
    with pytest.raises(QuestionError, match="more than two turns"):
        Reading("1 mm/s", 238.0)
    with pytest.raises(QuestionError, match="amplitude"):
        Reading("1 kg", 0.0)


def test_recordings_of_trial_runs_give_the_masses_that_the_computed_unbalances_ask_for(tmp_path):
    found = balance(ab.catalog.example_path("recorded_job"))
    needed = 1e-3 * np.array([0.5, 0.3125]) * np.exp(1j * np.radians([240.0, 20.0]))
    away = found.correction.values * np.exp(1j * found.correction_angle.values) / needed
    assert np.all(np.abs(abs(away) - 1.0) < 3.0 * found.correction_deviation.values / abs(needed))
    assert np.all(np.abs(np.angle(away)) < 3.0 * found.correction_angle_deviation.values)
    assert np.all(found.correction_deviation.values < 0.01 * abs(needed))
    by_hand = BalanceRun("original", read([vector("7.2@238")]))
    for given, words in (
        ({"recording": "a.csv"}, "given besides a recording"),
        ({"readings": ()}, "without a recording"),
    ):
        with pytest.raises(QuestionError, match=words):
            BalanceRun(**{"readings": by_hand.readings} | given)
    with pytest.raises(QuestionError, match="recordings are measured as vibrations lead"):
        balance(ab.catalog.example_path("recorded_job"), phase="lag")
    run_up = BalanceRun("run-up", (), recording=str(ab.catalog.example_path("run_up_signals")), start=9.0)
    with pytest.raises(QuestionError, match=r"the speed goes from .* give start and end"):
        balance([run_up, by_hand])
    with pytest.raises(QuestionError, match="the window is as long as the signals"):
        ab.measure.orders(ab.measure.load_signals(ab.catalog.example_path("as_found")), revolutions=28.9)


def test_a_file_of_runs_says_the_same_and_names_the_run_that_is_wrong(tmp_path):
    text = """
phase = "lag"
deviation = "2 %"
[[runs]]
name = "original"
readings = [{ amplitude = "3.4 mm/s", phase = "116 deg" }]
[[runs]]
name = "trial"
masses = [{ plane = "disk", mass = "2 g", angle = "0 deg" }]
readings = [{ amplitude = "1.8 mm/s", phase = "42 deg" }]
"""
    path = tmp_path / "job.toml"
    path.write_text(text)
    found = balance(path)
    assert len(load_balance_runs(path)) == 2
    assert float(np.degrees(found.correction_angle[0])) == pytest.approx(30.8, abs=0.05)  # lags: the other way around
    assert float(found.correction_deviation[0]) > 0.0
    for old, new, words in (
        ('"42 deg"', "42", r"runs\[2\].readings\[1\].phase: given 42 rad, more than two turns"),
        ("plane =", "place =", r"runs\[2\].masses\[1\].place: unknown key"),
        ('mass = "2 g", ', "", "mass: missing"),
    ):
        path.write_text(text.replace(old, new))
        with pytest.raises(QuestionError, match=words):
            balance(path)
    path.write_text("[[runs]\n")
    with pytest.raises(QuestionError, match=r"^\S+job.toml: not valid TOML"):
        balance(path)

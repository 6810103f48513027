"""How a command ends: the code says what happened, and a stop keeps what was computed."""

from __future__ import annotations

import json
import os
import signal
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.__main__ import main
from autobalancer.cli import app
from autobalancer.errors import DurationWarning, QuestionError
from autobalancer.machine import Machine

MACHINES = Path(__file__).parents[1] / "examples" / "machines"
DISCOIDAL = (MACHINES / "discoidal.toml").read_text(encoding="utf-8")


@pytest.fixture(autouse=True)
def _own_signals() -> Iterator[None]:
    kept = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield
    for number, handler in kept.items():
        signal.signal(number, handler)


def damped(tmp_path: Path, damping: str) -> str:
    path = tmp_path / "damped.toml"
    line = next(line for line in DISCOIDAL.splitlines() if line.startswith("damping"))
    path.write_text(DISCOIDAL.replace(line, f'damping = "{damping}"'))
    return str(path)


@pytest.mark.filterwarnings("ignore::autobalancer.errors.DurationWarning")
@pytest.mark.parametrize(
    ("damping", "more", "outcome", "code"),
    [
        ("1e25 N*s/m", (), "step too small", 4),
        ("1e9 N*s/m", ("--max-steps", "500"), "budget spent", 5),
        ("81 N*s/m", (), "finished", 0),
    ],
)
def test_the_exit_code_says_how_a_run_ended(
    damping: str, more: tuple[str, ...], outcome: str, code: int, tmp_path: Path
) -> None:
    out = str(tmp_path / "r.nc")
    words = ["simulate", damped(tmp_path, damping), "--duration", "0.5 s", "--out", out, "--json", *more]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == code, answer.output
    assert json.loads(answer.stdout)["outcome"] == outcome  # NaN would be no JSON for others, but Python takes it
    assert "NaN" not in answer.stdout
    assert ab.load_run(out).attrs["outcome"] == outcome


def test_a_run_that_ended_at_once_has_no_measures_but_an_outcome(tmp_path: Path) -> None:
    with pytest.warns(DurationWarning, match=r"stiff: damping brakes the rotor with a time constant of 1.2e-24 s"):
        run = ab.simulate(damped(tmp_path, "1e25 N*s/m"), duration=0.1)
    assert run.attrs["outcome"] == "step too small"
    with pytest.raises(QuestionError, match="ended before its first sample"):
        ab.run_measures(run)


def test_a_stiff_ball_is_named_before_the_run() -> None:
    machine = ab.load_machine(MACHINES / "discoidal.toml")
    race = "balancers[1].races[1]"
    stiff = ab.with_parameter(machine, f"{race}.drag", {"law": "viscous", "damping": 1e6})
    assert isinstance(stiff, Machine)
    with pytest.warns(
        DurationWarning, match=r"drag brakes ball . with a time constant of [\d.e-]+ s, so 0.1 s take about"
    ):
        run = ab.simulate(stiff, duration=0.1, max_steps=100, save=[ab.LastRevolutions(2)], method="dormand_prince_8")
    assert run.attrs["outcome"] == "budget spent"
    assert run.attrs["steps"] == 100


def test_a_stiff_ball_is_no_burden_to_long_steps() -> None:
    machine = ab.load_machine(MACHINES / "discoidal.toml")
    stiff = ab.with_parameter(machine, "balancers[1].races[1].drag", {"law": "viscous", "damping": 1e6})
    assert isinstance(stiff, Machine)
    with warnings.catch_warnings():
        warnings.simplefilter("error", DurationWarning)
        run = ab.simulate(stiff, duration=0.1, max_steps=100)
    assert run.attrs["outcome"] == "finished"
    turned = np.ptp(run["ball_angle_in_rotor"].values, axis=0)
    assert np.all(turned < 1e-9), "such balls are carried along by the rotor"


def test_sigterm_keeps_what_was_computed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "autobalancer.cli.terminal.progress_bar.Patience.look",
        lambda self, now, end: os.kill(os.getpid(), signal.SIGTERM),
    )
    words = [
        "simulate",
        str(MACHINES / "stall_and_release.toml"),
        "--duration",
        "1000000 s",
        "--out",
        str(tmp_path / "r.nc"),
    ]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 143, answer.output
    kept = ab.load_run(tmp_path / "r.nc")
    assert kept.attrs["outcome"] == "interrupted"
    assert 0.0 < kept.attrs["end_time"] < 1e6


@pytest.mark.parametrize("seed", ["-1", "99999999999999999999"])
@pytest.mark.parametrize("command", ["simulate", "basin"])
def test_a_seed_that_is_none_is_refused_before_the_work(seed: str, command: str, tmp_path: Path) -> None:
    more = {"simulate": ["--duration", "0.1 s"], "basin": ["--speed", "1200 rpm", "--random", "3"]}[command]
    out = tmp_path / "r.nc"
    answer = CliRunner().invoke(
        app, [command, str(MACHINES / "discoidal.toml"), *more, "--seed", seed, "--out", str(out)]
    )
    assert answer.exit_code == 2, answer.output
    assert "seed" in answer.stderr
    assert not out.exists()


def test_more_samples_than_memory_are_refused() -> None:
    with pytest.raises(QuestionError, match="count=2000000000"):
        ab.Samples(2_000_000_000)
    with pytest.raises(QuestionError, match="GB of states are asked for"):
        ab.simulate(
            MACHINES / "resolved_balls.toml",
            duration=1.0,
            save=[ab.Samples(10_000_000), ab.Envelope(10_000_000), ab.LastRevolutions(130_000)],
        )


def test_a_fault_of_the_program_is_one_sentence_and_code_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken() -> None:
        raise ValueError("x" * 5000 + "\x1b[2J")

    monkeypatch.setattr("autobalancer.cli.app", broken)
    monkeypatch.delenv("AUTOBALANCER_TRACEBACK", raising=False)
    with pytest.raises(SystemExit) as left:
        main()
    told = capsys.readouterr().err
    assert left.value.code == 1
    assert "a fault of the program, not yours: ValueError: xxx" in told
    assert len(told) < 700
    assert "\x1b" not in told
    monkeypatch.setenv("AUTOBALANCER_TRACEBACK", "1")
    with pytest.raises(ValueError, match="xxx"):
        main()


def test_ctrl_c_while_the_program_loads_is_no_fault(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def loading() -> None:
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError("numba._devicearray failed to import") from None

    monkeypatch.setattr("autobalancer.cli.app", loading)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # a worker in the background may ignore Ctrl-C
    try:
        with pytest.raises(SystemExit) as left:
            main()
    finally:
        signal.signal(signal.SIGINT, before)
    assert left.value.code == 130
    assert capsys.readouterr().err == ""


def test_a_design_that_is_stopped_says_where_its_runs_are(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def stopped(_file: Path, folder: Path, **_rest: object) -> None:
        folder.mkdir()
        raise KeyboardInterrupt

    monkeypatch.setattr(ab, "design", stopped)
    monkeypatch.chdir(tmp_path)
    Path("oil.toml").write_text("machine = 'discoidal.toml'\n")
    answer = CliRunner().invoke(app, ["design", "oil.toml"])
    assert answer.exit_code > 128
    assert "finished runs are kept in oil_parts, and the same command goes on" in answer.stderr

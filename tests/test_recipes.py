"""Recipes: every command of every one runs, and its output has in it what the recipe says."""

from __future__ import annotations

import contextlib
import io
import json
import re
import shlex
from pathlib import Path

import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli.main import app
from autobalancer.errors import CatalogError
from autobalancer.files.samples import RECIPES, Step, recipe, sample_names

NAMES = sample_names(*RECIPES)
PRINTED = 2e-3  # relative: a recipe shows three to five digits, of which the last may be another on another processor


def say(*words: str) -> str:
    answer = CliRunner().invoke(app, list(words), env={"COLUMNS": "120"})
    assert answer.exit_code == 0, answer.output
    return answer.output


def done(step: Step) -> str:
    """What the step prints."""
    if not step.python:
        return say(*shlex.split(step.command)[1:])
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(compile(step.command, "recipe", "exec", dont_inherit=True), {"__name__": "__main__"})
    return printed.getvalue()


def agree(expected: str, found: str) -> bool:
    """Whether two words are the same, or numbers that differ in their last digits only."""
    number = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
    if number.sub("#", expected) != number.sub("#", found):
        return False
    pairs = zip(number.findall(expected), number.findall(found), strict=True)
    return all(float(b) == pytest.approx(float(a), rel=PRINTED, abs=1e-9) for a, b in pairs)


def has(output: str, expected: str) -> bool:
    """Whether the words of a text stand in the output one after the other."""
    words, sought = ([word.rstrip(",:;.") for word in text.split()] for text in (output, expected))
    return any(
        all(agree(*pair) for pair in zip(sought, words[begin:], strict=False))
        for begin in range(len(words) - len(sought) + 1)
    )


@pytest.mark.parametrize("name", NAMES)
def test_a_recipe_gives_the_answer_that_it_says(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    steps = recipe(name).steps
    assert sum(len(step.expected) for step in steps) > 0
    for step in steps:
        output = done(step)
        missing = [text for text in step.expected if not has(output, text)]
        assert not missing, f"{step.command}\n{output}"


def test_a_word_or_a_digit_that_the_output_does_not_have_is_missed() -> None:
    assert has("release speed   652.04 rpm\n  for a drag", "speed 652.05 rpm for")
    assert not has("release speed   652.04 rpm", "speed 662.04 rpm")
    assert not has("release speed   652.04 rpm", "capture speed")


def test_twenty_recipes_ask_give_commands_and_answer() -> None:
    assert len(NAMES) >= 20
    for name in NAMES:
        one = recipe(name)
        assert one.title[-1] not in ".:", name
        assert one.question.endswith("?") or "?" in one.question or "." in one.question, name
        assert len(one.answer) > 60, name
        assert one.samples or name == "bearing_for_an_unbalance", name
    with pytest.raises(CatalogError, match="no recipe is called 'soup'; there are balance_"):
        recipe("soup")


def test_a_recipe_is_listed_printed_written_with_its_samples_and_given_as_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert "My drum stalls at 500 rpm" in say("recipe")
    listed = json.loads(say("recipe", "--json"))
    assert [one["name"] for one in listed] == list(NAMES)
    assert say("recipe", "stalled_drum", "--print").startswith("# My drum stalls at 500 rpm")
    assert not list(tmp_path.iterdir())
    assert "written: stalled_drum.md" in say("recipe", "stalled_drum")
    assert {path.name for path in tmp_path.iterdir()} == {"stalled_drum.md", "thin_oil.toml", "discoidal.toml"}
    assert ab.load_machine("thin_oil.toml").name == "Discoidal rotor with thin oil"
    told = json.loads(say("recipe", "stalled_drum", "--json"))
    assert told["samples"] == ["thin_oil", "discoidal"]
    assert told["steps"][1]["command"] == "autobalancer simulate thin_oil.toml --out thin.nc"
    assert told["steps"][1]["expected"][0].startswith("worse than without balls")

"""Names are data: no markup and no orders to the terminal, no formulas in pictures."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from matplotlib.text import Text
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.files.machine_file import parse_machine
from autobalancer.machine.schema import keys
from autobalancer.plots.style import OWN_FORMULA, as_written, heading, look, picture
from autobalancer.results.archive import Archive

ROOT = Path(__file__).parents[1]
MACHINE = (ROOT / "examples/machines/two_plane_rotor.toml").read_text(encoding="utf-8")
NAME = r"a [/] [old] :bug: $\frac{1}{$ 3$ or 4$"


def renamed() -> str:
    """The machine with a name, and a station, of markup and half a formula."""
    quoted = NAME.replace("\\", "\\\\")
    text = re.sub(r'name = "[^"]*"', lambda _: f'name = "{quoted}"', MACHINE, count=1)
    return re.sub(r'name = "lower"|station = "lower"', lambda m: m[0].replace("lower", f"{quoted} b"), text)


def test_brackets_and_emoji_codes_of_a_name_are_shown_as_they_are(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(renamed())
    checked = CliRunner().invoke(app, ["check", str(tmp_path / "m.toml")], env={"COLUMNS": "200"})
    assert checked.exit_code == 0, checked.output
    assert NAME in checked.stdout
    ran = CliRunner().invoke(
        app,
        ["simulate", str(tmp_path / "m.toml"), "--duration", "0.05 s", "--out", str(tmp_path / "r.nc")],
        env={"COLUMNS": "200"},
    )
    assert ran.exit_code == 0, ran.output
    assert f"{NAME} b" in ran.stdout


def test_a_note_in_an_archive_gives_no_orders_to_the_terminal(tmp_path: Path) -> None:
    run = Archive(tmp_path).start("one", "m", {"label": "[red]x\x1b[2J"}, {})
    run.end("[/]\x1b]0;title\x07")
    listed = CliRunner().invoke(app, ["chamber", "archive", str(tmp_path), "--show", "state", "--show", "label"])
    assert listed.exit_code == 0, listed.output
    assert "\x1b" not in listed.stdout
    assert "[red]x" in listed.stdout


def test_an_unknown_key_with_control_characters_is_written_out(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text('"\\u001b[2Jkey" = 1\n' + MACHINE)
    answer = CliRunner().invoke(app, ["check", str(tmp_path / "m.toml")])
    assert answer.exit_code == 2
    assert "\x1b" not in answer.stderr
    assert '\\x1b[2Jkey": unknown key' in answer.stderr


@pytest.mark.filterwarnings("ignore::autobalancer.errors.RangeWarning")
def test_pictures_show_a_name_with_dollars_as_it_is() -> None:
    run = ab.simulate(parse_machine(renamed()), duration=0.05)
    for draw in (ab.plot.run_up, ab.plot.race, ab.plot.orbit):
        figure = draw(run)
        figure.draw_without_rendering()
        shown = [text for text in figure.findobj(Text) if NAME in text.get_text()]
        assert shown
        assert not any(text.get_parse_math() for text in shown)


def test_formulas_of_this_package_and_powers_of_ten_stay_formulas() -> None:
    with look():
        figure = picture(3.0, 2.0)
        axes = figure.subplots()
        axes.set(xscale="log", xlim=(1.0, 1e4), xlabel="drag coefficient $c_d$", ylabel=r"$c_d\,\mathrm{Re}$")
        heading(figure, "costs 3$ or 4$")
    figure.draw_without_rendering()
    math = {text.get_text() for text in figure.findobj(Text) if "$" in text.get_text() and text.get_parse_math()}
    assert {"drag coefficient $c_d$", r"$c_d\,\mathrm{Re}$"} < math
    assert any("mathdefault" in text for text in math)
    assert "costs 3$ or 4$" not in math
    alone = Text(0, 0, "$c_d$")
    as_written(alone)
    assert alone.get_parse_math()


def test_formulas_in_pictures_of_the_gallery_are_drawn_as_formulas() -> None:
    given = {
        text
        for path in sorted((ROOT / "examples").rglob("*.py"))
        for text in re.findall(r'(?:label|title)=f?"([^"]*\$[^"]*)"', path.read_text(encoding="utf-8"))
    }
    assert given
    for text in given:
        assert OWN_FORMULA.fullmatch(text), text


def test_every_symbol_of_a_key_is_drawn_as_a_formula_on_an_axis() -> None:
    symbols = {key.symbol for listed in keys().values() for key in listed if key.symbol}
    assert {"U", r"\nu", "w_c"} < symbols
    for symbol in symbols:
        assert OWN_FORMULA.fullmatch(f"what it is, ${symbol}$ (mm)"), symbol


def test_every_command_takes_the_terminal_that_knows_no_markup() -> None:
    for path in sorted((ROOT / "src/autobalancer/cli").glob("*.py")):
        if path.name != "console.py":
            assert "from rich.console import" not in path.read_text(encoding="utf-8"), path.name

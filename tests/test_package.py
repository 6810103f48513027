"""What comes with an installed package, and what does not stand in the way."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import autobalancer as ab
from autobalancer.cli import app
from autobalancer.errors import CatalogError, QuestionError
from autobalancer.files.examples import example_text
from autobalancer.files.samples import write_example
from autobalancer.plots.film_frames import Film, film_format, write_film
from autobalancer.simulation.record import Samples

ROOT = Path(__file__).parents[1]
RUNNER = CliRunner()


def test_every_sample_machine_is_in_the_package_and_can_be_read() -> None:
    names = ab.catalog.examples()
    assert names == tuple(sorted(path.stem for path in (ROOT / "examples" / "machines").glob("*.toml")))
    assert all(ab.example(name).name for name in names)
    package = Path(ab.__file__).parent
    assert (package / "catalog" / "data" / "machines" / "discoidal.toml").is_file()
    with pytest.raises(CatalogError, match="no sample machine is called 'discoidel'; there are cfrp_planar"):
        ab.example("discoidel")


def test_a_wheel_has_every_file_of_the_package() -> None:
    """Modules because each folder is a package, stubs and data because a pattern of pyproject.toml fits them."""
    source = ROOT / "src" / "autobalancer"
    files = {path for path in source.rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    modules = {path for path in files if path.suffix == ".py"}
    assert {path.parent / "__init__.py" for path in modules} <= modules
    patterns = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"][
        "package-data"
    ]
    fit = {path for pattern in patterns["autobalancer"] for path in source.glob(pattern)}
    assert files - modules - fit == set()


def test_a_sample_machine_is_listed_printed_and_written(tmp_path: Path) -> None:
    assert "discoidal" in RUNNER.invoke(app, ["example"]).stdout
    listed = json.loads(RUNNER.invoke(app, ["example", "--json"]).stdout)
    assert [entry["name"] for entry in listed if entry["kind"] == "machine"] == list(ab.catalog.examples())
    said = RUNNER.invoke(app, ["example", "discoidal", "--out", str(tmp_path / "d.toml")])
    assert said.exit_code == 0
    assert ab.load_machine(tmp_path / "d.toml") == ab.example("discoidal")
    assert RUNNER.invoke(app, ["example", "discoidal", "--print"]).stdout == example_text("discoidal")


def test_samples_of_every_kind_are_written_and_nothing_is_overwritten(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    said = RUNNER.invoke(app, ["example", "discoidal", "rodrigues_rig", "rodrigues_plain_rotor"])
    files = {"discoidal.toml", "rodrigues_rig.toml", "rodrigues_plain_rotor.toml", "rodrigues_plain_rotor.csv"}
    assert {path.name for path in tmp_path.iterdir()} == files
    assert all(f"written: {name}" in said.stdout for name in files)
    free, measured = ab.rotor.load_measurements("rodrigues_plain_rotor.toml")
    assert free
    assert len(measured) > 0
    assert ab.catalog.example_path("discoidal").read_text() == Path("discoidal.toml").read_text()
    assert write_example("discoidal") == (Path("discoidal.toml"),)
    Path("discoidal.toml").write_text("mine")
    with pytest.raises(QuestionError, match=r"discoidal\.toml: is there already with another content"):
        write_example("discoidal")
    assert Path("discoidal.toml").read_text() == "mine"
    with pytest.raises(
        CatalogError, match=r"no sample is called 'x'; there are machines cfrp_planar, .*; rigs cfrp_rig"
    ):
        write_example("x")


def test_a_rig_without_a_name_is_a_list(tmp_path: Path) -> None:
    assert "cfrp_rig" in RUNNER.invoke(app, ["catalog", "rigs"]).stdout
    RUNNER.invoke(app, ["catalog", "rig", "cfrp_rig", "--out", str(tmp_path / "rig.toml")])
    assert (tmp_path / "rig.toml").read_text(encoding="utf-8") == example_text("cfrp_rig")


def test_dir_shows_the_public_interface_only() -> None:
    assert set(dir(ab)) == {*ab.__all__, "__version__", "machine", "errors", "units"}


def test_metadata_and_citation_agree() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert all(author["name"] in citation for author in project["authors"])
    assert f"version: {ab.__version__}" in citation
    assert not any(need.startswith("imageio") for need in project["dependencies"])
    assert any(need.startswith("imageio-ffmpeg") for need in project["optional-dependencies"]["film"])


def test_without_the_encoder_a_film_is_a_gif(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("autobalancer.plots.film_frames.find_spec", lambda name: None)
    with pytest.raises(QuestionError, match=r'pip install "autobalancer\[film\]", or end the name with \.gif'):
        film_format(tmp_path / "film.mp4")
    frame = np.zeros((32, 32, 3), np.uint8)
    write_film(tmp_path / "film.gif", iter([frame, frame + 255]), 10)
    assert (tmp_path / "film.gif").read_bytes().startswith(b"GIF8")


def test_a_film_is_a_path_that_a_notebook_shows(tmp_path: Path) -> None:
    run = ab.simulate(ab.example("stall_and_release"), duration=0.2, save=Samples(201))
    film = ab.animate(run, tmp_path / "film.gif", duration=0.2, fps=10, width=320)
    assert isinstance(film, Film)
    assert isinstance(film, Path)
    assert film == tmp_path / "film.gif"
    html = film._repr_html_()
    assert html is not None
    assert html.startswith('<img src="data:image/gif;base64,R0lGOD')
    assert Film(tmp_path / "gone.mp4")._repr_html_() is None

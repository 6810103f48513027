"""The bench without a browser: edits of a machine's text, names and paths, jobs, and who may ask the server."""

from __future__ import annotations

import ast
import asyncio
import csv
import gc
import io
import json
import os
import re
import socket
import subprocess
import sys
import threading
import time
import tomllib
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import autobalancer as ab
import autobalancer.stability.summary as summary_module
from autobalancer.app.form_fields import fields_of, in_unit, number_and_unit, written
from autobalancer.app.pages.elements import Typed
from autobalancer.app.problems import EMPTY, drawable, for_page, read, with_entry, with_value, without
from autobalancer.app.serve import LARGEST, Guard, Rules, refuse_taken, rules_for, writable
from autobalancer.app.store.jobs import CLEARED, QUEUED, Job, Jobs
from autobalancer.app.store.kept_runs import (
    LONGEST,
    STARTED,
    UNREADABLE,
    Archive,
    differences,
    exported,
    script,
    user_folder,
)
from autobalancer.app.store.pictures import svg_of
from autobalancer.app.view.packed import packed
from autobalancer.app.view.widget import module_text
from autobalancer.errors import ON_THE_PAGE, QuestionError, ResultError
from autobalancer.files.examples import example_text
from autobalancer.machine import Machine, PlanarRotor
from autobalancer.machine.keys import keys_of
from autobalancer.results.time_series import NO_TURNS, plane_vectors
from autobalancer.tables import rpm_and_si
from autobalancer.units import to_si

DISCOIDAL = example_text("discoidal")
ORBIT = ("balancers", 0, "races", 0, "orbit_radius")


def test_an_edit_changes_one_entry_and_nothing_else() -> None:
    expected = tomllib.loads(DISCOIDAL)
    expected["balancers"][0]["races"][0]["orbit_radius"] = "50 mm"
    edited = with_value(DISCOIDAL, ORBIT, "50 mm")
    assert tomllib.loads(edited) == expected
    pytest.importorskip("tomlkit")
    assert edited == DISCOIDAL.replace("76.95 mm", "50 mm"), "comments and order stay"


def test_entries_of_lists_come_and_go() -> None:
    two = with_entry(DISCOIDAL, ("unbalances",), {"moment": "3 g*mm"})
    assert len(tomllib.loads(two)["unbalances"]) == 2
    assert tomllib.loads(without(two, ("unbalances", 1))) == tomllib.loads(DISCOIDAL)
    assert "unbalances" not in tomllib.loads(without(DISCOIDAL, ("unbalances", 0)))


def test_a_field_has_the_help_of_the_documentation() -> None:
    told = {field.name: field for field in fields_of(PlanarRotor)}
    for key in keys_of(PlanarRotor):
        if key.name != "kind":
            assert told[key.name].allowed == key.value_and_default
    assert told["stiffness"].units[0] == "N/m"
    assert {field.name for field in fields_of(Machine) if field.required} >= {"name", "axis", "rotor", "drive"}


@pytest.mark.parametrize(
    ("text", "unit", "wanted"), [("76.95 mm", "m", "cm"), ("25 degC", "K", "K"), ("90 deg", "rad", "rad")]
)
def test_another_unit_of_a_field_keeps_the_quantity(text: str, unit: str, wanted: str) -> None:
    number, given = number_and_unit(text, unit) or ("", "")
    changed = written(in_unit(number, given, wanted, unit), wanted, unit)
    assert to_si(changed, unit) == pytest.approx(to_si(text, unit), rel=1e-9)


def test_what_is_wrong_is_known_by_the_path_of_its_key() -> None:
    found = read(with_value(DISCOIDAL, ORBIT, "-3 mm"))
    assert found.machine is None
    assert found.problems == {ORBIT: "given '-3 mm'; must be greater than zero"}
    assert ("rotor", "mass") in read(EMPTY).problems


@pytest.mark.parametrize("file", ["/etc/passwd", "../../secret.csv", "..\\secret.csv"])
def test_a_machine_on_the_page_reads_no_file_of_the_server(file: str) -> None:
    text = with_value(DISCOIDAL, ("balancers", 0, "races", 0, "roundness"), {"file": file})
    of_rotors = [("files", {key: file}) for key in ("file", "mass", "nodes", "rows")] + [("segments", {"file": file})]
    for one in (text, *(with_value(DISCOIDAL, ("rotor", key), value) for key, value in of_rotors)):
        found = read(one)
        assert found.machine is None
        assert "is not here" in found.message


def test_a_drawing_fits_its_page_and_has_words() -> None:
    drawn = svg_of(lambda: ab.plot.machine(ab.example("discoidal")), 'a "machine"')
    assert drawn.startswith('<svg role="img" aria-label="a &quot;machine&quot;"')
    assert "width=" not in drawn.split(">")[0]


@pytest.mark.parametrize("name", ["..", "a/b", "", "Ada", "x" * 40, "a\\b", "a\0b", ".ssh", "~"])
def test_no_name_of_a_user_or_run_leaves_its_folder(name: str, tmp_path: Path) -> None:
    with pytest.raises(QuestionError):
        user_folder(tmp_path, name)
    with pytest.raises(QuestionError):
        Archive(tmp_path).folder(name)


def test_a_new_name_is_one_that_is_accepted(tmp_path: Path) -> None:
    assert Archive(tmp_path).folder(Archive(tmp_path).new().name).parent == tmp_path / "runs"


def over(job: Job) -> None:
    for _ in range(500):
        if job.over:
            return
        time.sleep(0.01)
    raise AssertionError("the job does not end")


def turning(job: Job) -> None:
    for k in range(100_000):
        job.progress(k, 100_000)
        time.sleep(0.001)


def test_a_job_can_be_cancelled_and_one_that_takes_too_long_ends() -> None:
    jobs = Jobs(workers=2, limit=0.05)
    late = jobs.start("ada", "long", turning)
    over(late)
    assert late.state == "cancelled"
    assert "limit of 0.05 s" in late.message
    jobs.limit = 60.0
    stopped = jobs.start("ada", "long", turning)
    jobs.cancel(stopped)
    over(stopped)
    assert stopped.state == "cancelled"
    jobs.close()


def test_a_job_that_fails_says_why_and_the_next_one_runs() -> None:
    jobs = Jobs(workers=1)

    def wrong(_job: Job) -> None:
        raise QuestionError("no such speed")

    failed, good = jobs.start("ada", "wrong", wrong), jobs.start("ada", "right", lambda job: 42)
    over(good)
    assert (failed.state, failed.message, good.result) == ("failed", "no such speed", 42)
    assert jobs.of("bob") == []
    jobs.close()


def test_a_user_cannot_fill_the_queue() -> None:
    jobs, gate = Jobs(workers=1), threading.Event()
    for _ in range(QUEUED):
        jobs.start("ada", "waits", lambda job: gate.wait(5))
    with pytest.raises(QuestionError, match="wait or run already"):
        jobs.start("ada", "one more", lambda job: None)
    jobs.start("bob", "another user", lambda job: None)
    gate.set()
    jobs.close()


def test_users_take_turns_and_what_needs_too_much_memory_fails_alone() -> None:
    jobs, gate, begun = Jobs(workers=1), threading.Event(), []
    first = jobs.start("ada", "first", lambda job: gate.wait(5))
    while first.state == "waiting":
        time.sleep(0.001)
    waiting = [jobs.start(user, "", lambda job: begun.append(job.user)) for user in ("ada", "ada", "ada", "bob", "eve")]

    def large(_job: Job) -> None:
        raise MemoryError

    failed = jobs.start("eve", "", large)
    jobs.cancel(waiting[0])
    assert waiting[0].state == "cancelled", "at once"
    gate.set()
    for job in (*waiting, failed):
        over(job)
    assert begun == ["bob", "eve", "ada", "ada"]
    assert "more memory" in failed.message
    jobs.close()


def test_a_user_has_one_worker_where_several_share_them() -> None:
    jobs, gate = Jobs(workers=2, each=1), threading.Event()
    mine = [jobs.start("ada", "", lambda job: gate.wait(5)) for _ in range(2)]
    over(jobs.start("bob", "", lambda job: None))
    assert [job.state for job in mine] == ["running", "waiting"]
    gate.set()
    over(mine[1])
    jobs.close()


def test_a_folder_that_cannot_be_written_and_a_port_that_is_taken_are_said_before_the_server_starts(
    tmp_path: Path,
) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(QuestionError, match=r"cannot be written .*--folder"):
        writable(tmp_path / "file" / "bench")
    assert writable(tmp_path / "new" / "bench").is_dir()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(QuestionError, match=rf"port: {port} .*--port"):
            refuse_taken("127.0.0.1", port)


def asked(rules: Rules, path: str = "/", query: str = "", **headers: str) -> tuple[int, dict[str, Any], dict[str, str]]:
    """What a request gets: status, the state of the request behind the guard, and headers."""
    seen: dict[str, Any] = {}
    answer: list[Any] = []

    async def behind(scope: Any, receive: Any, send: Any) -> None:
        seen.update(scope["state"])
        await receive()
        await send({"type": "http.response.start", "status": 200, "headers": []})

    async def receive() -> Any:
        return {"type": "http.request", "body": b""}

    async def send(message: Any) -> None:
        answer.append(message)

    given = {"host": "127.0.0.1:8123"} | {name.replace("_", "-"): text for name, text in headers.items()}
    raw = [(name.encode(), text.encode()) for name, text in given.items()]
    scope = {"type": "http", "path": path, "query_string": query.encode(), "headers": raw}
    asyncio.run(Guard(behind, rules)(scope, receive, send))
    told = {name.decode(): text.decode() for name, text in answer[0]["headers"]}
    return answer[0]["status"], seen, told


def test_a_server_of_this_computer_answers_no_other_name_and_no_other_page() -> None:
    rules = rules_for("127.0.0.1", [])
    status, _, told = asked(rules)
    assert status == 200
    policy = dict(part.split(" ", 1) for part in told["content-security-policy"].split("; "))
    assert (policy["default-src"], policy["connect-src"], policy["object-src"]) == ("'self'", "'self'", "'none'")
    assert asked(rules, host="evil.example")[0] == 403
    assert asked(rules, origin="http://evil.example")[0] == 403
    assert asked(rules, content_length=str(LARGEST + 1))[0] == 413
    assert asked(rules, content_length="-1")[0] == 413
    assert asked(rules, content_length="9" * 5000)[0] == 413


def test_an_open_server_wants_a_token_and_knows_the_user_by_it() -> None:
    rules = rules_for("0.0.0.0", ["ada:0123456789abcdef", "bob:fedcba9876543210"])
    assert asked(rules, host="10.0.0.5")[0] == 401
    assert asked(rules, query="token=wrong")[0] == 401
    status, _, headers = asked(rules, query="token=0123456789abcdef")
    assert status == 303
    assert "HttpOnly" in headers["set-cookie"]
    assert headers["location"] == "/"
    status, state, _ = asked(rules, cookie="autobalancer_token=fedcba9876543210")
    assert (status, state["user"]) == (200, "bob")
    (made,) = rules_for("0.0.0.0", []).tokens
    assert len(made) >= 20
    with pytest.raises(QuestionError, match="at least 12"):
        rules_for("127.0.0.1", ["ada:short"])


@pytest.fixture(scope="module")
def ran() -> xr.Dataset:
    return ab.simulate(ab.example("stall_and_release"), duration=0.5, progress=False)


def unpacked(block: bytes) -> tuple[dict[str, Any], Any]:
    """What the browser reads: the head, and a function from names to arrays."""
    assert block[:4] == b"ABV1"
    length = int.from_bytes(block[4:8], "little")
    head = json.loads(block[8 : 8 + length])

    def array(name: str) -> Any:
        told = head["arrays"][name]
        size = int(np.prod(told["shape"]))
        return np.frombuffer(block, told["type"], size, 8 + length + told["at"]).reshape(told["shape"])

    return head, array


def test_the_block_of_a_run_has_what_its_result_has(ran: xr.Dataset) -> None:
    head, array = unpacked(packed(ran))
    assert array("time") == pytest.approx(ran["time"].values)
    assert array("ball") == pytest.approx(ran["ball_angle_in_rotor"].values)
    turned = (ran["x"].values + 1j * ran["y"].values) * np.exp(-1j * ran["rotor_angle"].values)
    assert array("re")[:, 0] == pytest.approx(turned.real, abs=1e-9)
    assert [ball["orbit"] for ball in head["balls"]] == pytest.approx(ran["orbit_radius"].values)
    speed = next(panel for panel in head["panels"] if panel["title"] == "speed")
    assert array(speed["lines"][0]["high"])[-1] == pytest.approx(ran["speed"].values[-1] * 30 / np.pi, rel=1e-6)


READ_AS_CODE = {"props", "classes", "style", "run_javascript", "add_head_html", "add_body_html", "add_css", "add_slot"}


def plain(node: ast.expr) -> bool:
    """Whether nothing that a user wrote can be in this: texts, constants, numbers of elements, and data written as JSON."""
    match node:
        case ast.Constant():
            return True
        case ast.Name():
            return node.id.isupper()
        case ast.Attribute():
            return node.attr == "id"
        case ast.JoinedStr():
            return all(plain(part) for part in node.values)
        case ast.FormattedValue():
            return plain(node.value)
        case ast.BinOp(op=ast.Add()):
            return plain(node.left) and plain(node.right)
        case ast.IfExp():
            return plain(node.body) and plain(node.orelse)
        case ast.Call(func=ast.Attribute(attr="dumps", value=ast.Name(id="json"))):
            return True
        case ast.Call(func=ast.Attribute(attr="get", value=ast.Name() as table), args=[_, ast.Constant()]):
            return table.id.isupper()
        case ast.Call(func=ast.Attribute(value=owner)):
            return plain(owner) and all(map(plain, [*node.args, *(one.value for one in node.keywords)]))
    return False


def test_no_text_of_a_user_is_read_as_properties_or_as_code() -> None:
    """NiceGUI evaluates properties that begin with a colon, and reads others as Python."""
    page, wrong, seen = Path(str(ab.app.__file__)).parent, [], 0
    for path in page.rglob("*.py"):
        for call in (node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)):
            asked = [one.value for one in call.keywords if one.arg == "js_handler"]
            if isinstance(call.func, ast.Attribute) and call.func.attr in READ_AS_CODE:
                asked += [*call.args, *(one.value for one in call.keywords if one.arg != "js_handler")]
            seen += len(asked)
            wrong += [f"{path.name}:{one.lineno}: {ast.unparse(one)}" for one in asked if not plain(one)]
    assert seen > 300
    assert wrong == [], "set it as data, with marked() or element.props[...]"


def test_a_run_that_cannot_be_shown_does_not_hide_the_others_and_half_a_run_goes(tmp_path: Path) -> None:
    archive, names = Archive(tmp_path), [f"20260101-00000{k}-abcdef" for k in range(5)]
    about = {"name": names[0], "machine": "D:\\unwucht\\test", "made": "", "seconds": 1, "outcome": ""}
    notes = [about, {**about, "name": names[1], "machine": 5}, {**about, "name": names[2], "tags": [[]]}, "rubbish"]
    for name, note in zip(names, notes, strict=False):
        (tmp_path / "runs" / name).mkdir(parents=True)
        (tmp_path / "runs" / name / "note.json").write_text(json.dumps(note))
    half = tmp_path / "runs" / names[4]
    half.mkdir()
    assert [entry.machine for entry in archive.found()] == [UNREADABLE] * 3 + ["D:\\unwucht\\test"]
    archive.tidy(STARTED - LONGEST)
    assert half.exists(), "somebody may be writing it"
    os.utime(half, (0, 0))
    archive.tidy(STARTED - LONGEST)
    assert [path.name for path in sorted((tmp_path / "runs").iterdir())] == names[:4]
    for name in names[:4]:
        archive.delete(name)
    assert archive.entries() == []


def test_half_a_run_is_removed_and_the_message_names_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_run: Any, path: Path) -> None:
        raise ResultError(f"{path}: the disk is full")

    monkeypatch.setattr("autobalancer.app.store.kept_runs.save_run", full)
    archive, job = Archive(tmp_path), Job(1, "ada", "run", 60.0)
    job.begun = time.monotonic()
    with pytest.raises(ResultError, match=r"^the run was not kept: run\.nc: the disk is full$"):
        archive.simulate(example_text("stall_and_release"), job, duration="0.1 s")
    assert job.result is None
    assert list((tmp_path / "runs").iterdir()) == []


def test_an_archive_keeps_finds_tags_and_deletes_runs(tmp_path: Path) -> None:
    archive, job = Archive(tmp_path / "ada"), Job(1, "ada", "run", 60.0)
    text = example_text("stall_and_release")
    job.begun = time.monotonic()
    name = archive.simulate(text, job, duration="0.5 s")
    again = Archive(tmp_path / "ada")  # after a restart
    (entry,) = again.found("stall")
    assert entry.name == name
    assert again.found("another machine") == []
    assert again.run(name).attrs["end_time"] == pytest.approx(0.5)
    again.tag(name, ["first", " first ", "", "x" * 90])
    (entry,) = again.found("first")
    assert entry.tags == ["first", "x" * 40]
    assert Archive(tmp_path / "bob").entries() == []
    assert exported(again, name, "measures.csv").startswith(b"measure,of,value,unit,meaning")  # type: ignore[union-attr]
    with pytest.raises(QuestionError, match="no such form"):
        exported(again, name, "../machine.toml")
    again.delete(name)
    assert again.entries() == []


def test_every_plane_and_every_ball_of_a_run_has_its_measures_its_picture_and_its_curve(tmp_path: Path) -> None:
    archive, job = Archive(tmp_path), Job(1, "ada", "run", 60.0)
    job.begun = time.monotonic()
    name = archive.simulate(example_text("two_plane_rotor"), job, duration="0.3 s")
    run, kept = archive.run(name), archive.entry(name).measures
    found = ab.run_measures(run)
    for measure, of, names in (
        ("residual_unbalance", "plane", ["lower", "upper"]),
        ("vibration", "place", ["lower", "upper", "support 1", "support 2"]),
        ("stalled_time", "ball", ["ball 1", "ball 2", "ball 3", "ball 4"]),
    ):
        assert [kept[f"{measure}[{which}]"][0] for which in names] == found[measure].values.tolist()
        assert found[measure].dims == (of,)
    assert kept["peak_deflection"][0] == float(found["peak_deflection"])
    table = csv.DictReader(io.StringIO(exported(archive, name, "measures.csv").decode()))  # type: ignore[union-attr]
    assert {(row["measure"], row["of"]) for row in table} >= {
        ("residual_unbalance", "upper"),
        ("stalled_time", "ball 4"),
    }
    head, array = unpacked(archive.file(name, "view.bin").read_bytes())
    assert head["names"] == ["lower", "upper"]
    heavy = array("heavy_re") + 1j * array("heavy_im")
    assert np.abs(heavy[-1]) == pytest.approx(run["plane_unbalance"].values[-1], rel=1e-6)
    panels = {panel["title"]: panel["lines"] for panel in head["panels"]}
    assert array(panels["unbalance, upper"][0]["high"])[-1] == pytest.approx(
        1e6 * float(np.abs(sum(plane_vectors(run)))[-1, 1]), rel=1e-5
    )


def test_the_words_of_the_page_name_neither_functions_nor_commands() -> None:
    assert for_page(NO_TURNS).endswith("(a run that is interrupted keeps none)")
    machine = read(with_value(example_text("stall_and_release"), ("axis",), "horizontal")).machine
    texts = [text for _, text in ab.check(machine).rows(rpm_and_si)]
    assert any("autobalancer catalog" in text for text in texts)
    assert not any("autobalancer" in for_page(text) for text in texts)
    for words, here in ON_THE_PAGE.items():
        assert for_page(f"before{words} after") == f"before{here} after"
        assert not re.search(r"autobalancer|Python|FILE", here)
    summary = ast.parse(Path(summary_module.__file__).read_text(encoding="utf-8"))
    parts = {id(part) for text in ast.walk(summary) if isinstance(text, ast.JoinedStr) for part in text.values}
    for text in ast.walk(summary):  # all that check may say, with 1 for each number and name
        if isinstance(text, ast.JoinedStr):
            said = "".join(str(part.value) if isinstance(part, ast.Constant) else "1" for part in text.values)
        elif isinstance(text, ast.Constant) and isinstance(text.value, str) and id(text) not in parts:
            said = text.value
        else:
            continue
        assert not re.search("autobalancer [a-z]", for_page(said)), said
    with pytest.raises(QuestionError) as told:
        ab.stability.equilibria(machine, 100.0)
    assert for_page(str(told.value)).endswith("run it, or take the basin of the page Stability")


def test_a_hundred_malformed_questions_change_nothing(tmp_path: Path) -> None:
    archive = Archive(tmp_path / "ada")
    (tmp_path / "secret").write_text("secret")
    for k in range(100):
        for name in ("../" * (k % 5) + "secret", "\0", "runs", f"{k}", "20261123-012345-zzzzzz", "." * k):
            with pytest.raises(QuestionError):
                archive.file(name, "run.nc")
            with pytest.raises(QuestionError):
                archive.delete(name)
    assert [path.name for path in tmp_path.iterdir()] == ["secret"]


def test_the_script_of_a_run_is_python_with_the_same_machine() -> None:
    for text in (DISCOIDAL, DISCOIDAL + "# ends with ''' and a backslash \\"):
        tree = ast.parse(script(text))
        given = next(
            node.value for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "MACHINE"
        )  # type: ignore[attr-defined]
        assert tomllib.loads(ast.literal_eval(given)) == tomllib.loads(DISCOIDAL)


def test_machines_side_by_side_name_the_entries_in_which_they_differ() -> None:
    other = with_value(DISCOIDAL, ORBIT, "50 mm")
    assert differences(DISCOIDAL, other) == [("balancers[1].races[1].orbit_radius", "76.95 mm", "50 mm")]
    lists = with_value(DISCOIDAL, ("rotor", "stiffness"), ["1 N/mm", "2 N/mm"])
    assert [entry[2] for entry in differences(DISCOIDAL, lists)] == ["1 N/mm, 2 N/mm"]


def test_the_view_of_a_notebook_is_the_module_of_the_page_without_imports() -> None:
    text = module_text()
    assert "import {" not in text.replace("return import(url)", "")
    assert text.count("export ") == 1
    for function in ("createView", "createScene", "createWaves", "stateAt"):
        assert f"function {function}(" in text


def test_what_jobs_hold_in_circles_is_freed_also_where_python_does_not_come_around_to_it() -> None:
    class Circle:
        def __init__(self) -> None:
            self.itself = self

    left: list[weakref.ref[Circle]] = []
    jobs = Jobs(workers=1)
    gc.disable()
    try:
        for _ in range(CLEARED):
            job = jobs.start("one", "circle", lambda _job: left.append(weakref.ref(Circle())))
            while not job.over:
                time.sleep(0.001)
        jobs._pool.shutdown(wait=True)
        assert len(left) == CLEARED
        assert not any(one() for one in left)
    finally:
        gc.enable()
        jobs.close()


def test_a_page_says_that_another_one_changed_the_machine_and_brings_its_text_back(tmp_path: Path) -> None:
    one, other = (Typed(tmp_path / "draft.toml", "mass = 10") for _ in range(2))
    told: list[str] = []
    one.on_other_page = lambda: told.append("one")
    other.on_other_page = lambda: told.append("other")
    one.set_text("mass = 11")
    one.set_text("mass = 12")
    assert told == []
    other.set_text("stiffness = 7")
    assert told == ["other"]
    other.undo()
    other.undo()
    assert other.text == "mass = 12"
    one.set_text("mass = 12 # again the same text as on the other page")
    assert told == ["other"]
    other.typing = lambda: None
    other.look()
    assert other.text == "mass = 12", "somebody types"
    seen: list[object] = []
    other.on_change(seen.append)
    other.look()
    other.look()
    assert other.text == one.text
    assert seen == [None]
    other.undo()
    assert other.text == "mass = 12"


def test_a_disk_that_is_full_leaves_the_text_of_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(path: Path, _text: str) -> None:
        raise ResultError(f"{path}: the disk is full")

    page = Typed(tmp_path / "draft.toml", "mass = 10")
    page.set_text("mass = 11")
    monkeypatch.setattr("autobalancer.app.pages.elements.write_text_safely", full)
    page.set_text("mass = 12")
    page.look()
    assert page.text == "mass = 12"


@pytest.mark.parametrize(
    ("number", "kept"),
    [("20,5", "20.5 s"), (" -0,25", "-0.25 s"), (",5", ".5 s"), ("1,500", "1,500 s"), ("1,5,5", "1,5,5 s")],
)
def test_a_decimal_comma_is_taken_unless_it_may_be_of_thousands(number: str, kept: str) -> None:
    assert written(number, "s", "s") == kept


def test_a_machine_is_drawn_as_soon_as_its_lengths_are_known() -> None:
    text = with_value(EMPTY, ORBIT, "60 mm")
    assert drawable(text) is None
    text = with_value(text, ("balancers", 0, "races", 0, "balls", 0, "diameter"), "10 mm")
    assert drawable(text) == drawable(with_value(text, ("unbalances", 0, "mass"), "1 g"))
    assert isinstance(drawable(text), Machine)
    assert drawable(with_value(text, ("rotor", "kind"), "shaft")) is None


def test_an_emptied_number_leaves_no_unit_behind() -> None:
    assert written(" ", "kg", "kg") == ""
    assert number_and_unit("", "kg") is None


LOADS = """
import sys
from pathlib import Path
import autobalancer.app.bench
from autobalancer.app.serve import load_packages
from autobalancer.app.serve import limit_memory
load_packages()
limit_memory()
if sys.platform == "linux":
    import resource
    assert 0 < resource.getrlimit(resource.RLIMIT_DATA)[0] < 2**62
before = set(sys.modules)
import autobalancer as ab
from autobalancer.app.store.pictures import svg_of
from autobalancer.files.examples import example
root = Path(ab.__file__).parent
for path in root.rglob("__init__.py"):
    name = ".".join(("autobalancer", *path.parent.relative_to(root).parts))
    if "import" in path.read_text() and name not in before and not name.startswith("autobalancer.cli"):
        print(name)
machine = example("stall_and_release")
run = ab.simulate(machine, duration=0.1, progress=False)
ab.run_measures(run)
ab.save_run(run, sys.argv[1])
ab.load_run(sys.argv[1])
svg_of(lambda: ab.plot.machine(machine), "drawing")
print(*sorted({name.partition(".")[0] for name in set(sys.modules) - before if name not in ALONE} - {"autobalancer"}))
"""


def test_a_machine_that_comes_back_is_neither_drawn_nor_checked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    from autobalancer.app.pages import describe

    drawn = list[str]()
    monkeypatch.setattr(describe, "svg_of", lambda _draw, about: drawn.append(about) or f"picture {len(drawn)}")
    for machine, picture in (
        (one := ab.example("discoidal").model_copy(update={"name": "comes back"}), "picture 1"),
        (one.model_copy(update={"name": "other"}), "picture 2"),
        (one.model_copy(), "picture 1"),
    ):
        assert describe._answer_or_fault(describe._drawing, machine) == picture


def test_threads_of_the_server_load_no_package_for_the_first_time(tmp_path: Path) -> None:
    """Two that do at the same time can leave one of which half is missing, for good."""
    alone = {"dask.distributed"}  # one line that hands on another package
    words = [sys.executable, "-c", LOADS.replace("ALONE", str(alone)), str(tmp_path / "run.nc")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.split()) == (0, []), done.stderr


def test_a_job_ends_where_memory_ends_and_the_next_one_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    from autobalancer.app.store import jobs as queue

    free = iter([1e6, 1e12, 1e12])
    monkeypatch.setattr(queue, "free_memory", lambda: next(free))
    jobs = Jobs(workers=1)
    greedy, modest = (jobs.start("a", title, lambda job: job.progress(1.0, 2.0)) for title in ("greedy", "modest"))
    jobs.close()
    jobs._pool.shutdown(wait=True)
    assert (greedy.state, greedy.message) == ("failed", queue.TOO_MUCH)
    assert modest.state in ("done", "cancelled")


def test_free_memory_is_at_most_what_the_limit_of_the_process_leaves(monkeypatch: pytest.MonkeyPatch) -> None:
    import resource

    from autobalancer.memory import free_memory

    monkeypatch.setattr(resource, "getrlimit", lambda _kind: (1, 1))
    assert free_memory() == 0.0

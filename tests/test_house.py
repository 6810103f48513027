"""The house: how splintered it is, one tree of errors, documented names. Read from the source alone.

One subject is one file, cut at about 800 lines. The ceilings stand at today's values: none may rise, lower them as you go.
Each list of exceptions is exact: what no longer needs its place there has to leave it, so a list can only shrink.
"""

from __future__ import annotations

import ast
import re
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from autobalancer.public_names import NAMES

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src" / "autobalancer"
FILES = sorted(SOURCE.rglob("*.py"))
LINES, ARGUMENTS, BODY = 800, 12, 80
FAMILIES = {"drag", "forces", "friction", "joints", "shear", "rotors"}
PUBLIC_MODULES = {module for names in NAMES.values() for module in names.values()}  # modules that hold a public name
CEILINGS = {
    "files": 338,  # without laws and rotors, of which there are as many as somebody needs
    "modules with one importer, beside them": 0.04,  # three are loaded by one switch; few folders, so more are beside
    "public functions named once elsewhere": 0.1122,
    "import lines": 0.06,
    "import cycles": 0,
    "bodies over 80 lines": 0,
    "doubled file names": 22,
    "folders": 50,
}
INNER = {
    "kernels/compiler/cache.py Missing": "ends a look for a kernel on disk; it is compiled then",
    "progress.py OutOfTime": "ends a search of a check, which names what it did not find",
    "studies/ensemble/members.py Differs": "ends an attempt to follow; all members are assembled then",
    "stability/bifurcations.py NoConvergence": "ends a step of a continuation, which goes back and tries again",
}
TALKERS = {"__main__.py", "progress.py", "kernels/compiler/cache.py"}  # progress and faults, on standard error


def tree(path: Path) -> ast.Module:
    return _tree(path.relative_to(SOURCE).as_posix())


@cache
def _tree(name: str) -> ast.Module:
    return ast.parse((SOURCE / name).read_text(encoding="utf-8"))


@cache
def nodes(path: Path) -> dict[type[ast.AST], list[ast.AST]]:
    """The nodes of a file by their kind; looked through once for all tests."""
    kinds: dict[type[ast.AST], list[ast.AST]] = {}
    for node in ast.walk(tree(path)):
        if isinstance(
            node, (ast.ImportFrom, ast.Import, ast.Name, ast.Call, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
        ):
            kinds.setdefault(type(node), []).append(node)
    return kinds


def names(paths: list[Path]) -> set[str]:
    return {path.relative_to(SOURCE).as_posix() for path in paths}


def everything(kind: type[ast.AST] | tuple[type[ast.AST], ...]) -> Iterator[tuple[str, ast.AST]]:
    """All nodes of a kind in the source, with the file they are in."""
    for path in FILES:
        for one in kind if isinstance(kind, tuple) else (kind,):
            for node in nodes(path).get(one, ()):
                yield path.relative_to(SOURCE).as_posix(), node


def arguments(function: ast.FunctionDef) -> list[str]:
    given = function.args
    return [a.arg for a in (*given.posonlyargs, *given.args, *given.kwonlyargs) if a.arg not in ("self", "cls")]


def words(node: ast.AST) -> str:
    return ast.get_docstring(node) or ""  # type: ignore[arg-type]


# sizes -------------------------------------------------------------------------------------------------------------------


def module_of(path: Path) -> str:
    return ".".join(("autobalancer", *path.relative_to(SOURCE).with_suffix("").parts)).removesuffix(".__init__")


@cache
def links() -> tuple[dict[str, set[str]], dict[tuple[str, str], set[str]]]:
    """Which modules import a module of the package, and which import a name from it."""
    modules = {module_of(path) for path in FILES}
    importers: dict[str, set[str]] = {}
    users: dict[tuple[str, str], set[str]] = {}
    for path in FILES:
        for node in nodes(path).get(ast.ImportFrom, ()):
            assert isinstance(node, ast.ImportFrom)
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                target = whole if whole in modules else str(node.module)
                if target in modules and target != module_of(path):
                    importers.setdefault(target, set()).add(module_of(path))
                    if target == node.module:
                        users.setdefault((target, alias.name), set()).add(module_of(path))
    return importers, users


def calls(module: str, name: str) -> int:
    path = SOURCE.joinpath(*module.split(".")[1:])
    file = path.with_suffix(".py") if path.with_suffix(".py").exists() else path / "__init__.py"
    return sum(isinstance(node, ast.Name) and node.id == name for node in nodes(file).get(ast.Name, ()))


def share_with_one_importer_beside() -> float:
    importers, _ = links()
    modules = [module_of(path) for path in FILES if path.name != "__init__.py"]
    beside = [
        module
        for module in modules
        if module.removeprefix("autobalancer.") not in PUBLIC_MODULES
        and len(found := importers.get(module, set())) == 1
        and next(iter(found)).rpartition(".")[0] == module.rpartition(".")[0]
    ]
    return len(beside) / len(modules)


def share_named_once_elsewhere() -> float:
    _, users = links()
    public = [
        (module_of(path), node.name)
        for path in FILES
        if path.name != "__init__.py"
        for node in tree(path).body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    ]
    once = [
        (module, name)
        for module, name in public
        if len(elsewhere := users.get((module, name), set())) == 1
        and not calls(module, name)
        and calls(next(iter(elsewhere)), name) == 1
    ]
    return len(once) / len(public)


def cycles() -> int:
    """How many knots of modules import each other, in a circle."""
    importers, _ = links()
    reach: dict[str, set[str]] = {}
    for start in importers:
        seen, ahead = set(), list(importers[start])
        while ahead:
            module = ahead.pop()
            if module not in seen:
                seen.add(module)
                ahead.extend(importers.get(module, ()))
        reach[start] = seen
    knots = {
        frozenset(other for other in seen if start in reach.get(other, ()))
        for start, seen in reach.items()
        if start in seen
    }
    return len(knots)


def length_of_body(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines of a function below its head and docstring."""
    documented = len(node.body) > 1 and ast.get_docstring(node) is not None
    return (node.end_lineno or 0) - node.body[1 if documented else 0].lineno + 1


def measured() -> dict[str, float]:
    functions = (ast.FunctionDef, ast.AsyncFunctionDef)
    lines = sum(len(path.read_text(encoding="utf-8").splitlines()) for path in FILES)
    heads = sum((n.end_lineno or 0) - n.lineno + 1 for _, n in everything((ast.Import, ast.ImportFrom)))  # type: ignore[attr-defined]
    bodies = [length_of_body(node) for _, node in everything(functions) if isinstance(node, functions)]
    stems = [path.stem for path in FILES if path.name != "__init__.py"]
    return {
        "files": sum(path.parent.name not in FAMILIES for path in FILES),
        "modules with one importer, beside them": share_with_one_importer_beside(),
        "public functions named once elsewhere": share_named_once_elsewhere(),
        "import lines": heads / lines,
        "import cycles": cycles(),
        "bodies over 80 lines": sum(body > BODY for body in bodies),
        "doubled file names": sum(count > 1 for count in Counter(stems).values()),
        "folders": len({path.parent for path in FILES}),
    }


def test_the_house_is_no_more_splintered_than_its_ceilings_say() -> None:
    beyond = {name: value for name, value in measured().items() if value > CEILINGS[name]}
    assert not beyond


def test_no_file_of_the_package_is_longer_than_a_subject_needs() -> None:
    assert names([path for path in FILES if len(path.read_text(encoding="utf-8").splitlines()) > LINES]) == set()


def test_no_function_has_more_than_12_arguments_but_commands_whose_options_they_are() -> None:
    found = {
        f"{file} {node.name}"
        for file, node in everything(ast.FunctionDef)
        if isinstance(node, ast.FunctionDef) and len(arguments(node)) > ARGUMENTS and not file.startswith("cli/")
    }
    assert not found


# errors and warnings -----------------------------------------------------------------------------------------------------


def classes_of_errors() -> dict[str, ast.ClassDef]:
    return {node.name: node for node in tree(SOURCE / "errors.py").body if isinstance(node, ast.ClassDef)}


def test_errors_and_warnings_have_one_home_and_what_is_raised_within_is_listed() -> None:
    bases = {"Exception", "BaseException", "Warning", "UserWarning", "ValueError", "LookupError", *classes_of_errors()}
    found = {
        f"{file} {node.name}"
        for file, node in everything(ast.ClassDef)
        if isinstance(node, ast.ClassDef) and any(isinstance(b, ast.Name) and b.id in bases for b in node.bases)
    }
    assert {name for name in found if not name.startswith("errors.py")} == set(INNER)


def test_every_error_and_warning_is_used_and_stands_in_the_reference_with_its_meaning() -> None:
    page = (ROOT / "docs" / "reference" / "index.md").read_text(encoding="utf-8")
    used = {node.id for file, node in everything(ast.Name) if isinstance(node, ast.Name) and file != "errors.py"}
    for name, node in classes_of_errors().items():
        assert name in used or any(
            isinstance(base, ast.Name) and base.id == name for one in classes_of_errors().values() for base in one.bases
        )
        assert f"| `{name}` | {words(node).splitlines()[0]} |" in page


def test_every_warning_has_a_class_of_the_package_by_which_it_can_be_silenced() -> None:
    for file, node in everything(ast.Call):
        if file == "errors.py":  # there stands the function that hands a warning on
            continue
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("warnings.warn", "warn"):
            category = ast.unparse(node.args[1]) if len(node.args) > 1 else ""
            if (file, category) == ("errors.py", "category"):  # of those who call it, which are looked at themselves
                continue
            assert category.endswith("Warning"), file
            assert category in classes_of_errors(), file


def test_only_commands_print() -> None:
    found = {
        file
        for file, node in everything(ast.Call)
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "print" and not file.startswith("cli/")
    }
    assert found == TALKERS


# public names ------------------------------------------------------------------------------------------------------------


def defined(home: str, name: str) -> ast.FunctionDef | ast.ClassDef:
    """The node that defines a public name, followed through the imports of packages."""
    module, _, other = home.partition(":")
    inner, file = other or name, SOURCE / f"{module.replace('.', '/')}.py"
    for node in tree(file if file.exists() else file.with_suffix("") / "__init__.py").body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and node.name == inner:
            return node
        if isinstance(node, ast.ImportFrom) and inner in {a.asname or a.name for a in node.names}:
            (real,) = (a.name for a in node.names if inner == (a.asname or a.name))
            return defined(f"{str(node.module).removeprefix('autobalancer.')}:{real}", real)
    raise AssertionError(f"{home} has no function or class {inner}")


PUBLIC = {
    f"{space}.{name}".lstrip("."): defined(home, name) for space, all_ in NAMES.items() for name, home in all_.items()
}


def test_a_function_is_defined_under_its_public_name() -> None:
    other = {f"{name} is {node.name}" for name, node in PUBLIC.items() if node.name != name.rpartition(".")[2]}
    assert not other, "help, tracebacks and pickles name a function as it is defined"


def test_every_public_name_has_a_docstring_and_a_title_that_ends() -> None:
    for name, node in PUBLIC.items():
        assert len(words(node)) > 20, name
        assert re.search(r"[.:]$|[.;]\s", words(node).split("\n\n")[0]), name


def silent(node: ast.AST) -> list[str]:
    """Arguments of a function that its docstring does not name."""
    given = arguments(node) if isinstance(node, ast.FunctionDef) else []
    return [name for name in given if not re.search(rf"\b{name}\b", words(node))]


def test_public_functions_name_their_arguments_in_their_docstrings() -> None:
    assert {name: given for name, node in PUBLIC.items() if (given := silent(node))} == {}


def test_there_are_at_most_so_many_public_names() -> None:
    assert len(PUBLIC) <= 200


def test_the_reference_lists_the_table_of_public_names() -> None:
    page = ast.parse((ROOT / "docs" / "conf.py").read_text(encoding="utf-8"))
    (lister,) = (n for n in page.body if isinstance(n, ast.FunctionDef) and n.name == "public_names")
    assert any(isinstance(n, ast.For) and ast.unparse(n.iter) == "NAMES.items()" for n in ast.walk(lister))

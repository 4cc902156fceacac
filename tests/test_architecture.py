"""The picture of the rooms in docs/architecture.md against the imports."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
PACKAGES = ("bench", "hydra_plugins", "ksmea", "measurements", "optimizers", "problems", "surrogates")


def rooms():
    """Room by module or package, as the table has it; a row of several rooms has a module for each."""
    found = {}
    for names, modules in re.findall(r"^\| ([a-z_, ]+) \| [^|]+ \| (`[^|]+`) \|$", PAGE, re.MULTILINE):
        names, modules = names.split(", "), re.findall(r"`([\w.]+)`", modules)
        for number, module in enumerate(modules):
            assert module not in found, f"{module} stands in two rooms"
            found[module] = names[number] if len(names) > 1 else names[0]
    return found


def arrows():
    picture = PAGE.split("```mermaid")[1].split("```")[0]
    return set(re.findall(r"^  (\w+) --> (\w+)$", picture, re.MULTILINE))


def room_of(module, known):
    """The room of the longest entry of the table that the module lies in; a package of several rooms is only itself."""
    parts = module.split(".")
    for length in range(len(parts), 0, -1):
        name = ".".join(parts[:length])
        if name in known and (length == len(parts) or not any(other.startswith(f"{name}.") for other in known)):
            return known[name]
    raise AssertionError(f"{module} stands in no room of the table in docs/architecture.md")


def module_files():
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            if path.read_text(encoding="utf-8").startswith('"""Old path of'):  # for one release, beside the picture
                continue
            parts = path.relative_to(ROOT).with_suffix("").parts
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


def imports():
    """(importing module, imported module) within the project, wherever the import stands."""
    files = dict(module_files())
    for module, path in files.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                whole = [f"{node.module}.{alias.name}" for alias in node.names]
                names = [name if name in files else node.module for name in whole]
            yield from ((module, name) for name in names if name in files)


def reach(start, edges):
    found, pending = set(), [start]
    while pending:
        room = pending.pop()
        for one, other in edges:
            if one == room and other not in found:
                found.add(other)
                pending.append(other)
    return found


@pytest.fixture(scope="module")
def between():
    known = rooms()
    pairs = ((module, name, room_of(module, known), room_of(name, known)) for module, name in imports())
    return [(module, name, one, other) for module, name, one, other in pairs if one != other]


def test_nothing_is_imported_against_the_arrows(between):
    edges = arrows()
    reached = {room: reach(room, edges) for room in set(rooms().values())}
    against = [f"{module} imports {name}" for module, name, one, other in between if other not in reached[one]]
    assert not against, "\n".join(against)


def test_every_arrow_stands_for_an_import(between):
    assert arrows() == {(one, other) for _, _, one, other in between} & arrows()


def test_the_picture_has_all_rooms_and_no_circle():
    edges = arrows()
    assert {room for edge in edges for room in edge} == set(rooms().values())
    assert not [room for room in set(rooms().values()) if room in reach(room, edges)]


def test_every_module_has_a_room():
    known = rooms()
    for module, _ in module_files():
        room_of(module, known)


def test_a_picture_that_lacks_an_arrow_is_noticed(between):
    fewer = arrows() - {("inference", "likelihood")}
    assert any(one == "inference" and other not in reach(one, fewer) for _, _, one, other in between)

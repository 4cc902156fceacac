"""Rules of the project's files: sizes of files and folders, names, no import by string, no import circle."""

import ast
import re
import textwrap
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("bench", "hydra_plugins", "ksmea", "measurements", "optimizers", "problems", "surrogates")
FOLDERS = (*PACKAGES, "benchmarks", "tests")
MAX_LINES, LONG = 400, "Longer than 400 lines: "
MIN_LINES, SHORT = 40, "Shorter than 40 lines: "
N_FIRST = 30  # lines in which the reason stands, in a comment or the docstring
MAX_FILES = 20  # of a folder
# One plugin a file: their modules are named in entry points, and outside code may import them.
MANY_FILES = {"problems/effects"}
SHARED_NAMES = {"page", "report", "figure", "__init__", "__main__"}  # of modules in folders that say the rest
MAX_SHARED = 2  # modules of ksmea and the bench with one base name
MADE = {"tests/test_uniform_search.py", "bench/glossary/glossary.md"}  # by a reader of docs/plugins.md, and in a wheel
IMPORTERS = {"import_module", "__import__", "resolve_name"}
BY_STRING = {"ksmea/plugins/registry.py", "ksmea/plugins/files.py"}  # where names become plugins


def python_files(root, folders):
    return sorted(path for folder in folders for path in (root / folder).rglob("*.py"))


def lacks_reason(text, reason):
    return not any(reason in line for line in text.splitlines()[:N_FIRST])


def too_long(text):
    return len(text.splitlines()) > MAX_LINES and lacks_reason(text, LONG)


def too_short(text):
    return len(text.splitlines()) < MIN_LINES and lacks_reason(text, SHORT)


def module_name(path, root):
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def import_graph(root, packages):
    """Module → the project's modules that it imports anywhere: at the top, under TYPE_CHECKING or inside functions."""
    files = {module_name(path, root): path for path in python_files(root, packages)}
    return {name: {target for target in imported(path, name, files) if target != name} for name, path in files.items()}


def imported(path, name, modules):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom):
            package = name if path.name == "__init__.py" else name.rpartition(".")[0]
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            for alias in node.names:
                target = f"{base}.{alias.name}" if f"{base}.{alias.name}" in modules else base
                if target in modules:
                    yield target


def circles(graph):
    """The sets of modules each of which imports, by way of others, every other one (strongly connected components)."""
    reached = {module: reachable(graph, module) for module in graph}
    found = {frozenset({module, *(other for other in reached[module] if module in reached[other])}) for module in graph}
    return sorted(sorted(component) for component in found if len(component) > 1)


def reachable(graph, start):
    found, pending = set(), list(graph[start])
    while pending:
        module = pending.pop()
        if module not in found:
            found.add(module)
            pending.extend(graph[module])
    return found


def imports_by_string(text):
    """Lines on which a module is imported by a name in a string."""
    calls = (node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Call))
    return [call.lineno for call in calls if getattr(call.func, "attr", getattr(call.func, "id", "")) in IMPORTERS]


def test_no_file_is_longer_than_it_may_be_without_a_reason():
    long = [str(path.relative_to(ROOT)) for path in python_files(ROOT, FOLDERS) if too_long(path.read_text("utf-8"))]
    assert not long, f"split by idea, or say why in the first lines ('# {LONG}…'): {', '.join(long)}"


def test_no_file_is_shorter_than_it_may_be_without_a_reason():
    files = [path for path in python_files(ROOT, PACKAGES) if path.name != "__init__.py"]
    short = [str(path.relative_to(ROOT)) for path in files if too_short(path.read_text("utf-8"))]
    assert not short, f"merge with its neighbour, or say why in the first lines ('# {SHORT}…'): {', '.join(short)}"


def test_no_folder_has_more_files_than_a_reader_takes_in():
    counts = defaultdict(int)
    for path in python_files(ROOT, PACKAGES):
        counts[path.parent.relative_to(ROOT).as_posix()] += path.name != "__init__.py"
    crowded = [folder for folder, count in counts.items() if count > MAX_FILES and folder not in MANY_FILES]
    assert not crowded, f"sort by idea: {', '.join(crowded)}"


def test_base_names_are_shared_by_two_modules_at_most():
    by_name = defaultdict(list)
    for path in python_files(ROOT, ("bench", "ksmea")):
        by_name[path.stem].append(path.relative_to(ROOT).as_posix())
    shared = [files for name, files in by_name.items() if len(files) > MAX_SHARED and name not in SHARED_NAMES]
    assert not shared, "\n".join(map(", ".join, shared))


def test_nothing_is_imported_by_a_string_but_plugins():
    files = {path.relative_to(ROOT).as_posix(): path for path in python_files(ROOT, PACKAGES)}
    found = [
        name for name, path in files.items() if imports_by_string(path.read_text("utf-8")) and name not in BY_STRING
    ]
    assert not found, f"import by a statement, which tests and readers see: {', '.join(found)}"
    assert imports_by_string("f = importlib.import_module('a.b')\ng = __import__('c')") == [1, 2]


def test_source_files_that_texts_name_are_there():
    """In pages, docstrings and comments, so that whoever follows them after a move finds what they mean."""
    own = "|".join((*FOLDERS, "docs"))
    named = re.compile(rf"(?<![\w./-])(?:{own})/[\w/]*\w\.(?:py|md)\b")
    texts = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *python_files(ROOT, FOLDERS)]
    lost = {
        f"{path.relative_to(ROOT)}: {name}"
        for path in texts
        for name in named.findall(path.read_text(encoding="utf-8"))
        if not (ROOT / name).exists() and name not in MADE
    }
    assert not lost, "\n".join(sorted(lost))


def test_packages_of_ksmea_import_nothing_when_they_are_imported():
    """Imports of a module are in the keys of runs that use it.

    An `__init__` would bring along all of its package.
    """
    packages = [
        path for path in python_files(ROOT, ("ksmea",)) if path.name == "__init__.py" and path.parent != ROOT / "ksmea"
    ]
    loading = [path.parent.name for path in packages if imports_of_ours(path.read_text("utf-8"))]
    assert loading == ["testing"]  # the face of the contract tests, which no run uses


def imports_of_ours(text):
    """Statements at the top of a module that import from this project."""
    imports = [node for node in ast.parse(text).body if isinstance(node, ast.Import | ast.ImportFrom)]
    names = [node.module or "" if isinstance(node, ast.ImportFrom) else node.names[0].name for node in imports]
    return [name for name in names if name.partition(".")[0] in PACKAGES]


def test_no_module_imports_itself_by_way_of_others():
    found = circles(import_graph(ROOT, PACKAGES))
    assert not found, "import circles: " + "; ".join(" – ".join(component) for component in found)


def test_a_reason_is_a_comment_or_in_the_docstring():
    assert too_short("x = 1") and not too_short(f"# {SHORT}one number.\nx = 1")
    lines = ["x = 1"] * (MAX_LINES + 1)
    assert too_long("\n".join(lines)) and not too_long("\n".join(lines[1:]))
    assert not too_long("\n".join([f"# {LONG}one table.", *lines]))
    assert not too_long("\n".join(['"""A table.', "", f"{LONG}one table.", '"""', *lines]))
    assert too_long("\n".join([*lines, f"# {LONG}one table."]))


def test_circles_are_found_wherever_the_import_stands(tmp_path):
    files = {
        "__init__.py": "",
        "one.py": "from parts.two import f",
        "two.py": "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from parts import three",
        "three.py": "def g():\n    import parts.one",
        "near/__init__.py": "from .left import a",
        "near/left.py": "def h():\n    from . import right",
        "near/right.py": "from .left import a\nfrom ..one import b",
        "apart.py": "import numpy\nfrom parts import one\nfrom parts import absent",
    }
    for name, text in files.items():
        (tmp_path / "parts" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "parts" / name).write_text(textwrap.dedent(text))
    graph = import_graph(tmp_path, ["parts"])
    assert graph["parts.apart"] == {"parts.one", "parts"} and graph["parts.near.right"] == {
        "parts.near.left",
        "parts.one",
    }
    assert circles(graph) == [["parts.near.left", "parts.near.right"], ["parts.one", "parts.three", "parts.two"]]

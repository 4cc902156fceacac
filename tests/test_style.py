"""How the project's files are kept: none too long without a reason, and no module that imports itself by way of others."""

import ast
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGES = ("bench", "hydra_plugins", "ksmea", "measurements", "optimizers", "problems", "surrogates")
FOLDERS = (*PACKAGES, "benchmarks", "tests")
MAX_LINES = 400
REASON = "# Longer than 400 lines: "
N_FIRST = 30  # lines in which the reason stands, in a comment or the docstring


def python_files(root, folders):
    return sorted(path for folder in folders for path in (root / folder).rglob("*.py"))


def too_long(text):
    lines = text.splitlines()
    return len(lines) > MAX_LINES and not any(REASON.lstrip("# ") in line for line in lines[:N_FIRST])


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


def test_no_file_is_longer_than_it_may_be_without_a_reason():
    long = [str(path.relative_to(ROOT)) for path in python_files(ROOT, FOLDERS) if too_long(path.read_text("utf-8"))]
    assert not long, f"split by idea, or say why in the first lines ('{REASON}…'): {', '.join(long)}"


def test_no_module_imports_itself_by_way_of_others():
    found = circles(import_graph(ROOT, PACKAGES))
    assert not found, "import circles: " + "; ".join(" – ".join(component) for component in found)


def test_a_reason_is_a_comment_or_in_the_docstring():
    lines = ["x = 1"] * (MAX_LINES + 1)
    assert too_long("\n".join(lines)) and not too_long("\n".join(lines[1:]))
    assert not too_long("\n".join([f"{REASON}one table.", *lines]))
    assert not too_long("\n".join(['"""A table.', "", f"{REASON.lstrip('# ')}one table.", '"""', *lines]))
    assert too_long("\n".join([*lines, f"{REASON}one table."]))


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

"""Python files: hash of the syntax tree without docstrings, and imports.

Both follow from a file's content alone, and parsing 160 modules takes 0.4 s. So they are kept by content (`bench.storage.content_cache`).
"""

from __future__ import annotations

import ast
import hashlib
import io
import platform
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from bench.storage.content_cache import KeptByContent

DIGITS = 12  # of the hash of a syntax tree
BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")  # where statements stand in others
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Source:
    """Digest of a module's syntax tree, and its imports.

    `imports` are as written, a relative one with its dots: packages, modules, and names that might be one.
    """

    digest: str
    imports: tuple[str, ...]


def kept_sources() -> KeptByContent[Source]:
    """Sources that earlier processes have read with this code and this version of Python.

    Syntax trees differ between versions of Python.
    """
    own_code = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:DIGITS]
    return KeptByContent(
        f"code-{sys.implementation.name}-{platform.python_version()}-{own_code}.json", Source, read_source
    )


def read_source(content: bytes) -> Source:
    """Source with this content; `SyntaxError` or `ValueError` if it is not Python."""
    tree = ast.parse(io.StringIO(content.decode("utf-8"), newline=None).read())
    imports: dict[str, None] = {}
    for statement in _statements(tree):
        if isinstance(statement, DOCUMENTED) and ast.get_docstring(statement):
            statement.body[0] = ast.Pass()
        imports |= dict.fromkeys(_imported(statement))
    return Source(hashlib.sha256(ast.dump(tree).encode()).hexdigest()[:DIGITS], tuple(imports))


def absolute(name: str, module: str, is_package: bool) -> str:
    """The full name of what a module imports by this name.

    >>> [absolute(name, "problems.rotor.finite_elements.assembly", False) for name in ("numpy", ".shaft", "...effects.runout")]
    ['numpy', 'problems.rotor.finite_elements.shaft', 'problems.effects.runout']
    """
    own = name.lstrip(".")
    level = len(name) - len(own)
    if not level:
        return name
    parts = module.split(".")
    return ".".join([*parts[: len(parts) - level + is_package], *([own] if own else [])])


def _statements(tree: ast.Module) -> Iterator[ast.AST]:
    """All statements, and what else holds some.

    They hold whatever imports or has a docstring, expressions do not.
    """
    pending: list[ast.AST] = [tree]
    while pending:
        node = pending.pop()
        yield node
        for block in BLOCKS:
            inner = getattr(node, block, None)
            if isinstance(inner, list):  # the body of a lambda is none
                pending += inner


def _imported(statement: ast.AST) -> Iterator[str]:
    if isinstance(statement, ast.Import):
        yield from (alias.name for alias in statement.names)
    elif isinstance(statement, ast.ImportFrom):
        base = "." * statement.level + (statement.module or "")
        yield base
        yield from (f"{base}{'.' if statement.module else ''}{alias.name}" for alias in statement.names)

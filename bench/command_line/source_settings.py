"""Plugin settings, read from the source without importing it: for completion and early errors.

The fields of a dataclass are read from the syntax trees of its module and of its bases' modules. What a tree cannot
show (a computed list of choices) is left out: it is checked when the plugin itself is loaded.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ksmea.plugins.module_files import source_file
from ksmea.plugins.names import registered

Names = tuple[str, ...]


@dataclass(frozen=True)
class SourceSetting:
    """A setting's name, type as it is written ('int | None'), and choices where the source tells them."""

    name: str
    type: str
    choices: Names = ()


@cache
def source_settings(group: str, name: str) -> Mapping[str, SourceSetting] | None:
    """The settings of a plugin by name, in their order; None if its source does not tell them all."""
    point = registered(group).get(name)
    if point is None or not point.attr:
        return None
    try:
        return _fields_of(point.module, point.attr)
    except (LookupError, OSError, SyntaxError, ValueError, RecursionError):
        return None


@cache
def _fields_of(module: str, class_name: str) -> Mapping[str, SourceSetting]:
    """Fields of a dataclass, after the fields of its bases; `LookupError` if a base cannot be found."""
    found: dict[str, SourceSetting] = {}
    definition = _definition(module, class_name)
    if definition is None:
        raise LookupError(class_name)
    home, node = definition
    for base in reversed(node.bases):
        name = base.value if isinstance(base, ast.Subscript) else base
        if isinstance(name, ast.Name) and name.id not in ("ABC", "Generic", "Protocol", "NamedTuple"):
            found |= _fields_of(home, name.id)
        elif not isinstance(name, ast.Name):
            raise LookupError(ast.unparse(base))
    if any("dataclass" in ast.unparse(each) for each in node.decorator_list):
        for statement in node.body:
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                found |= _field(home, statement, statement.target.id)
    return found


def _field(module: str, statement: ast.AnnAssign, name: str) -> dict[str, SourceSetting]:
    """A field by its name; none of a class variable, or of what holds a part of a method."""
    hint = ast.unparse(statement.annotation)
    call = statement.value if isinstance(statement.value, ast.Call) else None
    if hint.startswith("ClassVar") or (call is not None and ast.unparse(call.func) == "part"):
        return {}
    given = next((each.value for each in call.keywords if each.arg == "choices"), None) if call else None
    try:
        choices = () if given is None else tuple(_texts(module, given))
    except LookupError:
        choices = ()
    return {name: SourceSetting(name, hint, choices)}


def _texts(module: str, node: ast.expr) -> Iterator[str]:
    """The texts that an expression holds: of tuples, of names that stand for them, keys of mappings.

    `LookupError` where they have to be computed.
    """
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        yield node.value
    elif isinstance(node, (ast.Tuple, ast.List)):
        for each in node.elts:
            yield from _texts(module, each)
    elif isinstance(node, ast.Dict):
        for key in node.keys:
            if key is None:
                raise LookupError(ast.unparse(node))
            yield from _texts(module, key)
    elif isinstance(node, ast.Starred):
        yield from _texts(module, node.value)
    elif isinstance(node, ast.Call) and ast.unparse(node.func) in ("tuple", "MappingProxyType") and node.args:
        yield from _texts(module, node.args[0])
    elif isinstance(node, ast.Name) and (found := _value(module, node.id)) is not None:
        yield from _texts(*found)
    else:
        raise LookupError(ast.unparse(node))


def _value(module: str, name: str) -> tuple[str, ast.expr] | None:
    """The module that gives a name its value, and the value."""
    for statement in _tree(module).body:
        if isinstance(statement, ast.Assign) and any(ast.unparse(target) == name for target in statement.targets):
            return module, statement.value
        if isinstance(statement, ast.AnnAssign) and ast.unparse(statement.target) == name and statement.value:
            return module, statement.value
    imported = _imported(module, name)
    return None if imported is None else _value(*imported)


def _definition(module: str, class_name: str) -> tuple[str, ast.ClassDef] | None:
    """The module that defines a class, and its definition."""
    for statement in _tree(module).body:
        if isinstance(statement, ast.ClassDef) and statement.name == class_name:
            return module, statement
    imported = _imported(module, class_name)
    return None if imported is None else _definition(*imported)


def _imported(module: str, name: str) -> tuple[str, str] | None:
    """Module that a name is imported from, and its name there; None if no absolute `from` import has it."""
    for statement in _tree(module).body:
        if isinstance(statement, ast.ImportFrom) and statement.module and not statement.level:
            for alias in statement.names:
                if (alias.asname or alias.name) == name:
                    return statement.module, alias.name
    return None


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(_source(module).read_text(encoding="utf-8"))


def _source(module: str) -> Path:
    """The file of a module, found without importing the packages that it lies in."""
    found = source_file(module)
    if found is None:
        raise LookupError(module)
    return found

"""The types that settings may have.

The module checks whether a value is of a type, converts a file's text, and names types in words.
"""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping
from typing import Any

from ksmea.errors import SettingError, described

TRUTHS = {"true": True, "false": False}  # strict YAML has them as texts
IN_WORDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "a text",
    type(None): "null",
    Any: "anything",
}
NUMBERS = {bool: (bool,), int: (int,), float: (int, float)}  # what counts as each; true is no number


def is_of(value: Any, hint: Any) -> bool:
    """Whether a value is of the type that a hint names.

    A hint of another kind than settings have takes anything.

    >>> is_of(3, float), is_of(True, int), is_of([1.0, "a"], list[float]), is_of(None, int | None)
    (True, False, False, True)
    """
    origin, options = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any:
        return True
    if origin in (typing.Union, types.UnionType):
        return any(is_of(value, option) for option in options)
    if origin is typing.Literal:
        return value in options
    if origin is tuple:
        if not isinstance(value, (list, tuple)):
            return False
        entries = options[:1] * len(value) if options[1:] == (...,) else options
        return len(value) == len(entries) and all(map(is_of, value, entries))
    if origin is list:
        return isinstance(value, (list, tuple)) and all(is_of(entry, options[0]) for entry in value)
    if origin is dict:
        return isinstance(value, Mapping) and all(
            is_of(key, options[0]) and is_of(entry, options[1]) for key, entry in value.items()
        )
    if hint in NUMBERS:
        if getattr(value, "shape", None) == () and hasattr(value, "item"):  # numpy's, which is as good as Python's
            value = value.item()
        return isinstance(value, NUMBERS[hint]) and (hint is bool or not isinstance(value, bool))
    return not isinstance(hint, type) or isinstance(value, hint)


def read_as(value: Any, hint: Any) -> Any:
    """Convert a value of a file to the type of a setting; `SettingError` if it does not have this type.

    Strict YAML has true and false as texts, and whole numbers also count as numbers.
    """
    origin, options = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        for option in options:
            try:
                return read_as(value, option)
            except SettingError:
                pass
    elif origin is list and isinstance(value, list):
        return [read_as(entry, options[0]) for entry in value]
    elif origin is dict and isinstance(value, dict):
        return {str(key): read_as(entry, options[1]) for key, entry in value.items()}
    elif hint is bool and isinstance(value, str) and value in TRUTHS:
        return TRUTHS[value]
    elif hint is not bool and is_of(value, hint):
        return float(value) if hint is float else value
    raise SettingError(f"expected {in_words(hint)}, got {described(value)}")


def in_words(hint: Any) -> str:
    """A type as messages name it.

    >>> in_words(list[float] | None)
    'a list, each entry a number or null'
    """
    origin, options = typing.get_origin(hint), typing.get_args(hint)
    if origin in (typing.Union, types.UnionType):
        return " or ".join(map(in_words, options))
    if origin in (list, tuple):
        return f"a list, each entry {in_words(options[0])}"
    if origin is dict:
        return f"a mapping, each value {in_words(options[1])}"
    if hint in IN_WORDS:
        return IN_WORDS[hint]
    if not isinstance(hint, type):
        return str(hint)
    return f"{'an' if hint.__name__[0] in 'AEIOU' else 'a'} {hint.__name__}"

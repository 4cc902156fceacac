"""Overrides of the command line: the values that each setting takes.

Names of files and folders may hold signs that Hydra's grammar reserves (µ, commas, '=', brackets). A value that names an existing
file as it stands is that file; so is a value that the grammar cannot read.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from pathlib import Path
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import (
    FloatRange,
    Glob,
    Override,
    OverrideType,
    Quote,
    QuotedString,
    RangeSweep,
    Sweep,
)
from hydra.errors import HydraException

from bench.command_line.plugin_settings import names_plugin, short
from bench.command_line.word_shapes import NAMED
from ksmea.errors import SettingError
from ksmea.plugins import registry

ALONE, END = "tag(alone,choice([", "]))"  # around the one value of a word that Hydra is to leave to the sweeper
TAG = "alone"
MOST_VALUES = 1_000_000  # of a range
PLAIN = re.compile(r"[\w./-]+")  # a path that needs no quotes in Hydra's grammar


@dataclass(frozen=True)
class Choice:
    """Choice of one setting or group on the command line: one value, or several values of a sweep."""

    key: str
    values: tuple[Any, ...]
    override: Override

    @property
    def word(self) -> str:
        """It as one word that a configuration knows; of one value."""
        if self.override.is_sweep_override() or names_plugin(self.key):
            prefix = {OverrideType.ADD: "+", OverrideType.FORCE_ADD: "++"}.get(self.override.type, "")
            return prefix + override(short(self.key), self.values[0])
        return str(self.override.input_line)


def parse(arguments: list[str]) -> tuple[Choice, ...]:
    """The overrides of a command line, in its order; the last one for a key wins."""
    choices: dict[str, Choice] = {}
    for override in OverridesParser.create().parse_overrides(arguments):
        key = override.get_key_element().lstrip("+~")
        if override.is_sweep_override() and not override.is_discrete_sweep():
            raise SettingError(
                f"expected a value, a list a,b,c or range(from,to,step), got {_given(override)}, which has no steps",
                setting=key,
            )
        choices[key] = Choice(key, _values(key, override), override)
    return tuple(choices.values())


def for_some_plugins(words: list[str], groups: Iterable[str]) -> list[str]:
    """Rewrite settings of a named plugin, or of a group with several plugins, as sweeps of one value.

    Hydra leaves sweeps to the sweeper. It would reject a plain value if the first plugin has no such setting.

    >>> for_some_plugins(["optimizer=pso,lm", "optimizer.screening=500"], ["optimizer"])
    ['optimizer=pso,lm', 'optimizer.screening=tag(alone,choice([500]))']
    """
    number = {choice.key: len(choice.values) for choice in parse(words)}
    is_varied = not number.keys().isdisjoint(("experiment", "grid", "add", "cross"))
    varied = {group for group in groups if number.get(group, 2 if is_varied else 1) > 1}
    return [
        _left_to_the_sweeper(word) if word.partition(".")[0] in varied or names_plugin(word.partition("=")[0]) else word
        for word in words
    ]


def _left_to_the_sweeper(word: str) -> str:
    key, _, value = word.partition("=")
    (choice,) = parse([word])
    return word if choice.override.is_sweep_override() or not value else f"{key}={ALONE}{value}{END}"


def as_given(word: str) -> str:
    """A word as it was typed, before `for_some_plugins`."""
    key, _, value = word.partition("=")
    if key == "units":
        return f"{key}={value.strip(QUOTES)}"  # `_quoted` put them
    return f"{key}={value[len(ALONE) : -len(END)]}" if value.startswith(ALONE) else word


def _values(key: str, override: Override) -> tuple[Any, ...]:
    if override.type == OverrideType.DEL:
        return ()
    value = override.value()
    if isinstance(value, Glob):
        return _plugins(key, value, override)
    if not isinstance(value, Sweep):
        return (_plain(value),)
    if getattr(value, "shuffle", False):
        raise SettingError(
            f"expected values in an order that stays, got {_given(override)}; no result depends on the order of runs:"
            " leave shuffle out",
            setting=key,
        )
    if isinstance(value, RangeSweep):
        return _steps(key, value, override)
    values = tuple(_plain(each) for each in override.sweep_iterator())
    return tuple(values[0]) if TAG in value.tags else values


def _plugins(key: str, pattern: Glob, override: Override) -> tuple[str, ...]:
    """The plugins whose names fit a pattern."""
    if key not in registry.GROUPS:
        raise SettingError(
            f"expected values, got {_given(override)}; glob chooses plugins, of {', '.join(registry.GROUPS)}",
            setting=key,
        )
    return tuple(pattern.filter(list(registry.registered(key))))


def _steps(key: str, steps: RangeSweep, override: Override) -> tuple[Any, ...]:
    """The numbers of a range, which ends before its second bound.

    Decimal fractions as they are written: 0.15, not 0.15000000000000002.
    """
    if steps.step == 0:
        raise SettingError(f"expected a step other than 0, got {_given(override)}", setting=key)
    numbers = steps.range()
    bounds = [Decimal(str(each)) for each in (steps.start, steps.stop, steps.step)]
    if not all(each.is_finite() for each in bounds):
        raise SettingError(f"expected finite numbers from, to and step, got {_given(override)}", setting=key)
    start, stop, step = bounds
    n = len(numbers) if isinstance(numbers, range) else int((stop - start) / step)
    if n > MOST_VALUES:
        raise SettingError(
            f"expected at most {MOST_VALUES} values, got {_given(override)} with {n}; give a larger step",
            setting=key,
        )
    return tuple(numbers if isinstance(numbers, range) else FloatRange(*bounds))


def _given(override: Override) -> str:
    """The value as it was typed."""
    return as_given(str(override.input_line)).partition("=")[2]


def _plain(value: Any) -> Any:
    """A value of Hydra's grammar without its marks of quotation."""
    if isinstance(value, list):
        return [_plain(entry) for entry in value]
    if isinstance(value, dict):
        return {_plain(name): _plain(entry) for name, entry in value.items()}
    return value.text if isinstance(value, QuotedString) else value


def override(key: str, value: Any) -> str:
    """A setting and its value in Hydra's grammar."""
    return f"{key}={_in_grammar(value)}"


def path_word(key: str, path: str) -> str:
    """A setting whose value is a path, without quotes where it needs none.

    >>> path_word("output", "results/mine"), path_word("output", "my results")
    ('output=results/mine', "output='my results'")
    """
    return f"{key}={path}" if PLAIN.fullmatch(path) else override(key, path)


def _in_grammar(value: Any) -> str:
    if isinstance(value, str):
        return QuotedString(value, Quote.single).with_quotes()
    if isinstance(value, list):
        return f"[{','.join(_in_grammar(entry) for entry in value)}]"
    if isinstance(value, dict):
        return f"{{{','.join(f'{name}:{_in_grammar(entry)}' for name, entry in value.items())}}}"
    return {None: "null", True: "true", False: "false"}.get(value, str(value)) if _is_word(value) else str(value)


def _is_word(value: Any) -> bool:
    return value is None or isinstance(value, bool)


LISTS = ("plugins", "share", "hydra.searchpath")  # and lists of such names
QUOTES = "'\""
BEGINS_OTHERWISE = ("'", '"', "[", "{", "$", "glob(", "choice(")


def with_quoted_files(words: Sequence[str]) -> list[str]:
    """The words, names of files that Hydra would not take as they stand in its quotation marks.

    >>> with_quoted_files(["output=µ=2, a", "samples=40,70"])
    ["output='µ=2, a'", 'samples=40,70']
    """
    return [_quoted(word) for word in words]


def _quoted(word: str) -> str:
    key, _, value = word.partition("=")
    bare = key.lstrip("+")
    if bare == "units" and value and not value.startswith(BEGINS_OTHERWISE):
        return override(key, value)  # its commas are no sweep
    if bare in NAMED and value and (_is_there(value) or (not value.startswith(BEGINS_OTHERWISE) and not _reads(word))):
        return override(key, value)
    inner = value[1:-1]
    is_list = value.startswith("[") and value.endswith("]") and not inner.startswith(("'", '"'))
    if bare in LISTS and is_list and inner and (_is_there(inner) or not _reads(word)):
        return override(key, [inner])
    return word


def _is_there(name: str) -> bool:
    """Whether a file has a name that Hydra would not take as it stands."""
    try:
        return any(sign in name for sign in ",=()[]{}'\"$ \\") and Path(name).expanduser().exists()
    except (OSError, ValueError):
        return False


def _reads(word: str) -> bool:
    try:
        OverridesParser.create().parse_override(word)
    except HydraException:
        return False
    return True

"""The command line's overrides: which values each setting takes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Override, OverrideType, Quote, QuotedString

from ksmea.errors import SettingError

ALONE = "choice("  # begins the sweep of one value


@dataclass(frozen=True)
class Choice:
    """What the command line says of one setting or group: one value, or the several values of a sweep."""

    key: str
    values: tuple[Any, ...]
    override: Override

    @property
    def word(self) -> str:
        """It as one word of the command line, by itself."""
        return as_given(str(self.override.input_line))


def parse(arguments: list[str]) -> tuple[Choice, ...]:
    """The overrides of a command line, in its order; the last one for a key wins."""
    choices: dict[str, Choice] = {}
    for override in OverridesParser.create().parse_overrides(arguments):
        key = override.get_key_element().lstrip("+~")
        if override.is_sweep_override() and not override.is_discrete_sweep():
            raise SettingError(
                f"{key}: expected a value or a list a,b,c, got {str(override.input_line).partition('=')[2]}"
            )
        choices[key] = Choice(key, _values(override), override)
    return tuple(choices.values())


def for_some_plugins(words: list[str], groups: Iterable[str]) -> list[str]:
    """The words with settings of a group of plugins of which several may be chosen as sweeps of one value, which Hydra
    leaves to the sweeper: it would refuse those that the first plugin has not.

    >>> for_some_plugins(["optimizer=pso,lm", "optimizer.screening=500"], ["optimizer"])
    ['optimizer=pso,lm', 'optimizer.screening=choice(500)']
    """
    number = {choice.key: len(choice.values) for choice in parse(words)}
    is_varied = not number.keys().isdisjoint(("experiment", "grid", "add", "cross"))
    varied = {group for group in groups if number.get(group, 2 if is_varied else 1) > 1}
    return [_left_to_the_sweeper(word) if word.partition(".")[0] in varied else word for word in words]


def _left_to_the_sweeper(word: str) -> str:
    key, _, value = word.partition("=")
    (choice,) = parse([word])
    stays = choice.override.is_sweep_override() or choice.values in ((), (None,))  # Hydra has no sweep of null
    return word if stays or not value else f"{key}={ALONE}{value})"


def as_given(word: str) -> str:
    """A word as it was typed, before `for_some_plugins`."""
    key, _, value = word.partition("=")
    return f"{key}={value[len(ALONE) : -1]}" if value.startswith(ALONE) and value.endswith(")") else word


def _values(override: Override) -> tuple[Any, ...]:
    if override.type == OverrideType.DEL:
        return ()
    if override.is_sweep_override():
        return tuple(_plain(value) for value in override.sweep_iterator())
    return (_plain(override.value()),)


def _plain(value: Any) -> Any:
    return value.text if isinstance(value, QuotedString) else value


def override(key: str, value: Any) -> str:
    """A setting and its value in Hydra's grammar."""
    return f"{key}={_in_grammar(value)}"


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

"""Errors that speak to the user, and the one that ends a spent budget."""

from __future__ import annotations

import copy
import difflib
import unicodedata
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

LONGEST_QUOTE = 40  # characters of a wrong value that an error repeats
LONGEST_NAME = 200  # of a name that nobody knows, which may be a path
MOST_NAMES = 60  # known ones that an error lists; a file may define any number
UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")  # Unicode's categories of what moves a cursor, turns text round or ends a line


@dataclass(frozen=True)
class UnknownName:
    """A name that nothing has, as an error holds it: `near` is the known name that comes nearest, `owner` the one plugin
    that has a setting of this name, as `optimizer=pso`."""

    noun: str
    name: str
    near: str | None = None
    owner: str = ""

    @property
    def setting(self) -> str:
        """The setting that the name stands for, or is the value of; '' if it is neither."""
        return self.name if self.noun == "setting" else self.noun if self.noun.isidentifier() else ""


class SettingError(ValueError):
    """A setting, name or file that cannot be used: one line saying what was expected, what came and what to try.

    Whatever it quotes, the message is one line of visible characters. `reason` is the message without locations before it.

    Args:
        setting: key of the setting that is wrong, which stands before the message.
        meant: what was probably meant: a name, all arguments of a command, or the setting's value as a function of the one given.
    """

    def __init__(
        self,
        message: object = "",
        *,
        setting: str = "",
        meant: UnknownName | list[str] | Callable[[str], str] | None = None,
    ) -> None:
        super().__init__(visible(f"{setting}: {message}" if setting else str(message)))
        self.reason = str(self)
        self.setting = meant.setting if isinstance(meant, UnknownName) else setting
        self.meant = meant

    def within(self, where: object, setting: str = "") -> SettingError:
        """This error with a location before its message, and the setting's whole key."""
        located = copy.copy(self)
        located.args = (visible(f"{where}: {self}"),)
        located.setting = setting or self.setting
        return located


class PluginFailure(SettingError):
    """A plugin from outside cannot be used, whatever its settings: it costs its own runs alone."""


class BudgetSpent(Exception):
    """Raised by an objective whose evaluations are used up.

    It derives from `Exception` alone: the optimisation libraries swallow some of the more special classes.
    """


def unknown(noun: str, name: str, known: Iterable[str], within: str = "") -> SettingError:
    """The error for a name that nobody knows, with the nearest known one and then all of them; `within` stands before the
    name, and not before the known ones.

    >>> str(unknown("optimizer", "dee", ["de", "pso"]))
    "unknown optimizer 'dee'; did you mean 'de'? known: de, pso"
    """
    names = sorted(known)
    name = shortened(name, LONGEST_NAME)
    close = nearest(name, names)
    near = f"{within}{shortened(close)}" if close is not None else None
    found = UnknownName(noun, f"{within}{name}", near)
    hint = f"did you mean '{near}'? " if near is not None else ""
    return SettingError(f"unknown {noun} '{found.name}'; {hint}known: {listed(names)}", meant=found)


def listed(names: list[str]) -> str:
    """Known names as an error lists them."""
    shown = [shortened(each, LONGEST_NAME) for each in names[:MOST_NAMES]]
    more = [f"{len(names) - len(shown)} more"] if len(names) > len(shown) else []
    return ", ".join([*shown, *more]) or "none"


def nearest(name: str, known: Iterable[str], cutoff: float = 0.4) -> str | None:
    """The known name that a wrong one comes nearest to, in upper or lower case; None where none is alike by the ratio `cutoff`.

    >>> nearest("lm", ["DE", "LM"]), nearest("Kriging+de", ["DE", "Kriging + DE"]), nearest("x", ["DE"])
    ('LM', 'Kriging + DE', None)
    """
    folded: dict[str, str] = {}
    for each in sorted(known):
        folded.setdefault(each.casefold(), each)
    close = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=cutoff)
    return folded[close[0]] if close else None


def described(value: Any) -> str:
    """A wrong value as an error shows it: short and on one line.

    >>> described([]), described("many"), described(None)
    ('an empty list', "'many'", 'nothing')
    """
    if value is None:
        return "nothing"
    if isinstance(value, (dict, list)):
        collection = "mapping" if isinstance(value, dict) else "list"
        return f"a {collection}" if value else f"an empty {collection}"
    return shortened(repr(value))


def shortened(text: str, longest: int = LONGEST_QUOTE) -> str:
    """A text on one line of visible characters, cut to what an error quotes."""
    line = visible(" ".join(text[: 20 * longest].split()))
    return line if len(line) <= longest else line[:longest] + "…"


def visible(text: str, kept: str = "") -> str:
    r"""A text of a file, a record or a plan as a terminal may show it: what controls the terminal or cannot be seen stands as
    its escape, but for `kept`.

    >>> visible("red: \x1b[31m, next\nline")
    'red: \\x1b[31m, next\\nline'
    """
    if text.isascii() and text.isprintable():
        return text
    return "".join(
        sign.encode("unicode_escape").decode() if unicodedata.category(sign) in UNSEEN and sign not in kept else sign
        for sign in text
    )


def visible_lines(text: str) -> str:
    """The same of several lines, which stay lines."""
    return visible(text, kept="\n")


def warn_moved(old: str, new: str) -> None:
    """Warn an importer of an old module path, which works for one more release, of the new one."""
    warnings.warn(f"{old} has moved to {new}; import it from there", DeprecationWarning, stacklevel=3)


def warn_renamed(old: str, new: str) -> None:
    """Warn the author of a plugin's class of the new name of a member that it overrides; the old one works for one more release."""
    warnings.warn(f"{old} has been renamed {new}; override that", DeprecationWarning, stacklevel=4)  # below ABCMeta

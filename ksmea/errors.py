"""Errors that speak to the user, and the one that ends a spent budget."""

from __future__ import annotations

import copy
import difflib
import re
import unicodedata
import warnings
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

LONGEST_QUOTE = 40  # characters of a wrong value that an error repeats
LONGEST_NAME = 200  # of a name that nobody knows, which may be a path
MOST_NAMES = 60  # known ones that an error lists; a file may define any number
WORD = re.compile(r"[a-zµ]+|0pk")
_ONE_WAY = {  # words of names that are alike and mean something else, and how one becomes the other
    ("lag", "lead"): ("lead = -lag", "lag = -lead"),
    ("mil", "um"): ("1 mil = 25.4 um", "1 um = 0.03937 mil"),
    ("mils", "um"): ("1 mil = 25.4 um", "1 um = 0.03937 mil"),
    ("mm", "um"): ("1 mm = 1000 um", "1 um = 0.001 mm"),
    ("m", "um"): ("1 m = 1e6 um", "1 um = 1e-6 m"),
    ("in", "m"): ("1 in = 0.0254 m", "1 m = 39.37 in"),
    ("in", "mm"): ("1 in = 25.4 mm", "1 mm = 0.03937 in"),
    ("mm", "m"): ("1 mm = 0.001 m", "1 m = 1000 mm"),
    ("ft", "m"): ("1 ft = 0.3048 m", "1 m = 3.2808 ft"),
    ("pp", "0pk"): ("0pk = pp / 2", "pp = 2 0pk"),
    ("pkpk", "0pk"): ("0pk = pkpk / 2", "pkpk = 2 0pk"),
    ("rms", "0pk"): ("0pk = 1.41421 rms", "rms = 0.70711 0pk"),
    ("psi", "pa"): ("1 psi = 6894.757 Pa", "1 Pa = 1.450377e-4 psi"),
    ("ksi", "gpa"): ("1 ksi = 0.006894757 GPa", "1 GPa = 145.0377 ksi"),
    ("psi", "gpa"): ("1 psi = 6.894757e-6 GPa", "1 GPa = 145037.7 psi"),
    ("lb", "kg"): ("1 lb = 0.45359237 kg", "1 kg = 2.204623 lb"),
    ("lbf", "n"): ("1 lbf = 4.448222 N", "1 N = 0.2248089 lbf"),
    ("rad", "deg"): ("1 rad = 57.29578 deg", "1 deg = 0.01745329 rad"),
    ("hz", "rpm"): ("1 Hz = 60 rpm", "1 rpm = 1/60 Hz"),
}
CONVERSIONS = {
    **{pair: there for pair, (there, _) in _ONE_WAY.items()},
    **{pair[::-1]: back for pair, (_, back) in _ONE_WAY.items()},
}
UNSEEN = ("Cc", "Cf", "Cs", "Zl", "Zp")  # Unicode's categories of what moves a cursor, turns text round or ends a line


@dataclass(frozen=True)
class UnknownName:
    """Unknown name, as an error holds it.

    `near` is the nearest known name, `owner` the one plugin that has a setting of this name, such as `optimizer=pso`.
    """

    noun: str
    name: str
    near: str | None = None
    owner: str = ""

    @property
    def setting(self) -> str:
        """The setting that the name stands for, or is the value of; '' if it is neither."""
        return self.name if self.noun == "setting" else self.noun if self.noun.isidentifier() else ""


class SettingError(ValueError):
    """Setting, name or file that cannot be used.

    One line with what was expected, what was given and a cure.

    The message is one line of visible characters, whatever it quotes. `reason` is the message without locations before it.

    Args:
        message: "expected …, got …; try …".
        setting: key of the setting that is wrong, which is put before the message.
        meant: what was probably meant: a name, all arguments of a command, or the setting's value as a function of the one given.

    >>> str(SettingError("expected a number, got 'many'", setting="samples"))
    "samples: expected a number, got 'many'"
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
        """This error with a location before its message.

        Args:
            where: file, plugin or other location.
            setting: whole key of the setting. Default: as before.
        """
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
    """Error for an unknown name, with the nearest known one and then all of them.

    Args:
        noun: kind of name, such as "optimizer".
        name: the unknown name.
        known: all known names.
        within: prefix of the unknown name in the message, not of the known ones.

    >>> str(unknown("optimizer", "dee", ["de", "pso"]))
    "unknown optimizer 'dee'; did you mean 'de'? known: de, pso"
    """
    names = sorted(known)
    name = shortened(name, LONGEST_NAME)
    close = nearest(name, names)
    converted = conversions(name, close) if close is not None else []
    near = f"{within}{shortened(close)}" if close is not None and not converted else None
    found = UnknownName(noun, f"{within}{name}", near)
    hint = f"did you mean '{near}'? " if near is not None else ""
    if converted:
        hint = f"{shortened(str(close))} is another quantity: convert by {'; '.join(converted)}; "
    return SettingError(f"unknown {noun} '{found.name}'; {hint}known: {listed(names)}", meant=found)


def conversions(name: str, known: str) -> list[str]:
    """Conversions from a quantity into one with a similar name.

    A name is never proposed in place of one that means something else.

    >>> conversions("phase_lag_deg", "phase_lead_deg"), conversions("amplitude_mil_pp", "amplitude_um_0pk")
    (['lead = -lag'], ['1 mil = 25.4 um', '0pk = pp / 2'])
    >>> conversions("phase_led_deg", "phase_lead_deg")
    []
    """
    own, other = (set(WORD.findall(each.casefold())) for each in (name, known))
    pairs = ((word, meant) for word in sorted(own - other) for meant in sorted(other - own))
    return [CONVERSIONS[pair] for pair in pairs if pair in CONVERSIONS]


def listed(names: list[str]) -> str:
    """Known names as an error lists them."""
    shown = [shortened(each, LONGEST_NAME) for each in names[:MOST_NAMES]]
    more = [f"{len(names) - len(shown)} more"] if len(names) > len(shown) else []
    return ", ".join([*shown, *more]) or "none"


def nearest(name: str, known: Iterable[str], cutoff: float = 0.5) -> str | None:
    """Known name nearest to a wrong one, in upper or lower case.

    None if none is similar by the ratio `cutoff`, and none is the beginning of the other.

    >>> nearest("lm", ["DE", "LM"]), nearest("Kriging+de", ["DE", "Kriging + DE"]), nearest("x", ["DE"])
    ('LM', 'Kriging + DE', None)
    >>> nearest("rep", ["repetitions", "seed"]), nearest("upwards", ["up"]), nearest("file", ["path", "scale"])
    ('repetitions', 'up', None)
    """
    folded: dict[str, str] = {}
    for each in sorted(known):
        folded.setdefault(each.casefold(), each)
    wrong = name.casefold()
    close = difflib.get_close_matches(wrong, folded, n=1, cutoff=cutoff) or [
        each for each in folded if _begins(each, wrong)
    ]
    return folded[close[0]] if close else None


def _begins(one: str, other: str) -> bool:
    """Whether the shorter of two texts, of two characters or more, begins the longer one."""
    shorter, longer = sorted((one, other), key=len)
    return len(shorter) > 1 and longer.startswith(shorter)


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
    r"""Text of a file, a record or a plan as a terminal may show it.

    Characters that control the terminal or cannot be seen are replaced by their escape, except those in `kept`.

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
    """Visible text of several lines, which stay lines."""
    return visible(text, kept="\n")


def warn_moved(old: str, new: str) -> None:
    """Warn an importer of an old module path, which works for one more release, of the new one."""
    warnings.warn(f"{old} has moved to {new}; import it from there", DeprecationWarning, stacklevel=3)


def warn_renamed(old: str, new: str) -> None:
    """Warn the author of a plugin's class of the new name of a member that it overrides.

    The old name works for one more release.
    """
    warnings.warn(f"{old} has been renamed {new}; override that", DeprecationWarning, stacklevel=4)  # below ABCMeta

"""Check that an experiment's words have the form setting=value, before loading what reads them.

A word in another form is rejected with the reason and the command line that was probably meant.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence

from bench.command_line.bench_settings import bench_fields
from bench.command_line.config_dirs import experiment_names
from ksmea.errors import SettingError, nearest, shortened, unknown
from ksmea.plugins.names import GROUPS

HYDRA_OPTIONS = {  # whether a value follows: no, perhaps, yes
    "--multirun": "",
    "-m": "",
    "--cfg": "yes",
    "-c": "yes",
    "--info": "perhaps",
    "-i": "perhaps",
    "--config-dir": "yes",
    "-cd": "yes",
    "--package": "yes",
    "-p": "yes",
    "--resolve": "",
}
VALUES = {
    "--cfg": ("all", "hydra", "job"),
    "-c": ("all", "hydra", "job"),
    "--info": ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath"),
    "-i": ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath"),
}
ALSO = ("--help", "--quiet", "--verbose", "--version", "-h", "-q", "-v")  # options that are done before these
PAIRS = {"[": "]", "{": "}", "(": ")"}
BLOCKS = ("grid", "add", "cross")  # lists of blocks {setting: value}
ALIKE = 0.7  # ratio from which a first word is taken for a slip of a name
ESCAPED = re.compile(r"\\.", re.DOTALL)
NAMED = (
    "output",
    "measurement.path",
    "problem.file",
    "name",
    "label",
)  # settings that are a name, of a file or otherwise
QUOTES = "'\""


def joined_options(words: Sequence[str]) -> list[str]:
    """The words with the value of an option in the same word, --config-dir=DIR.

    Raises `SettingError` for an option that is not one, or has no value.
    """
    joined: list[str] = []
    remaining = list(words)
    while remaining:
        word = remaining.pop(0)
        option, _, value = word.partition("=")
        if not word.startswith("-"):
            joined.append(word)
            continue
        if option not in HYDRA_OPTIONS:
            raise _unknown_option(words, word)
        takes = HYDRA_OPTIONS[option]
        if value and not takes:
            raise SettingError(
                f"{shortened(word)}: expected {option} without a value, got one",
                meant=[option if each == word else each for each in words],
            )
        follows = takes and not value and remaining and not remaining[0].startswith("-")
        if follows and (takes == "yes" or remaining[0] in VALUES[option]):
            value = remaining.pop(0)
        if takes == "yes" and not value:
            listed = f"one of {', '.join(VALUES[option])}" if option in VALUES else "a value"
            raise SettingError(f"{option}: expected {listed} after it, got nothing")
        if value and option in VALUES and value not in VALUES[option]:
            raise unknown(f"value of {option}:", value, VALUES[option])
        joined.append(f"{option}={value}" if value else option)
    return joined


def require_shape(words: Sequence[str], commands: Collection[str]) -> None:
    """Raise `SettingError` for the first word that is not of the form setting=value.

    `commands` are the names of commands, one of which such a word may be.
    """
    for number, word in enumerate(words):
        if word.startswith("-") or _is_name(word):
            continue
        if word.startswith("~") and not word.startswith("~hydra"):
            raise SettingError(
                f"{word}: expected setting=value, a setting cannot be taken away; leave the word out",
                meant=[*words[:number], *words[number + 1 :]],
            )
        before, after = list(words[:number]), list(words[number + 1 :])
        if (whole := _opened(word, after)) is not None:
            rest = after[len(whole) - 1 :]
            key, _, value = " ".join(whole).partition("=")
            listed = f"{key}=[{value}]" if key in BLOCKS and value.startswith("{") else f"{key}={value}"
            raise SettingError(
                f"{word}: expected the whole value in one word, got it in {len(whole)}; put the word into quotes",
                meant=[*before, listed, *rest],
            )
        if "=" not in word:
            raise _no_setting(word, before, after, commands)
        _require_value(word, before, after)


def _is_name(word: str) -> bool:
    """Whether a word sets a name that stands without quotation marks: any sign may be in it."""
    key, _, value = word.partition("=")
    return (
        key.lstrip("+") in NAMED and bool(value) and not value.startswith((*PAIRS, *QUOTES, "=")) and ",," not in value
    )


def _unknown_option(words: Sequence[str], word: str) -> SettingError:
    option, _, value = word.partition("=")
    name = option.lstrip("-").replace("-", "_")
    if name in bench_fields() or name.partition(".")[0] in GROUPS or name == "experiment":
        number = list(words).index(word)
        following = words[number + 1 : number + 2] if not value else []
        plus = "+" if name == "experiment" else ""
        meant = [*words[:number], f"{plus}{name}={value or ''.join(following)}", *words[number + 1 + len(following) :]]
        return SettingError(f"{option}: settings stand without dashes, as {plus}{name}=…", meant=meant)
    known = [*HYDRA_OPTIONS, *ALSO]
    if not word.startswith("--"):  # one letter is as near as another
        return SettingError(f"unknown option '{shortened(word)}'; known: {', '.join(sorted(known))}")
    return unknown("option", word, known)


def _opened(word: str, after: Sequence[str]) -> list[str] | None:
    """The words up to the one that closes a bracket which a word opens.

    None if none does, or it opens none.
    """
    if "=" not in word or _unclosed(word) == "":
        return None
    for number in range(1, len(after) + 1):
        whole = [word, *after[:number]]
        if _unclosed(" ".join(whole)) == "":
            return whole
    return None


def _unclosed(text: str) -> str:
    """Closing signs of all brackets and quotes left open in a text; '?' if it closes an unopened one."""
    pending: list[str] = []
    for sign in ESCAPED.sub("", text):
        if pending and pending[-1] in QUOTES:
            if sign == pending[-1]:
                pending.pop()
        elif sign in QUOTES:
            pending.append(sign)
        elif sign in PAIRS:
            pending.append(PAIRS[sign])
        elif sign in PAIRS.values() and (not pending or pending.pop() != sign):
            return "?"
    return "".join(reversed(pending))


def _no_setting(word: str, before: list[str], after: list[str], commands: Collection[str]) -> SettingError:
    """Probable meaning of an argument without '='."""
    if word in commands:
        return SettingError(
            f"{word}: expected a command as the first word, got it later", meant=[word, *before, *after]
        )
    bare = word.lstrip("+")
    if bare in experiment_names():
        return SettingError(
            f"{word}: expected setting=value; an experiment is chosen by +experiment={bare}",
            meant=[*before, f"+experiment={bare}", *after],
        )
    key, _, value = bare.partition(":")
    is_setting = key in (*bench_fields(), "experiment") or key.partition(".")[0] in GROUPS
    if is_setting and value:
        return SettingError(f"{word}: expected setting=value, got a colon", meant=[*before, f"{key}={value}", *after])
    if is_setting and (after or before) and (after[:1] == ["="] or not _is_setting(after[:1])):
        rest = after[1:] if after[:1] == ["="] else after
        if rest and not _is_setting(rest[:1]):
            meant = [*before, f"{key}={rest[0].lstrip('=')}", *rest[1:]]
            return SettingError(f"{word}: expected setting=value in one word, without spaces", meant=meant)
    if is_setting:
        return SettingError(
            f"{word}: expected setting=value, got no value; python -m bench help {key} says what it takes"
        )
    if before and before[-1].endswith(","):
        return SettingError(f"{word}: expected no space after a comma", meant=[*before[:-1], before[-1] + word, *after])
    if before and _is_setting(before[-1:]) and before[-1].partition("=")[0].lstrip("+") in GROUPS:
        return SettingError(
            f"{word}: expected setting=value; several values have commas between them",
            meant=[*before[:-1], f"{before[-1]},{word}", *after],
        )
    if not before and (near := nearest(bare, commands, ALIKE)) is not None:
        return SettingError(
            f"unknown command '{word}'; did you mean '{near}'? known: {', '.join(commands)}", meant=[near, *after]
        )
    if (near := nearest(bare, experiment_names(), ALIKE)) is not None and len(after) < 2 and not before:
        return SettingError(
            f"{word}: expected a command or setting=value; did you mean the experiment '{near}'? commands:"
            f" {', '.join(commands)}",
            meant=[f"+experiment={near}", *after],
        )
    if not before and after and after[0] in experiment_names():
        return _no_setting(after[0], [], after[1:], commands)
    return SettingError(
        f"{word}: expected setting=value, as samples=40, or one of the commands {', '.join(commands)} as the first word;"
        " python -m bench help lists all"
    )


def _is_setting(words: Sequence[str]) -> bool:
    return bool(words) and "=" in words[0].strip("=")


def _require_value(word: str, before: list[str], after: list[str]) -> None:
    """Raise `SettingError` if what stands behind '=' cannot be a value."""
    key, _, value = word.partition("=")
    if not key.lstrip("+~"):
        raise SettingError(f"{word}: expected setting=value in one word, got no name of a setting before '='")
    if value.startswith("="):
        raise SettingError(f"{word}: expected one '=', got two", meant=[*before, f"{key}={value.lstrip('=')}", *after])
    missing = _unclosed(value)
    if missing == "?":
        raise SettingError(
            f"{word}: expected brackets in pairs, got a closing one that none opens; check brackets and quotes"
        )
    if missing:
        raise SettingError(
            f"{word}: expected {missing} at the end, got a bracket or quote that is not closed",
            meant=[*before, word + missing, *after],
        )
    if any(sign in value for sign in "[{(" + QUOTES):
        return
    if value.endswith(",") and after and not _is_setting(after[:1]) and not after[0].startswith("-"):
        raise SettingError(f"{word}: expected no space after a comma", meant=[*before, word + after[0], *after[1:]])
    if value and "" in value.split(",") and "=" not in value:
        kept = ",".join(filter(None, value.split(",")))
        raise SettingError(
            f"{word}: expected a value on both sides of each comma, got none", meant=[*before, f"{key}={kept}", *after]
        )
    if ";" in value and " " not in value and all(part.strip() for part in value.split(";")):
        raise SettingError(
            f"{word}: expected commas between values, got a semicolon", meant=[*before, word.replace(";", ","), *after]
        )

"""Names of files and folders with signs that Hydra's grammar keeps for itself: µ, commas, '=', brackets.

A value that is the name of a file just as it stands is that file; so is one that the grammar cannot read at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.errors import HydraException

from bench.command_line.overrides import override
from bench.command_line.word_shapes import NAMED

LISTS = ("plugins", "share", "hydra.searchpath")  # and lists of such names
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

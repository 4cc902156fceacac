"""What synthetic data hide, told beside what was found in them and apart from it."""

from __future__ import annotations

from collections.abc import Sequence

from ksmea.records.hidden import HiddenEffect

HIDDEN_COLUMN = "hidden_values"  # of tables


def hidden_in_one_line(hidden: Sequence[HiddenEffect]) -> str:
    """Effects with their locations and values, for a field of a table."""
    return "; ".join(map(str, hidden))


def hidden_text(hidden: Sequence[HiddenEffect | str], study: str) -> str:
    """The same below a text, a line each; empty where nothing is hidden. `study` is what did not see it."""
    return (
        "\n  ".join([f"Hidden in these synthetic data (not seen by the {study}):", *map(str, hidden)]) if hidden else ""
    )

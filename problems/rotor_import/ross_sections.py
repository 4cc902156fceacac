"""Sections of a file of ROSS: numbers, nodes and switches, each with its place in the error."""
# Shorter than 40 lines: what the readers of its classes share.

from __future__ import annotations

from ksmea.errors import described
from ksmea.settings.document import Block

Section = Block  # file, name of the section, its values
MOST_NODES = 10**6


def optional(section: Section, key: str, *, at_least: float | None = None) -> float:
    """A number that may be left out, or be null; it is 0 then."""
    return section.number(key, at_least=at_least) if section.values.get(key) is not None else 0.0


def whole(section: Section, key: str) -> int:
    """A node."""
    value = section.values.get(key)
    if isinstance(value, bool) or not isinstance(value, int) or not 0 <= value <= MOST_NODES:
        raise section.error(key, f"expected a node, a whole number from 0 on, got {described(value)}")
    return value


def truth(section: Section, key: str) -> bool:
    """A switch, on unless it is false."""
    value = section.values.get(key, True)
    if not isinstance(value, bool):
        raise section.error(key, f"expected true or false, got {described(value)}")
    return value


def tag_of(section: Section) -> str:
    """The user's own name of it."""
    return str(section.values.get("tag") or section.path.partition("_")[2] or section.path)

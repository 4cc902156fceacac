"""The glossary of the documentation as help: one source for both, read where it is written."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from bench.storage.own_files import GLOSSARY

SECTION, ROW = "## ", "| "
CELLS = re.compile(r"(?<!\\)\|")  # what parts the cells of a table's row
HEAD, RULE = "term", "---"
NAMES = re.compile(r"[,;:]|\band\b")  # what parts the names of a term that has several
ASIDE = re.compile(r"\(([^)]*)\)")  # fields and settings of the same meaning
MARKUP = re.compile(r"`|\*|\\(?=\|)|\[(?=[^\]]*\]\()|(?<=[^\]\s])\]\([^)]*\)")
SPELT = {"δ": "delta ", "χ²": "chi2", "σ": "sigma", "θ": "theta"}  # how a keyboard has them
MOST = 5  # entries that a part of a term brings


@dataclass(frozen=True)
class Entry:
    """A term with its meaning and all its names, in plain text."""

    section: str
    term: str
    meaning: str

    @property
    def names(self) -> tuple[str, ...]:
        """The whole term and each part of it that names the same: `limit (`limits`, `at_limit`)` has four."""
        inside = [name for aside in ASIDE.findall(self.term) for name in NAMES.split(aside)]
        parts = NAMES.split(ASIDE.sub("", self.term))
        found = (plain(name) for name in (self.term, *parts, *inside))
        return tuple(dict.fromkeys(name for name in found if name))

    def __str__(self) -> str:
        return f"{self.term} (glossary, {self.section.lower()}): {self.meaning}"


def entries() -> list[Entry]:
    """All entries, in the order of the page; none if an installation has no glossary."""
    return list(_parsed(GLOSSARY.read_text(encoding="utf-8"))) if GLOSSARY.is_file() else []


def explained(asked: str) -> list[Entry]:
    """The entries of a term, in whatever case, with Greek letters spelt out or not.

    >>> [entry.term for entry in explained("crlb")], [entry.term for entry in explained("delta bic")]
    (['CRLB'], ['ΔBIC'])
    """
    wanted = plain(asked)
    return [entry for entry in entries() if wanted in entry.names]


def mentioned(asked: str) -> list[Entry]:
    """The first entries in whose term all words occur that are requested.

    >>> [entry.term for entry in mentioned("decrement")]
    ['log decrement']
    """
    words = set(plain(asked).split())
    found = (entry for entry in entries() if words and any(words <= set(name.split()) for name in entry.names))
    return list(islice(found, MOST))


def terms() -> list[str]:
    """Every term as it is written, to be proposed where a name is not known."""
    return [
        ASIDE.sub("", name).strip() for entry in entries() for name in NAMES.split(ASIDE.sub("", entry.term)) if name
    ]


def plain(name: str) -> str:
    """A name as it is looked up.

    >>> plain("ΔBIC"), plain("Log-decrement"), plain("at_limit"), plain("  χ² ")
    ('delta bic', 'log decrement', 'at limit', 'chi2')
    """
    text = unicodedata.normalize("NFC", name).casefold()
    for letter, spelt in SPELT.items():
        text = text.replace(letter, spelt)
    return " ".join(re.sub(r"[^\w/]+|_", " ", text).split())


def _parsed(text: str) -> Iterator[Entry]:
    section = ""
    for line in text.splitlines():
        if line.startswith(SECTION):
            section = line.removeprefix(SECTION).strip()
        elif line.startswith(ROW):
            term, meaning = (MARKUP.sub("", cell).strip() for cell in CELLS.split(line.strip().strip("|")))
            if term != HEAD and not term.startswith(RULE):
                yield Entry(section, term, meaning)

"""README and docs as their readers see them.

Blocks of code, commands, links and anchors of Markdown pages.
"""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from filled_pages import filled

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
FENCE = re.compile(r"^```([\w-]*)[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
INLINE = re.compile(r"(?<!`)`([^`]+)`(?!`)")
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ +(.+)$", re.MULTILINE)
PROMPT = "$ "
IS_COMMAND = re.compile(r"([A-Z_]+=\S* )*python3? ")
SHELL = ("sh", "")  # languages of blocks that may hold commands


@dataclass(frozen=True)
class Command:
    page: str
    words: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.page}: {shlex.join(self.words)}"


def pages() -> list[Path]:
    """All pages that are written by hand."""
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted(DOCS.rglob("*.md"))]


@cache
def text_of(page: Path) -> str:
    """A page with what is filled in when the site is built."""
    return filled(page.read_text(encoding="utf-8"))


def blocks(text: str, *languages: str) -> list[str]:
    """Contents of the blocks in one of the languages; all where none is named."""
    return [content for language, content in FENCE.findall(text) if not languages or language in languages]


def commands(page: Path) -> list[Command]:
    """Every command that a page shows.

    Lines of shell blocks, lines with a prompt, and `python -m bench …` within the text.
    """
    text, found = text_of(page), []
    for language, content in FENCE.findall(text):
        if language not in SHELL:
            continue
        lines = _whole(content.replace("\\\n", " ").splitlines())
        found += [line.removeprefix(PROMPT) for line in lines if language == "sh" or line.startswith(PROMPT)]
    found += [" ".join(code.split()) for code in INLINE.findall(FENCE.sub("", text)) if IS_COMMAND.match(code)]
    name = page.relative_to(ROOT).as_posix()
    return [Command(name, tuple(words)) for line in found for words in _simple(line)]


def _whole(lines: list[str]) -> list[str]:
    """Lines of a shell, with those joined that a quoted text goes over."""
    joined: list[str] = []
    for line in lines:
        if joined and _is_open(joined[-1]):
            joined[-1] += f"\n{line}"
        else:
            joined.append(line)
    return joined


def _is_open(line: str) -> bool:
    try:
        shlex.split(line, comments=True)
    except ValueError:  # no closing quotation
        return True
    return False


def _simple(line: str) -> list[list[str]]:
    """The commands of a line that are joined by && or ;, without remarks."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars="&;")
    lexer.whitespace_split = True
    out: list[list[str]] = [[]]
    for word in lexer:
        if set(word) <= set("&;"):
            out.append([])
        else:
            out[-1].append(word)
    return [words for words in out if words]


def links(text: str) -> list[str]:
    """Targets of the links in a page, outside of code."""
    return LINK.findall(INLINE.sub("", FENCE.sub("", text)))


def anchors(text: str) -> set[str]:
    """Anchors of a page's headings, as GitHub makes them."""
    headings = HEADING.findall(FENCE.sub("", text))
    return {re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-") for heading in headings}

"""Plain text of docstrings and remarks as Markdown.

Every sign means itself, but for `code` and lists.
"""

from __future__ import annotations

import re
import textwrap

CODE = re.compile(r"(`[^`]+`)")
SIGNS = re.compile(r"([\\*_<>\[\]$#|~])")
EXAMPLE = ">>> "


def as_markdown(text: str) -> str:
    """A docstring as Markdown: paragraphs and lists as they are, indented formulas and examples as blocks.

    >>> print(as_markdown("Of `a_b` * c:\\n\\n    y = x*"))
    Of `a_b` \\* c:
    <BLANKLINE>
    ```text
    y = x*
    ```
    """
    return "\n\n".join(map(_paragraph, re.split(r"\n\s*\n", text.strip("\n")))) if text else ""


def cell(text: str) -> str:
    """A remark in one line, as a cell of a table."""
    return " ".join(escaped(text).split())


def escaped(text: str) -> str:
    """Text outside of `code` with its signs escaped.

    Within a table a bar would end the cell, so that it is escaped there too.
    """
    return "".join(
        part.replace("|", "\\|") if index % 2 else SIGNS.sub(r"\\\1", part)
        for index, part in enumerate(CODE.split(text))
    )


def _paragraph(text: str) -> str:
    if text.startswith(EXAMPLE):
        return f"```pycon\n{text}\n```"
    if all(line.startswith("    ") for line in text.splitlines()):
        return f"```text\n{textwrap.dedent(text)}\n```"
    return escaped(text)

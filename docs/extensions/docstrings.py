"""Docstrings as Sphinx reads them.

Ours are plain text, in which `name` is code and signs such as * and | mean themselves, with sections (Args, Returns, Raises,
Source) in the style of Google.
"""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config
from sphinx.ext.napoleon.docstring import GoogleDocstring

CODE = re.compile(r"(?<!`)`([^`]+)`(?!`)")
IN_FRONT = re.compile(r"^(\s*)(>>>|\.\.\. )")
SECTIONS = Config(napoleon_custom_sections=["Source"])
MARKUP = re.compile(r"([*|\\])|(?<=\w)_(?=\W|$)")


def as_restructured_text(lines: list[str]) -> list[str]:
    r"""Lines of a docstring whose text says in reStructuredText what it says as it stands.

    Examples are left alone.

    >>> as_restructured_text(["Raises `SettingError` at |r| > 1 (`*`).", "", ">>> `a`"])
    ['Raises ``SettingError`` at \\|r\\| > 1 (``*``).', '', '>>> `a`']
    """
    out, in_example = [], False
    for line in lines:
        in_example = bool(IN_FRONT.match(line)) or (in_example and bool(line.strip()))
        out.append(line if in_example else _text(line))
    return out


def _text(line: str) -> str:
    """Code and what stands between, one after the other."""
    parts = CODE.split(line)  # text, code, text, …
    return "".join(
        f"``{part}``" if index % 2 else MARKUP.sub(lambda found: "\\" + found[0], part)
        for index, part in enumerate(parts)
    )


def _process(app: Sphinx, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    # A property is read like a method: otherwise its text before a colon would be its type.
    what = "method" if what == "property" else what
    lines[:] = GoogleDocstring(as_restructured_text(lines), SECTIONS, None, what, name, thing, options).lines()


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("autodoc-process-docstring", _process)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

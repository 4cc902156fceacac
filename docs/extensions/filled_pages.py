"""Pages that are filled when the site is built: where one has the line `<!-- filled: optimizer -->`, the settings of all
optimisers stand; where `further` stands, the names of pages that no list of index.md names yet."""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx

from experiment_pages import experiments_text, settings_text
from ksmea.plugins import registry
from plugin_pages import EFFECT, group_text

DOCS = Path(__file__).resolve().parents[1]
MARK = re.compile(r"^<!-- filled: (\w+) -->$", re.MULTILINE)


def filled(page: str) -> str:
    """A page with its marks replaced."""
    return MARK.sub(lambda mark: _content(mark[1]), page)


def _content(name: str) -> str:
    if name in (*registry.GROUPS, EFFECT):
        return group_text(name)
    return {"settings": settings_text, "experiments": experiments_text, "further": further_pages}[name]()


def further_pages() -> str:
    """Pages that are in the folder and in no list: a new one is found in the site before anyone says where it belongs."""
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    named = {"index", *re.findall(r"^[a-z_0-9/]+$", index, re.MULTILINE)}
    return "\n".join(sorted({page.stem for page in DOCS.glob("*.md")} - named))


def _fill(app: Sphinx, page: str, source: list[str]) -> None:
    source[0] = filled(source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("source-read", _fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

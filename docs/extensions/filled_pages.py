"""Pages that are filled when the site is built: where one has the line `<!-- optimizer -->`, the settings of all optimisers stand."""

from __future__ import annotations

import re

from experiment_pages import experiments_text, settings_text
from plugin_pages import EFFECT, group_text
from sphinx.application import Sphinx

from ksmea import registry

MARK = re.compile(r"^<!-- filled: (\w+) -->$", re.MULTILINE)


def filled(page: str) -> str:
    """A page with its marks replaced."""
    return MARK.sub(lambda mark: _content(mark[1]), page)


def _content(name: str) -> str:
    if name in (*registry.GROUPS, EFFECT):
        return group_text(name)
    return {"settings": settings_text, "experiments": experiments_text}[name]()


def _fill(app: Sphinx, page: str, source: list[str]) -> None:
    source[0] = filled(source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("source-read", _fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Pages completed when the site is built.

A line `<!-- filled: NAME -->` is replaced by generated text.

NAME is a kind of plugin (its settings), `effects_overview`, `settings`, `experiments`, `contract_tests`, a table of
results/reference (`evidence.TABLES`), or `further` (pages that no list of index.md names).
"""

from __future__ import annotations

import re
from pathlib import Path

from sphinx.application import Sphinx

from contract_tests import contract_tests_text
from evidence import TABLES, evidence_table
from experiment_pages import experiments_text, settings_text
from ksmea.plugins import registry
from plugin_pages import EFFECT, effects_overview, group_text

DOCS = Path(__file__).resolve().parents[1]
MARK = re.compile(r"^<!-- filled: (\w+) -->$", re.MULTILINE)


def filled(page: str) -> str:
    """Page with its marks replaced."""
    return MARK.sub(lambda mark: _content(mark[1]), page)


def _content(name: str) -> str:
    if name in (*registry.GROUPS, EFFECT):
        return group_text(name)
    if name in TABLES:
        return evidence_table(name)
    texts = {
        "settings": settings_text,
        "experiments": experiments_text,
        "effects_overview": effects_overview,
        "contract_tests": contract_tests_text,
        "further": further_pages,
    }
    return texts[name]()


def further_pages() -> str:
    """Pages of the folder that no list names, so that a new page appears in the site."""
    index = (DOCS / "index.md").read_text(encoding="utf-8")
    named = {"index", *re.findall(r"^[a-z_0-9/]+$", index, re.MULTILINE)}
    return "\n".join(sorted({page.stem for page in DOCS.glob("*.md")} - named))


def _fill(app: Sphinx, page: str, source: list[str]) -> None:
    source[0] = filled(source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    app.connect("source-read", _fill)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

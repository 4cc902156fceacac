"""Pages are short: words are counted outside code blocks, a word having a letter or a digit."""

import re

import pytest

from shown_pages import DOCS, FENCE, ROOT

MOST = 900
LONGER = {"ksmea.md": 1000, "results.md": 1300, "glossary.md": 1400}  # equations, the paper's tables, a list
IN_ALL = 28_000
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]


def words(page):
    return len(re.findall(r"\S*\w\S*", FENCE.sub("", page.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_is_short(page):
    assert words(page) <= LONGER.get(page.name, MOST)


def test_all_pages_are_short():
    assert sum(map(words, PAGES)) <= IN_ALL

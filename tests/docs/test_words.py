"""Pages are short: words are counted outside code blocks, a word having a letter or a digit; in all also as `wc -w` counts."""

import re

import pytest

from shown_pages import DOCS, FENCE, ROOT

MOST = 780
LONGER = {"ksmea.md": 970, "results.md": 1240, "glossary.md": 1200}  # equations, the paper's tables, a list
IN_ALL = 21_500
WITH_CODE = 28_000  # of docs, as `wc -w docs/*.md` has them
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]


def words(page):
    return len(re.findall(r"\S*\w\S*", FENCE.sub("", page.read_text(encoding="utf-8"))))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_a_page_is_short(page):
    assert words(page) <= LONGER.get(page.name, MOST)


def test_all_pages_are_short():
    assert sum(map(words, PAGES)) <= IN_ALL


def test_all_pages_are_short_with_their_code():
    assert sum(len(page.read_text(encoding="utf-8").split()) for page in DOCS.glob("*.md")) <= WITH_CODE

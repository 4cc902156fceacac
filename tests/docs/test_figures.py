"""Each figure of the docs is shown on a page, and CONTRIBUTING.md names the command that makes it."""

import re

from shown_pages import DOCS, LINK, ROOT, pages, text_of

FIGURES = {path.name for path in (DOCS / "figures").iterdir()}
ROW = re.compile(r"^\| ((?:`\w+\.png`(?:, )?)+) \| `(python [^`]+)` \| .+ \|$", re.MULTILINE)


def test_each_figure_has_a_command():
    told = [
        name for names, _ in ROW.findall(text_of(ROOT / "CONTRIBUTING.md")) for name in re.findall(r"\w+\.png", names)
    ]
    assert sorted(told) == sorted(FIGURES)


def test_each_figure_is_shown():
    links = {link.rpartition("/")[2] for page in pages() for link in LINK.findall(text_of(page)) if "figures/" in link}
    assert links == FIGURES

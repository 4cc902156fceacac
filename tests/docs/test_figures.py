"""Each figure of the docs is shown on a page, and CONTRIBUTING.md names the command that makes it."""

import re

from shown_pages import DOCS, LINK, ROOT, pages, text_of

FIGURES = {path.name for folder in ("figures", "_static") for path in (DOCS / folder).glob("*.png")}
ROW = re.compile(r"^\| ((?:`\w+\.png`(?:, )?)+) \| `(python [^`]+)` \| .+ \|$", re.MULTILINE)
PICTURE = re.compile(r'<(?:source [^>]*srcset|img src)="([^"]+)"')


def test_each_figure_has_a_command():
    told = [
        name for names, _ in ROW.findall(text_of(ROOT / "CONTRIBUTING.md")) for name in re.findall(r"\w+\.png", names)
    ]
    assert sorted(told) == sorted(FIGURES)


def test_each_figure_is_shown_and_there():
    texts = {page: text_of(page) for page in pages()}
    links = {page.parent / link for page, text in texts.items() for link in LINK.findall(text) if "figures/" in link}
    links |= {page.parent / link for page, text in texts.items() for link in PICTURE.findall(text)}
    assert all(link.is_file() for link in links)
    assert {link.name for link in links} == FIGURES


def test_a_picture_of_a_page_has_a_dark_one():
    for page in pages():
        shown = PICTURE.findall(text_of(page))
        assert [name.replace("_light", "_dark") for name in shown[1::2]] == shown[::2], page.name

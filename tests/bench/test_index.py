"""The page over all results: what each row shows, and what only some folders have."""

import base64
import io
import os
import re

import pytest
from PIL import Image, ImageColor

from bench.plan.page import Page
from bench.reports.pages.document import document
from bench.reports.pages.index import MOST_UNFILTERED, index_page, write_index

COLOURS = {"finding.png": "blue", "cause.png": "lime", "other.png": "red"}


@pytest.fixture
def folder(tmp_path):
    """A function that writes a page with facts into a folder, and gives the index of all."""

    def write(name, *pictures, **facts):
        (tmp_path / name).mkdir()
        about = {"name": name, "study": "identify", "runs": 1, "headline": f"found in {name}", **facts}
        (tmp_path / name / "index.html").write_bytes(document(name, Page(f"found in {name}"), [], about, {}))
        for picture in pictures:
            Image.new("RGB", (400, 300), COLOURS[picture]).save(tmp_path / name / picture)
        return index_page(tmp_path).decode()

    return write


def test_failed_and_unfinished_runs_have_a_column_only_if_there_are_any(folder):
    page = folder("one", failed=0, unfinished=0)
    assert ">failed<" not in page and ">unfinished<" not in page
    page = folder("two", failed=3, unfinished=0)
    assert ">failed<" in page and ">3</td>" in page and ">unfinished<" not in page and ">0</td>" not in page


def test_a_row_has_the_picture_that_shows_most_of_its_folder(folder, tmp_path):
    assert "<img" not in folder("none")
    assert colours(folder("one", "cause.png", "finding.png")) == ["blue"]
    assert sorted(colours(folder("two", "other.png"))) == ["blue", "red"]
    (tmp_path / "two" / "other.png").write_bytes(b"no picture")
    assert colours(index_page(tmp_path).decode()) == ["blue"]


def test_a_picture_is_made_again_only_if_it_has_changed(folder, tmp_path, monkeypatch):
    folder("one", "finding.png")
    first = write_index(tmp_path).read_bytes()
    with monkeypatch.context() as patched:
        patched.setattr(Image, "open", lambda *_: pytest.fail("a known picture was made again"))
        assert write_index(tmp_path).read_bytes() == first
    picture = tmp_path / "one" / "finding.png"
    Image.new("RGB", (400, 300), COLOURS["other.png"]).save(picture)
    os.utime(picture, ns=(0, 1))
    assert colours(write_index(tmp_path).read_text(encoding="utf-8")) == ["red"]


def colours(page):
    """The colour of each picture that the page holds."""
    data = re.findall(r'src="data:image/png;base64,([^"]+)"', page)
    pixels = [Image.open(io.BytesIO(base64.b64decode(each))).convert("RGB").getpixel((5, 5)) for each in data]
    return [next(name for name in COLOURS.values() if ImageColor.getrgb(name) == each) for each in pixels]


def test_many_rows_can_be_chosen_by_words(folder):
    pages = [folder(f"result_{number}") for number in range(MOST_UNFILTERED + 1)]
    assert "<input" not in pages[-2] and pages[-1].count("<input") == 1

"""The documentation site: it is built without a warning, and everything that it points to is there."""

import html
import re
import subprocess
import sys
from collections import defaultdict
from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

import pytest

from ksmea.plugins import registry
from ksmea.settings.settings import own_fields
from mathml import _mathml
from pictures import drawn
from plugin_pages import own_plugins
from shown_pages import DOCS, ROOT, anchors, links, pages, text_of

pytestmark = pytest.mark.xdist_group("site")  # one worker builds it, once
GROUPS = [*registry.GROUPS, "effect"]
POINTERS = {"a": "href", "link": "href", "img": "src", "script": "src", "iframe": "src", "source": "src"}
LOADED = ("link", "img", "script", "iframe", "source")  # what a browser asks for by itself


class Page(HTMLParser):
    """Links of a page, and the places that can be pointed to in it."""

    def __init__(self, text):
        super().__init__()
        self.pointers, self.ids = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.ids |= {given[key] for key in ("id", "name") if given.get(key)}
        if given.get(POINTERS.get(tag)):
            self.pointers.append((tag, given[POINTERS[tag]]))


@pytest.fixture(scope="session")
def site(tmp_path_factory):
    """The folder of the site."""
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", str(DOCS), str(folder)]
    done = subprocess.run(command, check=False, capture_output=True, text=True, timeout=300, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="session")
def read(site):
    """Its pages by path."""
    return {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in site.rglob("*.html")}


def test_every_page_is_in_it(site, read):
    for page in DOCS.rglob("*.md"):
        assert (site / page.relative_to(DOCS)).with_suffix(".html").resolve() in read, page


def test_every_page_is_reached_from_the_first(site, read):
    first = (site / "index.html").resolve()
    reached, pending = {first}, [first]
    while pending:
        page = pending.pop()
        targets = {(page.parent / urlsplit(url).path).resolve() for tag, url in read[page].pointers if tag == "a"}
        pending += [target for target in targets & read.keys() if target not in reached]
        reached |= targets & read.keys()
    assert {page.name for page in read.keys() - reached} == {"genindex.html", "search.html"}  # by the search field


def test_every_link_and_anchor_is_there(read):
    broken = []
    for page, content in read.items():
        for _, url in content.pointers:
            parts = urlsplit(url)
            if parts.scheme or parts.netloc:
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            if not target.exists():
                broken.append(f"{page.name}: {url}")
            elif parts.fragment and target in read and unquote(parts.fragment) not in read[target].ids:
                broken.append(f"{page.name}: no {url}")
    assert not broken, "\n".join(broken)


def test_nothing_is_asked_of_the_network(site, read):
    for page, content in read.items():
        assert not [url for tag, url in content.pointers if tag in LOADED and urlsplit(url).netloc], page.name
    for style in site.rglob("*.css"):
        assert not re.search(r"url\(\s*['\"]?(https?:)?//|@import\s+['\"](https?:)?//", style.read_text()), style.name


def test_links_of_markdown_pages_hold_in_the_repository():
    """As GitHub shows them: README to docs, docs to each other and to headings."""
    known = defaultdict(set, {page.resolve(): anchors(text_of(page)) for page in pages()})
    broken = []
    for page in pages():
        for url in links(text_of(page)):
            parts = urlsplit(url)
            if parts.scheme:
                continue
            target = (page.parent / parts.path).resolve() if parts.path else page.resolve()
            if not target.exists() or (parts.fragment and parts.fragment not in known[target]):
                broken.append(f"{page.name}: {url}")
    assert not broken, "\n".join(broken)


@pytest.mark.parametrize("group", GROUPS)
def test_the_reference_has_every_setting_of_every_plugin(group, site):
    """The names, helps and sources that plugins have, whatever makes the page."""
    page = (site / "reference" / f"{'studie' if group == 'study' else group}s.html").read_text(encoding="utf-8")
    text = " ".join(html.unescape(re.sub(r"<[^>]+>", "", page)).split())
    assert own_plugins(group)
    for name in own_plugins(group):
        assert f'id="{name.replace("_", "-")}"' in page
        for field in own_fields(registry.plugin_class(group, name)):
            assert f"{group}.{field.name}" in text
            for told in (field.metadata["help"], field.metadata["source"], field.metadata["unit"]):
                assert plain(told) in plain(text), f"{group}={name}: {field.name}"


def plain(text):
    """Letters and digits alone: quotation marks and dashes become others on a page."""
    return re.sub(r"\W", "", text)


def test_an_equation_is_mathml():
    class Equation:
        def astext(self):
            return r"\frac{1}{n} \Omega^2"

    assert "<mfrac>" in _mathml(Equation()) and "Ω" in _mathml(Equation())


def test_a_picture_has_its_boxes_above_what_they_point_to():
    svg = drawn("a --> b\na --> c\nb --> c")
    rows = {name: float(y) for y, name in re.findall(r'<text x="[^"]+" y="([\d.]+)">(\w+)</text>', svg)}
    assert rows["a"] < rows["b"] < rows["c"] and svg.count("marker-end") == 3

"""A page as one HTML document: it asks nothing of a network, and no script runs but its own."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from html import unescape
from typing import Any

from bench.plan.page import Page, Section
from bench.reports.pages import bundle
from bench.reports.pages.blocks import Blocks
from bench.reports.pages.prose import safe, unbroken
from ksmea.show.charts.colours import DARK, LIGHT
from ksmea.show.text import capital

PAGE = "index.html"  # of a folder
FACTS = "ksmea-bench"  # name of the element that says what a page is about
FACTS_WITHIN = 8192  # characters from the beginning of a page
_FACTS = re.compile(rf'<meta name="{FACTS}" content="([^"]*)">')


def document(
    title: str, page: Page, sections: Sequence[Section], facts: Mapping[str, Any], drawings: Mapping[str, bytes]
) -> bytes:
    """The page under its finding, or without one under a title.

    `facts` are what an index shows of it, `drawings` the figures that sections name.
    """
    blocks = Blocks(drawings, page.headline)
    body = "".join(_section(number, section, blocks) for number, section in enumerate(sections, start=1))
    links = "".join(
        f'<li><a href="#part-{number}">{safe(each.title)}</a></li>'
        for number, each in enumerate(sections, 1)
        if each.title
    )
    script, style = bundle.asset("page.js"), bundle.asset("page.css")
    plots = _for_plots() if blocks.has_plots else ""
    allowed = [bundle.digest_of(script.encode()), *([bundle.digest()] if blocks.has_plots else [])]
    policy = f"default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; script-src {' '.join(allowed)}; base-uri 'none'"
    navigation = f'<nav aria-label="contents"><ol>{links}</ol></nav>' if len(sections) > 1 else ""
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n<meta name="{FACTS}" content="{_attribute(facts)}">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{safe(policy)}">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1"><title>{safe(title)}</title>'
        f"<style>{style}</style></head>\n"
        f"<body><header>{_header(title, page)}{navigation}</header>\n<main>{body}</main>\n"
        f"{plots}<script>{script}</script></body></html>\n"
    ).encode()


def _for_plots() -> str:
    """The library that draws plots, and their colours on a white ground with those on a dark one."""
    dark = json.dumps({on_white: DARK[role] for role, on_white in LIGHT.items()})
    return (
        f'<script type="text/plain" id="plotly">{bundle.packed()}</script>'
        f'<script type="application/json" id="dark">{dark}</script>'
    )


def facts_of(beginning: str) -> dict[str, Any] | None:
    """The facts of a page, of which these are the first characters.

    None if it is not a page of this project.
    """
    found = _FACTS.search(beginning)
    if found is None:
        return None
    try:
        facts = json.loads(unescape(found[1]))
    except ValueError:
        return None
    return facts if isinstance(facts, dict) else None


def _attribute(facts: Mapping[str, Any]) -> str:
    return safe(json.dumps(facts))


def _header(title: str, page: Page) -> str:
    """Title with the data, and below it the finding as heading; the title as heading without a finding."""
    if not page.headline:
        return f"<h1>{safe(title)}</h1>"
    first, _, rest = page.about.partition(" · ")  # its data, which titles of single files name too
    about = " · ".join(filter(None, [title, rest if title.endswith(first) else page.about]))
    finding = capital(page.headline)
    return f'<p class="about">{safe(about)}</p><h1>{unbroken(safe(finding))}</h1>'


def _section(number: int, section: Section, blocks: Blocks) -> str:
    inside = "".join(map(blocks.html, section.blocks))
    heading = f"<h2>{safe(section.title)}</h2>" if section.title else ""
    return f'<section id="part-{number}">{heading}{inside}</section>\n'

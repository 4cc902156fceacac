"""`open [NAME|DIR]`: the page of results in the browser; without a name the page over all results.

Without a browser, such as over ssh, it prints the path of the page.
"""

from __future__ import annotations

import os
import sys
import webbrowser
from pathlib import Path

from bench.commands.folders import folders
from bench.plan.plan import PLAN_FILE
from bench.reports.collect import collect
from bench.reports.pages.experiment import PAGE
from bench.reports.pages.index import page_facts, write_index
from ksmea.errors import SettingError, visible

RESULTS = Path("results")


def open_page(words: list[str]) -> int:
    """Open the page, and print where it is; one that is missing is made first."""
    if len(words) > 1:
        raise SettingError(f"open: expected one name or folder of results, or none, got {len(words)}")
    page = _page_of(words[0]) if words else _index(RESULTS)
    shown = page if page.is_absolute() else Path.cwd() / page
    opened = _has_display() and webbrowser.open(shown.as_uri())
    print(visible(str(page)) if opened else visible(f"{page} (no browser here: open this file in one)"))
    return 0


def _page_of(word: str) -> Path:
    folder = RESULTS / word
    if not (folder / PLAN_FILE).is_file() and "study" in page_facts(folder):
        return folder / PAGE  # of a command that makes a page by itself, such as draw
    first, *others = found = folders([word], "open")
    if others or Path(word).resolve() == first.parent.resolve():
        for each in found:
            _require_page(each)
        return write_index(first.parent)
    _require_page(first)
    return first / PAGE


def _require_page(folder: Path) -> None:
    if not (folder / PAGE).is_file():
        collect(folder)


def _index(folder: Path) -> Path:
    if not folder.is_dir():
        raise SettingError(
            f"open: expected a folder {folder} here, found none; run an experiment first, or name its folder"
        )
    return write_index(folder)


def _has_display() -> bool:
    """Whether a browser could show itself: a browser of the terminal would take the terminal."""
    if sys.platform in ("win32", "darwin"):
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"))

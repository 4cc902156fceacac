"""Where the bench's own files lie: in a checkout at its root, in an installed wheel inside this package."""

from __future__ import annotations

from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1]
ROOT = PACKAGE.parent  # of a checkout


def _place(in_wheel: str, in_checkout: str) -> Path:
    installed = PACKAGE / in_wheel
    return installed if installed.is_dir() else ROOT / in_checkout


CONF = _place("conf", "conf")
REFERENCE = _place("reference", "results/reference")
EXAMPLES = _place("examples", "examples")  # plugins of each kind, as packages from outside have them
GLOSSARY = _place("glossary", "docs") / "glossary.md"
PAPER = PACKAGE / "paper"  # the tables as the paper prints them

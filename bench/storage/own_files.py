"""Places of the bench's own files, in a checkout or an installed wheel; the commit of a checkout."""
# Shorter than 40 lines: nearly all of the bench imports it.

from __future__ import annotations

import subprocess
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


def checkout_commit() -> str:
    """Commit, followed by '+' if files differ from it; '' if this is not a checkout or git is missing."""
    if not (ROOT / ".git").exists():
        return ""
    command = ["git", "-C", str(ROOT), "describe", "--always", "--dirty=+", "--abbrev=12", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""

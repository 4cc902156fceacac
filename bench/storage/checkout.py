"""The commit of this checkout, if it is one."""

from __future__ import annotations

import subprocess

from bench.storage.places import ROOT


def checkout_commit() -> str:
    """The commit, '+' behind it where files differ from it; '' where this is no checkout, or there is no git."""
    if not (ROOT / ".git").exists():
        return ""
    command = ["git", "-C", str(ROOT), "describe", "--always", "--dirty=+", "--abbrev=12", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""

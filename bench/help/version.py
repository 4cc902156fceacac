"""What is running: the project's version, its commit in a clone, and Python's version."""

from __future__ import annotations

import platform
from importlib.metadata import version

from bench.storage.own_files import checkout_commit
from ksmea.plugins.names import PROJECT


def version_text() -> str:
    """For example 'ksmea-bench 0.1.0 (commit 1a2b3c4d5e6f, Python 3.11.2)'; a '+' behind a commit: files differ from it."""
    commit = checkout_commit()
    return f"{PROJECT} {version(PROJECT)} ({f'commit {commit}, ' if commit else ''}Python {platform.python_version()})"

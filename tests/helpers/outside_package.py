"""An installed package of someone else, for tests that enter the bench inside their own process."""

import sys
from contextlib import contextmanager
from pathlib import Path

import pytest

from ksmea.plugins import names, registry


@contextmanager
def outside_package(folder, monkeypatch, files):
    """Files by path in a folder that is on Python's path.

    The plugin that they register is forgotten afterwards.
    """
    for path, content in files.items():
        (folder / path).parent.mkdir(exist_ok=True)
        (folder / path).write_text(content)
    with on_path(folder, monkeypatch):
        yield


@contextmanager
def on_path(folder, monkeypatch):
    """A folder with an installed package on Python's path.

    The plugins of these names are forgotten afterwards.
    """
    monkeypatch.syspath_prepend(folder)
    registry.registered.cache_clear()
    yield
    registry.registered.cache_clear()


@contextmanager
def plain_files(folder):
    """A process that has registered no plain file yet.

    Plugins that it registers below the folder are forgotten afterwards.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "path", [*sys.path])
        patch.setattr(names, "_in_files", {})
        registry.registered.cache_clear()
        yield
    registry.registered.cache_clear()
    for name, module in [*sys.modules.items()]:
        if Path(getattr(module, "__file__", None) or "/").is_relative_to(folder):
            del sys.modules[name]

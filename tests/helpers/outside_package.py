"""An installed package of someone else, for tests that enter the bench inside their own process."""

from contextlib import contextmanager

from hydra.core.config_store import ConfigStore

from ksmea import registry


@contextmanager
def outside_package(folder, monkeypatch, files, group, name):
    """Files by path in a folder that is on Python's path; the plugin that they register is forgotten afterwards."""
    for path, content in files.items():
        (folder / path).parent.mkdir(exist_ok=True)
        (folder / path).write_text(content)
    monkeypatch.syspath_prepend(folder)
    registry.registered.cache_clear()
    yield
    registry.registered.cache_clear()
    ConfigStore.instance().repo.get(group, {}).pop(f"{name}.yaml", None)

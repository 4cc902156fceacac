"""What Hydra knows: the settings of a bench run and those of every registered plugin, typed."""

from __future__ import annotations

import dataclasses
import glob
import re
import typing
import unicodedata
from itertools import takewhile
from pathlib import Path
from typing import Any

from hydra.core.config_store import ConfigNode, ConfigStore
from hydra.core.plugins import Plugins
from omegaconf import OmegaConf
from omegaconf.errors import OmegaConfBaseException

from bench.command_line.bench_settings import BenchConfig
from bench.command_line.settable import copied, require_offered
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields

MOST_BYTES = 200  # of a folder's part; file systems take 255 in all


def folder_part(name: str) -> str:
    """A name as a part of a folder's: letters of any script, digits, points and hyphens; all else is an underscore.

    >>> folder_part("<b>Ümlaut (2)")
    '_b_Ümlaut_2_'
    """
    part = re.sub(r"[^\w.-]+", "_", unicodedata.normalize("NFC", name))
    return part.encode()[:MOST_BYTES].decode(errors="ignore")


def of_file(measurement: Any) -> str:
    """What a measured file adds to the name of a folder: '_run_up' of runs/run_up.csv, '_runs' of runs/*.csv; '' where there
    is none."""
    path = (measurement or {}).get("path") or ""
    folder = Path(*takewhile(lambda part: not glob.has_magic(part), Path(path).parts))
    name = folder.name if glob.has_magic(path) else Path(path).stem
    return f"_{folder_part(name)}" if name else ""


def register_schemas() -> None:
    """Give Hydra the schema of the bench and of every plugin under its group and name, and the conf's ${of_file:…}. A plugin is
    imported when its schema is composed: one that nobody chooses never is."""
    OmegaConf.register_new_resolver("of_file", of_file, replace=True)
    store = ConfigStore.instance()
    Plugins.instance()  # one of which brings a launcher of that name: conf/hydra/launcher has its settings
    store.repo["hydra"]["launcher"].pop("submitit_slurm.yaml", None)
    store.store(name="bench_schema", node=BenchConfig)
    for group in registry.GROUPS:
        for name in registry.registered(group):
            store.store(group=group, name=name, node={"name": name})
            store.repo[group][f"{name}.yaml"] = _PluginNode(group, name)


class _PluginNode(ConfigNode):
    """A stored schema that is made when it is asked for, once. Hydra makes a deep copy of its whole store for each composition,
    and asks a shallow one of this object, whose node it replaces: all share what was made."""

    _own: Any = None  # what Hydra has put in its place, in a copy

    def __init__(self, group: str, name: str) -> None:
        not_yet: Any = None
        super().__init__(f"{name}.yaml", node=not_yet, group=group, package=None, provider=None)
        self._plugin = name
        self._made: list[Any] = []

    @property
    def node(self) -> Any:
        if self._own is not None:
            return self._own
        if not self._made:
            self._made.append(OmegaConf.structured(_node(str(self.group), self._plugin)))
        return self._made[0]

    @node.setter
    def node(self, node: Any) -> None:
        self._own = node

    def __deepcopy__(self, memo: dict[int, Any]) -> _PluginNode:
        return self


def _node(group: str, name: str) -> Any:
    """The schema of a plugin; its bare name where it is broken, so that it is refused only where it is chosen."""
    try:
        require_offered(group, name)
        return _typed_node(group, name)
    except (SettingError, OmegaConfBaseException):
        return {"name": name}


def _typed_node(group: str, name: str) -> Any:
    """A plugin's own settings with their types, and its name so that a composed configuration says what was chosen."""
    plugin = registry.plugin_class(group, name)
    hints = typing.get_type_hints(plugin)
    settings = [(each.name, hints[each.name], copied(each)) for each in own_fields(plugin)]
    named = dataclasses.make_dataclass("Named" + plugin.__name__, [*settings, ("name", str, name)])
    node = OmegaConf.structured(named)
    for setting in own_fields(plugin):
        if node[setting.name] == {}:  # names that the plugin alone knows
            OmegaConf.set_struct(node[setting.name], False)
    return node

"""What Hydra knows: the settings of a bench run and those of every registered plugin, typed."""

from __future__ import annotations

import dataclasses
import typing
from dataclasses import dataclass, field
from typing import Any

from hydra.core.config_store import ConfigStore
from omegaconf import MISSING, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from ksmea import registry
from ksmea.errors import SettingError
from ksmea.settings import own_fields


@dataclass
class BenchConfig:
    """Settings of the bench itself; the six groups hold plugins. conf/config.yaml has the values and remarks."""

    name: str = MISSING
    samples: int = MISSING
    repetitions: int = MISSING
    seed: int = MISSING
    workers: int | None = None
    timeout: float | None = None
    memory: float | None = None
    journal: bool = False
    share: list[str] = field(default_factory=list)
    output: str = MISSING
    batches: int = MISSING
    batch: int = MISSING
    label: str | None = None
    table: str | None = None
    paper: str | None = None
    figures: list[str] = field(default_factory=list)
    exact: float | None = None
    includes: list[str] = field(default_factory=list)
    grid: list[dict[str, Any]] = field(default_factory=list)
    problem: Any = MISSING
    measurement: Any = MISSING
    surrogate: Any = MISSING
    optimizer: Any = MISSING
    method: Any = MISSING
    study: Any = MISSING


def register_schemas() -> None:
    """Give Hydra the schema of the bench and of every plugin under its group and name."""
    store = ConfigStore.instance()
    store.store(name="bench_schema", node=BenchConfig)
    for group in registry.GROUPS:
        for name in registry.registered(group):
            store.store(group=group, name=name, node=_node(group, name))


def _node(group: str, name: str) -> Any:
    """The schema of a plugin; its bare name where it is broken, so that it is refused only where it is chosen."""
    try:
        return _typed_node(group, name)
    except (SettingError, OmegaConfBaseException):
        return {"name": name}


def _typed_node(group: str, name: str) -> Any:
    """A plugin's own settings with their types, and its name so that a composed configuration says what was chosen."""
    plugin = registry.plugin_class(group, name)
    hints = typing.get_type_hints(plugin)
    settings = [(each.name, hints[each.name], _copied(each)) for each in own_fields(plugin)]
    named = dataclasses.make_dataclass("Named" + plugin.__name__, [*settings, ("name", str, name)])
    node = OmegaConf.structured(named)
    for setting in own_fields(plugin):
        if node[setting.name] == {}:  # names that the plugin alone knows
            OmegaConf.set_struct(node[setting.name], False)
    return node


def _copied(setting: dataclasses.Field[Any]) -> Any:
    """A field with the same default, for another dataclass."""
    if setting.default_factory is not dataclasses.MISSING:
        return field(default_factory=setting.default_factory)
    return field(default=setting.default)

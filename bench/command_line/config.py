"""What Hydra knows: the settings of a bench run and those of every registered plugin, typed."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any

from hydra.core.config_store import ConfigStore
from omegaconf import MISSING, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from ksmea import registry
from ksmea.errors import SettingError


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
    """A plugin's settings with their types, and its name so that a composed configuration says what was chosen."""
    settings = registry.plugin_class(group, name)
    named = dataclasses.make_dataclass(
        "Named" + settings.__name__, [("name", str, name)], bases=(settings,), frozen=True, kw_only=True
    )
    node = OmegaConf.structured(named)
    OmegaConf.set_readonly(node, None)  # a frozen dataclass would refuse every override
    for setting in dataclasses.fields(settings):
        if node[setting.name] == {}:  # names that the plugin alone knows
            OmegaConf.set_struct(node[setting.name], False)
    return node

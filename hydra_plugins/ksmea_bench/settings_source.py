"""Hydra's source of what is registered.

The bench's own settings, and those of each plugin under its group and name.

A plugin is imported when its schema is composed: one that nobody chooses never is.
"""

from __future__ import annotations

from hydra.core.config_search_path import ConfigSearchPath
from hydra.core.config_store import ConfigStore
from hydra.core.object_type import ObjectType
from hydra.plugins.config_source import ConfigResult, ConfigSource
from hydra.plugins.search_path_plugin import SearchPathPlugin
from omegaconf import DictConfig, OmegaConf

from bench.command_line.bench_settings import default_plugins
from bench.command_line.schema import bench_schema, plugin_schema
from bench.plan.folder import of_file
from bench.storage.own_files import CONF
from ksmea.errors import SettingError
from ksmea.plugins import registry

PRIMARY, OF_BENCH = "config", "bench_schema"
HYDRA = {  # Hydra's own settings, by which all experiments are planned
    "mode": "MULTIRUN",
    "output_subdir": None,
    "sweep": {"dir": "${output}", "subdir": "."},
}
LAUNCHER = "submitit_slurm"


class SettingsSource(ConfigSource):
    """Schemas by name: `config`, which Hydra begins with, and GROUP/PLUGIN."""

    @staticmethod
    def scheme() -> str:
        return "ksmea"

    def available(self) -> bool:
        return True

    def is_group(self, config_path: str) -> bool:
        return config_path in registry.GROUPS

    def is_config(self, config_path: str) -> bool:
        group, _, name = config_path.removesuffix(".yaml").rpartition("/")
        return name in (
            registry.registered(group) if group in registry.GROUPS else () if group else (PRIMARY, OF_BENCH)
        )

    def list(self, config_path: str, results_filter: ObjectType | None) -> list[str]:
        return [] if results_filter == ObjectType.GROUP else sorted(registry.registered(config_path))

    def load_config(self, config_path: str) -> ConfigResult:
        group, _, name = config_path.removesuffix(".yaml").rpartition("/")
        config = _of_plugin(group, name) if group else bench_schema() if name == OF_BENCH else _primary()
        return ConfigResult(self.provider, self.full_path(), config.copy(), {"package": None})


class OnSearchPath(SearchPathPlugin):
    """Put the source behind the folders with files on Hydra's search path.

    It also gives Hydra the conf's ${of_file:…} and the bench's own launcher.
    """

    def manipulate_search_path(self, search_path: ConfigSearchPath) -> None:
        search_path.append("ksmea_bench", f"{SettingsSource.scheme()}://")
        OmegaConf.register_new_resolver("of_file", of_file, replace=True)
        launcher = OmegaConf.load(
            CONF / f"{LAUNCHER}.yaml"
        )  # in place of the one of this name that comes with submitit's plugin
        ConfigStore.instance().store(group="hydra/launcher", name=LAUNCHER, node=launcher, provider="ksmea_bench")


def _of_plugin(group: str, name: str) -> DictConfig:
    """The schema of a plugin.

    Its bare name where it is broken, so that it is refused only where it is chosen.
    """
    try:
        return plugin_schema(group, name)
    except SettingError:
        return OmegaConf.create({"name": name})


def _primary() -> DictConfig:
    """First settings and plugins of Hydra, if nothing is chosen, its sweeper, and no logs of its own."""
    chosen = [{group: name} for group, name in default_plugins().items()]
    own = {"sweeper": "plan", "hydra_logging": "none", "job_logging": "none"}
    defaults = [OF_BENCH, *chosen, "_self_", *({f"override hydra/{key}": name} for key, name in own.items())]
    return OmegaConf.create({"defaults": defaults, "hydra": HYDRA})

"""Configurations at the points of a grid: one Hydra composition per choice of plugins, then updates.

Plain values are typed updates of a composition. A setting that the command line gives with a list of plugins goes to
each plugin that has it. A composition takes 0.1 s, so each list of words is composed once.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

from hydra.core.config_loader import ConfigLoader
from hydra.core.override_parser.types import OverrideType
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf, open_dict

from bench.command_line.grid import Block, each_once, grid_blocks, labelled, listed
from bench.command_line.overrides import Choice, override
from bench.command_line.plugin_settings import PluginSetting, names_plugin, plugin_setting, short, unknown_key
from bench.command_line.schema import plugin_schema
from bench.plan.left_out import why_unusable
from ksmea.errors import SettingError
from ksmea.plugins import registry
from ksmea.settings.settings import own_fields

LINES = ("grid", "add", "cross")  # settings of an experiment that hold lines of its grid
REFERENCE = re.compile(rf"\$\{{[^}}]*\b({'|'.join(('hydra', *LINES))})\b")  # to Hydra's own part, or to those lines


class Composer:
    """Configurations of one experiment.

    `fixed` is what the command line gives one value, `swept` what it gives several; `labels` are of the lines of the
    grid that it chooses (none: all).
    """

    def __init__(
        self,
        compositions: Compositions,
        fixed: Iterable[Choice],
        swept: Mapping[str, Sequence[Any]],
        labels: Sequence[Any] = (),
    ) -> None:
        self._compositions = compositions
        self._fixed = sorted(fixed, key=lambda choice: names_plugin(choice.key))  # which says more, and comes last
        self._swept = swept
        self._labels = labels
        self._at_plugins: dict[tuple[str, ...], DictConfig] = {}
        self._lent: dict[tuple[str, ...], tuple[set[str], DictConfig]] = {}

    @cached_property
    def outline(self) -> DictConfig:
        """The experiment without the settings that the command line gives plugins.

        It has the included files, the grid, and the plugins if the grid names none.
        """
        return self._compositions.of(choice.word for choice in self._fixed if not _of_plugin(choice))

    @cached_property
    def blocks(self) -> list[Block]:
        """The blocks of the experiment's grid, of the chosen labels alone where some are chosen."""
        lines: Any = (OmegaConf.to_container(self.outline[key]) for key in LINES)
        blocks = grid_blocks(*lines)
        return labelled(blocks, self._labels) if self._labels else blocks

    @cached_property
    def whole(self) -> DictConfig:
        """The experiment with all settings of those plugins."""
        return self.at({}).copy()

    def own(self, points: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
        """The points, each once, as a configuration knows them.

        They have the settings of the plugins chosen there. A setting that names its plugin takes precedence over one
        that does not, and the command line over the grid.
        """
        return each_once(self._own(point) for point in points)

    def _own(self, point: Mapping[str, Any]) -> dict[str, Any]:
        """One point as a configuration knows it."""
        groups = {key: value for key, value in point.items() if key in registry.GROUPS}
        left = {key: value for key, value in point.items() if self._is_meant(key, groups)}
        fixed = {short(each.key) for each in self._fixed if names_plugin(each.key) and self._concerns(each, groups)}
        return {
            short(key): value
            for key, value in sorted(left.items(), key=lambda item: names_plugin(item[0]))
            if names_plugin(key) or key not in fixed
        }

    def at(self, point: Mapping[str, Any]) -> DictConfig:
        """The configuration at one point: {setting or group: value}.

        It is lent until the next call, which changes it: a copy takes longer than the settings of a point.
        """
        groups = {key: value for key, value in point.items() if key in registry.GROUPS}
        overrides = (
            *self._standard(groups),
            *(choice.word for choice in self._fixed if self._concerns(choice, groups)),
            *(f"{group}={name}" for group, name in groups.items()),
        )
        if overrides not in self._at_plugins:
            self._at_plugins[overrides] = self._without_large_parts(self._compositions.of(overrides))
        own = {key: value for key, value in point.items() if key not in groups}
        keys, config = self._lent.get(overrides, (None, self._at_plugins[overrides]))
        if keys != set(own) or any(isinstance(value, Mapping) for value in own.values()):  # these would be merged
            config = self._at_plugins[overrides].copy()
            self._lent[overrides] = set(own), config
        for key, value in own.items():
            OmegaConf.update(config, key, value, merge=True)
        return config

    def _without_large_parts(self, composed: DictConfig) -> DictConfig:
        """Configuration that is quickly copied for each point; `SettingError` if a plugin cannot be offered.

        It lacks the lines of the grid, which have become the points, and Hydra's own part. If a setting takes a value
        from one of these, the configuration is returned whole.
        """
        for group in registry.GROUPS:
            plugin_schema(group, composed[group].name)
        config = composed.copy()
        with open_dict(config):
            for key in ("hydra", *LINES):
                del config[key]
            if REFERENCE.search(OmegaConf.to_yaml(config)) or REFERENCE.search(str([self.blocks, self._swept])):
                return composed
            for key in LINES:
                config[key] = []
        return config

    def _concerns(self, choice: Choice, groups: Mapping[str, str]) -> bool:
        """Whether a fixed choice applies at a point: a plugin's setting only if the plugin there has it."""
        return not _of_plugin(choice) or self._has(choice.key, groups)

    def _standard(self, groups: Mapping[str, str]) -> Iterable[str]:
        """Settings of the experiment for the plugins chosen at a point, as far as they have them."""
        standard = {**self.compared, **self.outline.standard}
        for key, value in sorted(standard.items(), key=lambda item: names_plugin(item[0])):
            said = plugin_setting(key)
            if said is None or "." in said.setting:
                raise SettingError(f"expected GROUP.SETTING or GROUP.PLUGIN.SETTING, got {key}", setting="standard")
            if said.plugin is not None:
                _require_setting(said.group, said.plugin, said.setting)
            chosen = groups.get(said.group, self.outline[said.group].name)
            if _names(said, chosen) and said.setting in _settings(said.group, chosen):
                yield override(said.short, value)

    @cached_property
    def compared(self) -> Mapping[str, Any]:
        """Settings that leave optimisers as they are where the command line sweeps them.

        A local search after each would end at one optimum, whichever came before it. What is given stays.
        """
        if len(self._swept.get("optimizer", ())) < 2:
            return {}
        given = {short(each.key) for each in self._fixed} | {short(key) for key in self._swept}
        blocks = {short(key) for block in self.blocks for key in block}
        return {key: False for key in AFTER_SEARCH if key not in given | blocks}

    def _is_meant(self, key: str, groups: Mapping[str, str]) -> bool:
        """Whether a key of the grid or of a sweep is for a point.

        A setting of a plugin counts if the plugin is swept or named, and the one chosen at the point has it.
        """
        said = plugin_setting(key)
        if said is None:
            return True
        if key in self._swept:
            return self._has(key, groups)
        if said.plugin is not None:
            _require_setting(said.group, said.plugin, said.setting.partition(".")[0])
        return _names(said, groups.get(said.group, self.outline[said.group].name))

    def _has(self, key: str, groups: Mapping[str, str]) -> bool:
        """Whether a setting on the command line is one of the plugin chosen at a point.

        One that none of the chosen has, or of a plugin that is not chosen, is refused.
        """
        said = plugin_setting(key)
        if said is None:
            return True
        group, setting = said.group, said.setting.partition(".")[0]
        names = self._alternatives[group]
        chosen = groups.get(group, self.outline[group].name)
        plugin_schema(group, chosen)
        if said.plugin is not None:
            if said.plugin not in names:
                raise SettingError(
                    f"expected a setting of what is chosen, {group}={','.join(names)}, got one of {said.plugin}; choose"
                    " it too, or leave its settings out",
                    setting=key,
                )
            _require_setting(group, said.plugin, setting)
            return said.plugin == chosen
        known = {name: _settings(group, name) for name in names if not why_unusable(group, name)}
        if not any(setting in settings for settings in known.values()):
            plugins = (
                registry.registered(group) if setting != said.setting else ()
            )  # more of a path: a plugin's name, perhaps
            offered = {each for settings in known.values() for each in settings}
            raise unknown_key(f"{group}.{setting}", {*offered, *plugins})
        return setting in known.get(chosen, ())

    @cached_property
    def _alternatives(self) -> Mapping[str, list[str]]:
        """Names of the plugins that the experiment's points choose from, by group."""
        return {group: list(dict.fromkeys(self._chosen(group))) for group in registry.GROUPS}

    def _chosen(self, group: str) -> Iterable[str]:
        if group in self._swept:
            yield from self._swept[group]
            return
        is_fixed = any(choice.key == group for choice in self._fixed)  # and has left the grid
        for block in [{}] if is_fixed else self.blocks:
            yield from listed(block.get(group, self.outline[group].name))


AFTER_SEARCH = ("method.polish", "method.final_step")


def _of_plugin(choice: Choice) -> bool:
    """Whether it sets a setting of a plugin; one that is added (+) or deleted (~) goes through as it is."""
    return plugin_setting(choice.key) is not None and choice.override.type == OverrideType.CHANGE


def _names(said: PluginSetting, chosen: str) -> bool:
    """Whether a key is for a plugin: names it, or none."""
    return said.plugin in (None, chosen)


def _require_setting(group: str, plugin: str, setting: str) -> None:
    if why_unusable(group, plugin):
        return
    known = _settings(group, plugin)
    if setting not in known:
        raise unknown_key(f"{group}.{plugin}.{setting}", known)


def _settings(group: str, name: str) -> list[str]:
    return [field.name for field in own_fields(registry.plugin_class(group, name))]


class Compositions:
    """Configurations of one command. Who changes one makes a copy of it."""

    def __init__(self, loader: ConfigLoader, master: DictConfig) -> None:
        self._loader = loader
        self._name = master.hydra.job.config_name
        # Hydra hands the sweeper no overrides of its own, without this one experiments of other folders are not found.
        self._searched = [word for word in master.hydra.overrides.hydra if word.startswith("hydra.searchpath=")]
        self._composed: dict[tuple[str, ...], DictConfig] = {}

    def of(self, words: Iterable[str]) -> DictConfig:
        """The configuration with these overrides."""
        overrides = tuple(words)
        if overrides not in self._composed:
            self._composed[overrides] = self._loader.load_configuration(
                config_name=self._name, overrides=[*self._searched, *overrides], run_mode=RunMode.RUN
            )
        return self._composed[overrides]

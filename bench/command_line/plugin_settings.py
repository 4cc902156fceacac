"""Keys of plugins' settings.

GROUP.SETTING is a setting of the chosen plugin, GROUP.PLUGIN.SETTING one of one plugin among several.

An unknown key is answered with the nearest known one, or with the plugin that has it.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from bench.command_line.source_settings import source_settings
from ksmea.errors import SettingError, UnknownName, listed, unknown
from ksmea.plugins.names import GROUPS, registered


@dataclass(frozen=True)
class PluginSetting:
    """`plugin` is None if the key names none."""

    group: str
    plugin: str | None
    setting: str

    @property
    def short(self) -> str:
        """The key for whichever plugin is chosen, which is what a configuration knows."""
        return f"{self.group}.{self.setting}"


def plugin_setting(key: str) -> PluginSetting | None:
    """Group, plugin and setting that a key names; None if the key is not a plugin's setting.

    >>> plugin_setting("optimizer.lm.screening")
    PluginSetting(group='optimizer', plugin='lm', setting='screening')
    >>> plugin_setting("problem.limits.kxx")
    PluginSetting(group='problem', plugin=None, setting='limits.kxx')
    """
    group, _, setting = key.partition(".")
    if group not in GROUPS or not setting:
        return None
    plugin, _, own = setting.partition(".")
    if own and plugin in registered(group):
        return PluginSetting(group, plugin, own)
    return PluginSetting(group, None, setting)


def short(key: str) -> str:
    """A key as a configuration knows it.

    >>> short("optimizer.lm.screening"), short("samples")
    ('optimizer.screening', 'samples')
    """
    said = plugin_setting(key)
    return key if said is None else said.short


def names_plugin(key: str) -> bool:
    """Whether a key says of which plugin it sets a setting."""
    said = plugin_setting(key)
    return said is not None and said.plugin is not None


def unknown_key(key: str, names: Iterable[str]) -> SettingError:
    """The error for a setting that is not one of `names`, the nearest of them first."""
    parent, dot, name = key.rpartition(".")
    known = sorted(names)
    others = [] if name in known else [f"{parent}={other}" for other in plugins_with(parent, name)]
    if not others:
        return unknown("setting", name, known, within=f"{parent}{dot}")
    return SettingError(
        f"unknown setting '{key}'; {' and '.join(others)} {'has' if len(others) == 1 else 'have'} it, what is chosen has"
        f" not; choose that, or leave it out; known: {listed(known)}",
        meant=UnknownName("setting", key, owner=others[0] if len(others) == 1 else ""),
    )


def plugins_with(group: str, setting: str) -> list[str]:
    """The plugins of a group whose source has a setting; none if it is not a group."""
    names = registered(group) if group in GROUPS else ()
    return [name for name in names if setting in (source_settings(group, name) or ())]

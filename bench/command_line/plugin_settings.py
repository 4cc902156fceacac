"""Keys of plugins' settings: GROUP.SETTING of whichever plugin is chosen, GROUP.PLUGIN.SETTING of one of them."""

from __future__ import annotations

from dataclasses import dataclass

from ksmea.plugin_names import GROUPS, registered


@dataclass(frozen=True)
class PluginSetting:
    """`plugin` is None where the key names none."""

    group: str
    plugin: str | None
    setting: str

    @property
    def short(self) -> str:
        """The key for whichever plugin is chosen, which is what a configuration knows."""
        return f"{self.group}.{self.setting}"


def plugin_setting(key: str) -> PluginSetting | None:
    """What a key says of a plugin; None where it is none of a plugin's setting.

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

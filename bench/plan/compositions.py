"""What Hydra composes of words, each list of words once: a composition takes 0.1 s."""

from __future__ import annotations

from collections.abc import Iterable

from hydra.core.config_loader import ConfigLoader
from hydra.types import RunMode
from omegaconf import DictConfig


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

"""The settings of the bench itself: their types, and what conf/config.yaml says of each."""

from __future__ import annotations

import re
import typing
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

from bench.storage.own_files import CONF

MISSING: Any = "???"  # OmegaConf's mark for what a configuration file has to give
LINE = re.compile(r"^(\w+): *(.*?) +# (.*)$", re.MULTILINE)
DEFAULT_PLUGIN = re.compile(r"^ +- (\w+): (\w+)$", re.MULTILINE)


@dataclass
class BenchConfig:
    """Settings of the bench itself; the six groups hold plugins. conf/config.yaml has the values and remarks."""

    name: str = MISSING
    plugins: list[str] = field(default_factory=list)
    samples: int = MISSING
    repetitions: int = MISSING
    seed: int = MISSING
    own_seeds: str | None = None
    workers: int | None = None
    timeout: float | None = None
    memory: float | None = None
    journal: bool = False
    share: list[str] = field(default_factory=list)
    output: str = MISSING
    batches: int = MISSING
    batch: int = MISSING
    wait: bool = True
    label: str | None = None
    table: str | None = None
    paper: str | None = None
    figures: list[str] = field(default_factory=list)
    exact: float | None = None
    includes: list[str] = field(default_factory=list)
    standard: dict[str, Any] = field(default_factory=dict)
    grid: list[dict[str, Any]] = field(default_factory=list)
    add: list[dict[str, Any]] = field(default_factory=list)
    cross: list[dict[str, Any]] = field(default_factory=list)
    problem: Any = MISSING
    measurement: Any = MISSING
    surrogate: Any = MISSING
    optimizer: Any = MISSING
    method: Any = MISSING
    study: Any = MISSING


class Remark(NamedTuple):
    """A setting's default as conf/config.yaml writes it, and what it says of it."""

    default: str
    help: str


@cache
def bench_settings() -> dict[str, Any]:
    """The types of the bench's own settings by name; the six groups of plugins among them have none."""
    return typing.get_type_hints(BenchConfig)


@cache
def remarks() -> dict[str, Remark]:
    """Default and meaning of the bench's own settings by name."""
    return {name: Remark(default, said) for name, default, said in LINE.findall(_config())}


@cache
def default_plugins() -> dict[str, str]:
    """The plugin of each group that is taken where nothing is chosen."""
    return dict(DEFAULT_PLUGIN.findall(_config().partition("_self_")[0]))


def _config() -> str:
    return (CONF / "config.yaml").read_text(encoding="utf-8")

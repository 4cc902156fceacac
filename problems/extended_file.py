"""A problem extended by effects, described in a YAML file.

`problem=extended problem.file=extended.yaml`.

    problem: {name: three_disk, mesh: 13, sensors: [0.1, 0.5]}  # any problem with its settings
    effects:                                                     # python -m bench help effect
      - {name: runout, position: 0.1}
    reference: {kxx: 50.0, runout_x: 8.0}  # may be left out: else the problem's own values, and 0 for effects
    phase_origin: true                     # may be left out: whether the phase of the data begins anywhere

Reference values are in the units of the unknowns.
"""

from __future__ import annotations

import dataclasses
import hashlib
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ksmea.errors import SettingError, unknown
from ksmea.plugins import registry
from ksmea.plugins.effect import AnyEffect
from ksmea.plugins.source import ProblemSettings
from ksmea.problem.problem import Problem
from ksmea.settings.document import Block, inside
from ksmea.settings.settings import Settings, setting
from ksmea.settings.strict_yaml import parse, read_bytes
from ksmea.settings.types import TRUTHS, read_as

NESTED = "extended"  # the name that this problem is registered under


@dataclass(frozen=True)
class ExtendedFile(ProblemSettings):
    """Problem extended by effects that its baseline model lacks, from a YAML file.

    A diagnosis writes such a file.

    The file is read once, when it is first needed; a relative path starts at the working directory.
    """

    file: str = setting("", "the file: problem, effects and, where wanted, reference values and phase_origin")
    mesh: int | None = setting(
        None, "number of shaft elements of the problem in the file; null: as the file says", at_least=1
    )

    def check(self) -> None:
        if not self.file:
            raise SettingError(
                "file: expected the YAML file of an extended problem, got none; give problem.file=extended.yaml"
            )
        self._built  # noqa: B018 – reading is checking

    def build(self) -> Problem:
        """The problem with its effects."""
        return self._built

    def reference(self) -> dict[str, float]:
        """Reference values, SI: of the file, else of the baseline problem, else 0.

        Effects and the phase origin add unknowns whose value is 0 if the file has none.
        """
        units = {parameter.name: parameter.si_per_unit for parameter in self._built.parameters}
        own = self._settings.build().parameters.names
        given = {name: value * units[name] for name, value in self._given.items()}
        added = {name: 0.0 for name in units if name not in own}
        return {**self._settings.reference(), **added, **given}

    def fingerprint(self) -> str:
        """Hash of what the settings name but do not hold.

        The content of the file, and of a file that it names.
        """
        return hashlib.sha256(self._content + self._settings.fingerprint().encode()).hexdigest()[:16]

    @staticmethod
    def document(
        name: str,
        settings: Mapping[str, Any],
        effects: Sequence[tuple[str, AnyEffect]],
        reference: Mapping[str, float],
        phase_origin: bool = False,
    ) -> str:
        """The YAML of a problem, by registered name and settings, with effects, by name and location.

        Reference values are in the units of the unknowns. A file that the settings name is written with its full path. A
        problem that is extended already becomes one with all the effects, its own reference values where none are given.
        """
        settings = {key: value for key, value in settings.items() if key != NAME}
        if name == NESTED:
            return _further_extended(ExtendedFile(**settings), effects, reference, phase_origin)
        if isinstance(settings.get("file"), str) and settings["file"]:
            settings["file"] = str(Path(settings["file"]).absolute())
        return _dumped({NAME: name, **settings}, [_described(*pair) for pair in effects], reference, phase_origin)

    @property
    def parts(self) -> Sequence[Settings]:
        """The problem that the effects extend, and the effects."""
        return (self._settings, *self._effects)

    @cached_property
    def _content(self) -> bytes:
        return read_bytes(self.file)

    @cached_property
    def _document(self) -> Block:
        document = Block.of_document(self.file, parse(self._content, self.file))
        document.check_keys(["problem", "effects"], ["reference", "phase_origin"])
        return document

    @cached_property
    def _settings(self) -> ProblemSettings:
        """Settings of the baseline problem."""
        block = self._document.block("problem")
        if block.values.get(NAME) == NESTED:
            raise block.error(
                NAME, "expected a problem without effects, got an extended one; list all effects in one file"
            )
        if self.mesh is not None:
            block = dataclasses.replace(block, values={**block.values, "mesh": self.mesh})
        return plugin_of(block, "problem")

    @cached_property
    def _effects(self) -> tuple[AnyEffect, ...]:
        return tuple(plugin_of(block, "effect") for block in self._effect_blocks)

    @cached_property
    def _effect_blocks(self) -> Sequence[Block]:
        return [] if self._document.values["effects"] == [] else self._document.blocks("effects")

    @cached_property
    def _has_phase_origin(self) -> bool:
        if "phase_origin" not in self._document.values:
            return False
        return TRUTHS[self._document.choice("phase_origin", "value", TRUTHS)]

    @cached_property
    def _built(self) -> Problem:
        problem = self._settings.build()
        for block, effect in zip(self._effect_blocks, self._effects):
            problem = inside(block, "", partial(effect.added_to, problem))
        if self._has_phase_origin:
            if not problem.can_leave_phase_open:
                raise self._document.error("phase_origin", "expected a problem whose phase may begin anywhere")
            problem = problem.with_phase_origin()
        self._check_reference(problem)
        return problem

    @cached_property
    def _given(self) -> dict[str, float]:
        """Reference values of the file, in the units of the unknowns."""
        if self._document.values.get("reference") in (None, {}):
            return {}
        block = self._document.block("reference")
        return {str(key): block.number(key) for key in block.values}

    def _check_reference(self, problem: Problem) -> None:
        names = problem.parameters.names
        for name in self._given:
            if name not in names:
                raise self._document.error("reference", unknown("parameter", name, names))


def _further_extended(
    inner: ExtendedFile, effects: Sequence[tuple[str, AnyEffect]], reference: Mapping[str, float], phase_origin: bool
) -> str:
    block = inner._document.block("problem")
    settings = {field.name: getattr(inner._settings, field.name) for field in dataclasses.fields(inner._settings)}
    names = [block.values[NAME] for block in inner._effect_blocks]
    before = list(zip(names, inner._effects))
    values = {**inner._given, **reference}
    return ExtendedFile.document(
        block.values[NAME], settings, [*before, *effects], values, phase_origin or inner._has_phase_origin
    )


def _described(name: str, effect: AnyEffect) -> dict[str, Any]:
    """An effect as its name and its settings that differ from the default."""
    default = registry.create("effect", name, {})
    fields = [field.name for field in dataclasses.fields(effect)]
    differing = {key: getattr(effect, key) for key in fields if getattr(effect, key) != getattr(default, key)}
    return {NAME: name, **differing}


def _dumped(problem: Mapping[str, Any], effects: Sequence[Any], reference: Mapping[str, float], origin: bool) -> str:
    document: dict[str, Any] = {
        "problem": problem,
        "effects": effects,
        "reference": {name: float(value) for name, value in reference.items()},
    }
    if origin:
        document["phase_origin"] = True
    return yaml.safe_dump(_plain(document), sort_keys=False, default_flow_style=None, width=120, allow_unicode=True)


def _plain(value: Any) -> Any:
    """Mappings, lists and numbers of any kind as the plain ones of YAML."""
    if isinstance(value, Mapping):
        return {str(key): _plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(entry) for entry in value]
    return value.item() if isinstance(value, np.generic) else value


NAME = "name"


def plugin_of(block: Block, group: str) -> Any:
    """The plugin that a block names, with its settings checked for their types as well."""
    name = block.choice(NAME, group, registry.registered(group))
    plugin = inside(block, "", lambda: registry.plugin_class(group, name))
    hints = typing.get_type_hints(plugin)
    known = [field.name for field in dataclasses.fields(plugin)]
    settings = {}
    for key, value in block.values.items():
        if key == NAME:
            continue
        if key not in known:
            raise block.error("", unknown(f"setting of {group}={name}:", str(key), known))
        settings[key] = inside(block, key, partial(read_as, value, hints[key]))
    return inside(block, "", lambda: registry.create(group, name, settings))

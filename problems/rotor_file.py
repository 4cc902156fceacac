"""Anyone's rotor, described in a YAML file: `problem=rotor problem.file=my_rotor.yaml`.

docs/examples/rotor.yaml is such a file with remarks on every key, docs/examples/machine.yaml one with tables, supports and more.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from ksmea.errors import SettingError
from ksmea.plugins.source import ProblemSettings
from ksmea.settings.document import Block
from ksmea.settings.settings import setting
from ksmea.settings.strict_yaml import parse, read_bytes
from problems.rotor.inputs.tolerances import TOLERANCES
from problems.rotor.response.problem import RotorProblem
from problems.rotor_document.description import RotorDescription, read_description
from problems.rotor_document.tables import RotorSheets
from problems.rotor_settings import MAX_ELEMENTS

OF_OTHERS = (".toml", ".json")  # names of models of other programs


@dataclass(frozen=True)
class RotorFile(ProblemSettings):
    """A rotor described in a YAML file.

    Shaft, disks, bearings, unbalance, probes, speeds, and what is unknown.

    The file is read once, when it is first needed; a relative path starts at the working directory.
    """

    file: str = setting(
        "", "the file; docs/examples/rotor.yaml shows its keys, docs/examples/machine.yaml further ones"
    )
    mesh: int | None = setting(
        None,
        "number of shaft elements in all, shared by length over the file's segments; null: as the file says",
        at_least=1,
        at_most=MAX_ELEMENTS,
    )

    tolerances: str = setting(
        "",
        "of numbers that the file states without: typical (docs/tolerances.md), or none, which drops stated ones too;"
        " empty: as the file says",
        choices=("", *TOLERANCES),
    )

    def check(self) -> None:
        if not self.file:
            raise SettingError(
                "file: expected the YAML file of a rotor, got none; give problem.file=my_rotor.yaml,"
                " for example a copy of docs/examples/rotor.yaml"
            )
        self._description  # noqa: B018 – reading is checking

    def build(self) -> RotorProblem:
        """The problem; its rotor carries no values of the unknowns."""
        return self._description.problem

    def reference(self) -> dict[str, float]:
        """The reference values in the file, SI; an unknown without one has none here."""
        return dict(self._description.reference)

    def fingerprint(self) -> str:
        """Hash of what the settings name but do not hold.

        The content of the file, then of each table that it names, next to its path from there. A changed file is
        another problem.
        """
        tables = {word.partition("#")[0]: _hash(held) for word, held in self._description.tables.items()}
        return "; ".join([_hash(self._content), *(f"{content} {path}" for path, content in tables.items())])

    @cached_property
    def _content(self) -> bytes:
        return read_bytes(self.file)

    @cached_property
    def _document(self) -> Block:
        try:
            return Block.of_document(self.file, parse(self._content, self.file))
        except SettingError as error:
            if Path(self.file).suffix.lower() not in OF_OTHERS:
                raise
            raise SettingError(
                f"{error}; a model of another program is made into a rotor file by python -m bench import rotor"
            ) from error

    @cached_property
    def _description(self) -> RotorDescription:
        document = self._document
        if self.tolerances == "typical" and "tolerances" not in document.values:
            document = replace(document, values={**document.values, "tolerances": self.tolerances})
        found = read_description(document, self.mesh, RotorSheets(Path(self.file).parent))
        return replace(found, problem=found.problem.as_stated) if self.tolerances == "none" else found


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]

"""The extended model that a diagnosis names, as the YAML file that `problem=extended` reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ksmea import registry
from ksmea.errors import visible
from ksmea.records.diagnosis import DiagnosisRecord

EXPLAINED = ("named", "ambiguous")  # verdicts with effects that an extended model has


def extended_yaml(name: str, settings: Mapping[str, Any], record: DiagnosisRecord, remarks: Sequence[str]) -> str:
    """The file of the extended model, its estimates as reference values; empty where the verdict names no effect.

    `name` and `settings` are those of the problem that was diagnosed, `remarks` what the file says of itself in its first
    lines (`ksmea.show.diagnosis.about_extension`).
    """
    if not record.applied or record.verdict not in EXPLAINED:
        return ""
    values = {row.name: row.after.value for row in record.coefficients if row.after is not None}
    effects = [(effect.name, registry.create("effect", effect.name, effect.settings)) for effect in record.applied]
    extended: Any = registry.plugin_class("problem", "extended")  # knows the form of its own file
    document: str = extended.document(name, settings, effects, values, "phase_origin" in values)
    return "".join(f"# {visible(remark)}\n" for remark in remarks) + document

"""Extended model of a diagnosis or a location, as the YAML file that `problem=extended` reads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ksmea.errors import visible
from ksmea.measurement.campaign import is_weight, shared_name
from ksmea.plugins import registry
from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.extension import EffectRecord
from ksmea.records.location import LocationRecord

EXPLAINED = ("named", "ambiguous")  # verdicts with effects that an extended model has


def extended_yaml(name: str, settings: Mapping[str, Any], record: DiagnosisRecord, remarks: Sequence[str]) -> str:
    """YAML file of the extended model, with its estimates; empty if no effect is named or located.

    `name` and `settings` describe the diagnosed problem. `remarks` are the first lines of the file, as comments
    (`ksmea.show.diagnosis_text.about_extension`). The estimates are its reference values.
    """
    if record.verdict == "located" and record.location is not None:
        return located_yaml(name, settings, record.location, remarks)
    if not record.applied or record.verdict not in EXPLAINED:
        return ""
    values = {row.name: row.after.value for row in record.coefficients if row.after is not None}
    return _document(name, settings, record.applied, values, remarks)


def located_yaml(name: str, settings: Mapping[str, Any], record: LocationRecord, remarks: Sequence[str]) -> str:
    """YAML file of the model with the located force.

    Empty if no law holds at its site, and if the cause is spread over the shaft: a law at one site cannot be its model.

    `remarks` are as in `extended_yaml` (`ksmea.show.location_text.about_extension`).
    """
    extension = record.extension
    if extension is None or record.is_spread:
        return ""
    return _document(name, settings, [extension.effect], extension.values, remarks)


def _document(
    name: str,
    settings: Mapping[str, Any],
    applied: Sequence[EffectRecord],
    values: Mapping[str, float],
    remarks: Sequence[str],
) -> str:
    of_machine: dict[str, float] = {}
    for unknown, value in values.items():  # of what each run has of its own, that of the first run
        if not is_weight(unknown):
            of_machine.setdefault(shared_name(unknown), value)
    effects = [(effect.name, registry.create("effect", effect.name, effect.settings)) for effect in applied]
    extended: Any = registry.plugin_class("problem", "extended")  # knows the form of its own file
    document: str = extended.document(name, settings, effects, of_machine, "phase_origin" in of_machine)
    return "".join(f"# {visible(remark)}\n" for remark in remarks) + document

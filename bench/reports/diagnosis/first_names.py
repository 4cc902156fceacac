"""The cause that a diagnosis names first on a machine whose numbers are known to a tolerance.

A wrong number of the rotor file comes out in one of two ways: as an effect of the library, or, if the joint model explains the data, as
the number that these contradict most.
"""

# Shorter than 40 lines: the one meaning of a name that comes first.

from __future__ import annotations

import re

from ksmea.records.diagnosis import DiagnosisRecord
from ksmea.records.inputs import InputRecord

# Effects that are wrong numbers, by the names that such numbers have (problems/rotor/inputs/tolerances.py)
EFFECT_OF_NUMBER = (
    (r".+_youngs_modulus", "youngs_modulus"),
    (r".+_density", "mass"),
    (r"disk_\d+_mass", "disk_mass"),
    (r"disk_\d+_inertia", "disk_inertia"),
    (r"disk_\d+_position", "disk_position"),
    (r"bearing_\d+_position", "bearing_position"),
    (r"probe_position_at_.+", "probe_position"),
    (r"(plane_)?gain_.*at_.+", "channel_gain"),
    (r"direction_.+", "probe_rotation"),
)


def first_names(record: DiagnosisRecord) -> tuple[str, ...]:
    """Effects of the first explanation, or the one that the number with the largest contradicted pull is."""
    if record.explanations:
        return tuple(sorted(effect.name for effect in record.explanations[0].effects))
    contradicted = [each for each in record.inputs if each.is_contradicted]
    return (_effect_of(max(contradicted, key=lambda each: abs(each.pull))),) if contradicted else ()


def _effect_of(number: InputRecord) -> str:
    """The effect that is a wrong value of this number, or else the number's own name."""
    return next((effect for name, effect in EFFECT_OF_NUMBER if re.fullmatch(name, number.name)), number.name)

"""An absorber on the shaft and masses of all bearings, hidden in data of the dense solver and a finer mesh, are named with their sizes."""

import dataclasses

import numpy as np
import pytest

from ksmea.measurement.measurement import Measurement, observe
from ksmea.measurement.noise import Noise
from ksmea.plugins import registry
from ksmea.problem.case import Case
from ksmea.studies.diagnose import DiagnosisOptions, diagnosis
from ksmea.studies.library import library
from tiers import mostly_slow
from tolerant_pump import pump, true_values

RIVALS = ("spring_mass", "bearing_mass", "added_mass", "mass", "speed_dependent_stiffness")
QUICK = DiagnosisOptions(locate=False, average=False, split=False, screening=512, starts=4)
NOISE = Noise(0.03, 1e-7)
HIDDEN = {  # settings and values of the unknowns, SI
    "spring_mass": ({"position": 0.85}, [1.5, 2 * np.pi * 60, 0.1]),  # a resonance as wide as two steps of the speed
    "bearing_mass": ({}, [4.0, 6.0]),
}


@pytest.mark.parametrize("name", mostly_slow(["bearing_mass", "spring_mass"], but=["bearing_mass"]))
def test_it_is_named_with_its_sizes(tmp_path, name):
    given, sizes = HIDDEN[name]
    settings = pump(tmp_path)
    problem = settings.build()
    fine = registry.create("effect", name, given).added_to(dataclasses.replace(settings, mesh=20).build())
    [response] = fine.dense_response(np.concatenate([true_values(settings), sizes])[None])
    values = observe(response, "complex", NOISE, np.random.default_rng(1))
    data = Measurement(problem.speed, problem.channels, values, NOISE, "made for a test")
    chosen, _ = library(RIVALS, [], data, problem)
    found = diagnosis(Case.of(problem, data), chosen, np.random.default_rng(0), options=QUICK)
    assert found.named == (name,), found.ambiguity_group
    [*parts] = next(each.parameters for each in found.ranking if each.effect == name)
    units = {"kg": 1.0, "Hz": 2 * np.pi, "%": 0.01}
    assert all(part.holds(size / units[part.unit]) for part, size in zip(parts, sizes, strict=True)), parts
    truth = settings.reference()
    units = {item.name: item.si_per_unit for item in problem.parameters}
    assert all(row.after.holds(truth[row.name] / units[row.name]) for row in found.coefficients if row.name in truth)

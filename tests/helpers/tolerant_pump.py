"""An overhung pump rotor as a file, with room for numbers that are not exact."""

import dataclasses

import numpy as np

from ksmea.measurement.measurement import Measurement
from ksmea.measurement.noise import Noise
from ksmea.problem.problem import joint_values
from problems.rotor_file import RotorFile

PUMP = """\
units: {{length: m, modulus: GPa, density: kg/m3, mass: kg, inertia: kg m2, stiffness: MN/m, damping: kN s/m, unbalance: g mm,
         angle: deg, speed: rpm}}
materials:
  steel: {{young_modulus: {modulus}, density: {density}, poisson_ratio: 0.29}}
shaft:
  - {{length: 0.12, outer_diameter: 0.045, material: steel, elements: 2}}
  - {{length: 0.43, outer_diameter: {diameter}, material: steel, elements: 4}}
  - {{length: 0.30, outer_diameter: 0.052, material: steel, elements: 4}}
disks:
  - {{position: 0.0, outer_diameter: 0.14, inner_diameter: 0.045, thickness: 0.03, material: steel}}
  - {{position: {disk}, mass: {mass}, polar_inertia: {polar}, diametral_inertia: {diametral}}}
bearings:
  - {{position: {bearing}, kxy: {cross}}}
  - {{position: 0.55}}
unbalance:
  - {{position: 0.85, phase: 0}}
speeds: {{from: 600, to: 7200, number: 23}}
probes:
  - {{position: {probe}, direction: x, gain: {gain}}}
  - {{position: {probe}, direction: {direction}}}
  - {{position: 0.51, direction: x}}
  - {{position: 0.51, direction: y}}
unknowns:
  - {{name: k1, lower: 5, upper: 200, reference: 45, sets: [bearing 1 kxx, bearing 1 kyy]}}
  - {{name: k2, lower: 5, upper: 200, reference: 36, sets: [bearing 2 kxx, bearing 2 kyy]}}
  - {{name: c, lower: 0.1, upper: 100, reference: 10, sets: [bearing 1 cxx, bearing 1 cyy, bearing 2 cxx, bearing 2 cyy]}}
  - {{name: u, lower: 5, upper: 500, reference: 60, sets: [unbalance 1 magnitude]}}
{more}
"""
EXACT = {
    "modulus": 205, "density": 7850, "diameter": 0.057, "disk": 0.85, "mass": 9.0, "bearing": 0.12, "cross": 0.5, "probe": 0.16,
    "gain": 1, "direction": "y", "polar": 0.06, "diametral": 0.033, "more": "",
}  # fmt: skip
UNCERTAIN = {
    "modulus": "{value: 205, sd: 2 %}",
    "density": "{value: 7850, sd: 80}",
    "diameter": "{value: 0.057, sd: 0.0002}",
    "disk": "{value: 0.85, sd: 0.003}",
    "mass": "{value: 9.0, sd: 1 %}",
    "bearing": "{value: 0.12, sd: 0.002}",
    "cross": "{value: 0.5, sd: 0.2}",
    "probe": "{value: 0.16, sd: 0.004}",
    "gain": "{value: 1, sd: 2 %}",
    "direction": "{value: y, sd: 2}",
}


def pump(folder, **changed):
    """The settings of the pump with some numbers given otherwise."""
    path = folder / "pump.yaml"
    path.write_text(PUMP.format(**EXACT | changed))
    return RotorFile(str(path))


def true_values(settings, **off):
    """Values (d,) SI of the joint problem's unknowns, some numbers off by so many standard deviations."""
    problem = settings.build()
    joint, reference = problem.joint, settings.reference()
    x = joint_values(problem, joint, np.array([reference[name] for name in problem.parameters.names]))
    for name, sizes in off.items():
        index = joint.parameters.names.index(name)
        x[index] += sizes * joint.parameters.items[index].prior.sd
    return x


def measured(settings, x, rng, relative=0.05, noise_known=True):
    """Data of a rotor with these values by the dense route and twice as many elements."""
    problem = settings.build()
    n_element = sum(segment.n_element for segment in problem.rotor.segments)
    fine = dataclasses.replace(settings, mesh=2 * n_element).build().joint
    [response] = fine.dense_response(x[None])
    parts = rng.standard_normal((2, *response.shape)) / np.sqrt(2)
    values = response + relative * np.abs(response) * (parts[0] + 1j * parts[1])
    noise = Noise(relative, 0.0) if noise_known else None
    return Measurement(problem.speed, problem.channels, values, noise=noise, source="made for a test")

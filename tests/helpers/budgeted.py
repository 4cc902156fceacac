"""Records of identifications of the three-disk rotor within a budget of evaluations."""

import numpy as np

from ksmea.plugins.identification import Streams
from ksmea.problem.case import Case
from ksmea.studies.identify import IdentificationOptions, identification
from measurements.synthetic import Synthetic
from problems.three_disk import ThreeDisk

SETTINGS = ThreeDisk(n_speed=11)


def record_of(method, budget, jacobian_cost=2, problem=None):
    problem = problem or SETTINGS.build()
    source, rng = Synthetic(relative=0.05), np.random.default_rng(0)
    measurement = source.measure(SETTINGS, SETTINGS.reference(), rng, rng)
    streams = Streams(*map(np.random.default_rng, range(3)))
    options = IdentificationOptions(intervals="none", crlb=False, budget=budget, jacobian_cost=jacobian_cost)
    return identification(Case(problem, measurement), method, streams, options)

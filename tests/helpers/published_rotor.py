"""The three-disk rotor with the coefficients of Table 1, and what is published of it."""

from problems.rotor.response.unknowns import rotor_at
from problems.three_disk import ThreeDisk

# Lalanne & Ferraris, Rotordynamics Prediction in Engineering: the example rotor, isotropic shaft on two bearings.
PUBLISHED_CRITICALS = {3620: 5e-4, 3798: 5e-4, 10018: 5e-4, 11279: 5e-4, 16785: 1.2e-3, 24400: 1.2e-3}  # rpm: tolerance


def published(mesh=13):
    """The three-disk rotor with the coefficients of Table 1."""
    settings = ThreeDisk(mesh=mesh)
    problem = settings.build()
    return rotor_at(problem.rotor, problem.unknowns, [settings.reference()[name] for name in problem.parameters.names])

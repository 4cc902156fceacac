"""Balancing without a rotor model.

Influence coefficients, unknown weights, corrections, and what does not fit.
"""

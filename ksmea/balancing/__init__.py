"""Balancing without a rotor model: influence coefficients, unknown weights, corrections, and what does not fit."""

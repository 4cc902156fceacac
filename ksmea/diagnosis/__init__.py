"""Diagnosis: what a model gets wrong about a measurement, and which physical cause would mend it."""

"""Measurements of this project beside what else there is.

Nothing of it is imported by the packages, and the wheel is without it.
"""

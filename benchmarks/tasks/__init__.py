"""Pieces of work that are timed.

A module imports one side's library alone, so that it can run where the others are not.
"""

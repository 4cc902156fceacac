"""Timing side by side.

Processes that answer timing requests, rows, pairs, tables, pages.
"""

"""Report of a contest: methods compared on instances of problems.

All methods have equal budgets of true-model evaluations.
"""

"""The report of a contest: methods compared on instances of problems, at equal budgets of true-model evaluations."""

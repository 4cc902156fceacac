"""A benchmark of benchopt whose runs do nothing.

`benchmarks.tasks.commands` times what is left of them.
"""

from benchopt import BaseObjective


class Objective(BaseObjective):
    name = "Nothing"
    min_benchopt_version = "1.5"

    def set_data(self, number):
        self.number = number

    def evaluate_result(self, number):
        return {"value": number}

    def get_one_result(self):
        return {"number": 0}

    def get_objective(self):
        return {"number": self.number}

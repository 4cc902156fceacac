"""A hundred solvers that return it."""

from benchopt import BaseSolver


class Solver(BaseSolver):
    name = "Nothing"
    sampling_strategy = "run_once"
    parameters = {"seed": list(range(100))}  # noqa: RUF012 – as benchopt asks for it

    def set_objective(self, number):
        self.number = number

    def run(self, _):
        pass

    def get_result(self):
        return {"number": self.number}

"""The optimiser several times on the true model.

A search that ends in one of several basins ends in the best of the basins it met.
"""

from dataclasses import dataclass, replace

from ksmea import Measurement, Method, Optimizer, Problem, setting
from ksmea.identification.direct import Direct
from ksmea.plugins.identification import Identification, Streams
from ksmea.settings.settings import part


@dataclass(frozen=True)
class SeveralStarts(Method):
    """Search the true model several times, each time with other random numbers, and keep the best."""

    optimizer: Optimizer = part("what searches the true model")
    starts: int = setting(3, "number of searches", at_least=1)

    def validate(self, problem: Problem) -> None:
        self.optimizer.check_dimension(len(problem.parameters))

    def identify(self, problem: Problem, measurement: Measurement, streams: Streams) -> Identification:
        search = Direct(self.optimizer)
        found = [search.identify(problem, measurement, streams) for _ in range(self.starts)]
        return replace(
            min(found, key=lambda each: each.misfit),
            model_evaluations=sum(each.model_evaluations for each in found),
            model_jacobians=sum(each.model_jacobians for each in found),
            seconds={part: sum(each.seconds[part] for each in found) for part in found[0].seconds},
        )

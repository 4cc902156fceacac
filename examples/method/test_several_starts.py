import numpy as np
from several_starts import SeveralStarts

import ksmea
from ksmea.identification.direct import Direct
from ksmea.plugins.identification import Streams
from ksmea.testing import check_method
from optimizers.de import DE
from optimizers.lm import LM

ROTOR = ksmea.load_problem("three_disk").problem
DATA = ksmea.synthetic_measurement(ksmea.load_problem("three_disk"), relative=0.05).measurement
SHORT = DE(population=5, generations=3)  # ends far from the minimum, elsewhere each time


def streams():
    return Streams(*np.random.default_rng(0).spawn(3))


test_exam = check_method.tests(SeveralStarts(LM(), starts=2))


def test_it_is_as_good_as_the_best_of_its_searches_and_counts_all_of_them():
    same = streams()
    alone = [Direct(SHORT).identify(ROTOR, DATA, same) for _ in range(4)]
    together = SeveralStarts(SHORT, starts=4).identify(ROTOR, DATA, streams())
    assert together.misfit == min(each.misfit for each in alone) < max(each.misfit for each in alone)
    assert together.model_evaluations == sum(each.model_evaluations for each in alone)

"""Bearing coefficients and unbalance of a rotor from its measured unbalance response.

    import ksmea

    rotor = ksmea.load_problem("three_disk", sensors=[0.1, 0.5, 1.0])  # or a YAML file
    data = ksmea.read_measurement("run_up.csv")                        # or synthetic_measurement(rotor, …)
    print(ksmea.identify(rotor, data))                                 # values with intervals
    print(ksmea.diagnose(rotor, data))                                 # what the model gets wrong, and why

Names are loaded when they are first used, so that importing the package costs next to nothing. `__init__.pyi` lists them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

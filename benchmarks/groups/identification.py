"""Identifications of the three-disk rotor from amplitudes with 10 % noise, each turn from data of another seed.

Quality is the root mean square over the five unknowns of the errors in units of their Cramér–Rao lower bounds, the median over turns.
"""

from __future__ import annotations

from benchmarks.groups import handed
from benchmarks.harness.row import HERE, PEERS, Contestant, Row

ERROR = "rms error of the unknowns (CRLB)"
HERE_METHOD, SCRIPT = "benchmarks.tasks.identify_here:method", "benchmarks.tasks.identify_script:run"
WITHOUT_SURROGATE = {"DE": "de", "PSO": "pso", "GA": "ga", "least squares from many starts": "lm"}
TABLE3 = 40, 100  # samples
AT_LEAST = 20.0  # times as fast as the script
ABOUT_SCRIPT = "no intervals; at most 20 updates"


def rows() -> list[Row]:
    return [_methods(), *(_script(samples) for samples in TABLE3), _rational()]


def _methods() -> Row:
    data = {"run_ups": handed.run_ups(), "settings": {}}
    ksmea = {**data, "name": "ksmea", "optimizer": "de", "surrogate": "kriging"}
    return Row(
        "identification",
        "methods, without intervals",
        (
            Contestant("KSMEA, Kriging of 100 samples and DE", HERE_METHOD, ksmea),
            *(
                Contestant(f"{label}, no surrogate", HERE_METHOD, {**data, "name": "direct", "optimizer": optimizer})
                for label, optimizer in WITHOUT_SURROGATE.items()
            ),
            Contestant(
                "rational surrogate of 40 samples, DE",
                HERE_METHOD,
                {**ksmea, "surrogate": "rational", "samples": 40},
            ),
        ),
        unit="identification",
        quality=ERROR,
        budget=40.0,
    )


def _script(samples: int) -> Row:
    data = {"run_ups": handed.run_ups(), "samples": samples}
    return Row(
        "identification",
        "a run of Table 3",
        (
            Contestant("here, with intervals and CRLB", "benchmarks.tasks.identify_here:run_of_table3", data),
            Contestant(
                "script: scikit-learn, scipy DE, numpy.linalg.solve",
                SCRIPT,
                {**data, "model": "numpy"},
                "scikit-learn",
                HERE,
                AT_LEAST,
                ABOUT_SCRIPT,
            ),
            Contestant(
                "script: scikit-learn, scipy DE, ROSS",
                SCRIPT,
                {**data, "model": "ROSS"},
                "ross-rotordynamics",
                PEERS,
                AT_LEAST,
                ABOUT_SCRIPT,
            ),
        ),
        unit="identification",
        size=samples,
        size_of="samples",
        quality=ERROR,
        is_warmed=False,
        turns=9,  # the number of fits differs from seed to seed
        budget=900.0,
        limit=900.0,
    )


def _rational() -> Row:
    exact = "benchmarks.tasks.identify_here:noiseless"
    return Row(
        "identification",
        "least squares on a surrogate of 100 samples, exact data",
        (
            Contestant("rational", exact, {"name": "rational", "samples": 100}),
            Contestant("Kriging", exact, {"name": "kriging", "samples": 100}),
            Contestant("response surface", exact, {"name": "rsm", "samples": 100}),
        ),
        unit="identification",
        quality="largest relative error",
        budget=20.0,
    )

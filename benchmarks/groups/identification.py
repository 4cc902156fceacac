"""Identifications of the three-disk rotor from amplitudes with 10 % noise.

Each turn has data of another seed. Generations of the optimisers alone, at an objective that costs nothing, are
compared with the bare library that each adapts.

Quality is the root mean square over the five unknowns of the errors in units of their Cramér–Rao lower bounds, the median over turns.
A ratio below 1 of an optimiser is what our adapter, its count of points and its isolation of global generators cost.
"""

from __future__ import annotations

from functools import partial

from benchmarks.harness.row import ROSS, Row, by
from benchmarks.tasks import data

ERROR = "rms error of the unknowns (CRLB)"
WITHOUT_SURROGATE = {"DE": "de", "PSO": "pso", "GA": "ga", "least squares from many starts": "lm"}
TABLE3 = 40, 100  # samples
AT_LEAST = 20.0  # times as fast as the script
ABOUT_SCRIPT = "no intervals; at most 20 updates"
OPTIMIZERS = {"de": "scipy", "pso": "pyswarms", "ga": "deap", "cmaes": "cma"}  # and the libraries that they adapt
# The cheapest model here: one point after the other is the dearest for the trace of a search.
SEARCHES = ("DE", "LM", "single points", "batches")
POPULATION, GENERATIONS = 100, 50
OWN_RULES = {"cmaes": "its own stopping rules off: no restarts"}
_row = partial(Row, "identification", unit="identification")


def rows() -> list[Row]:
    return [_methods(), *(_script(samples) for samples in TABLE3), _rational(), *map(_traced, SEARCHES)]


def optimizer_rows() -> list[Row]:
    return [_generation(optimizer, library) for optimizer, library in OPTIMIZERS.items()]


def _methods() -> Row:
    method = partial(by, task="identify_here:method", run_ups=data.run_ups(), settings={})
    contestants = (
        method("KSMEA, Kriging of 100 samples and DE", method="ksmea", optimizer="de", surrogate="kriging"),
        *(
            method(f"{label}, no surrogate", method="direct", optimizer=optimizer)
            for label, optimizer in WITHOUT_SURROGATE.items()
        ),
        method(
            "rational surrogate of 40 samples, DE", method="ksmea", optimizer="de", surrogate="rational", samples=40
        ),
    )
    return _row("methods, without intervals", contestants, quality=ERROR, budget=40.0)


def _script(samples: int) -> Row:
    given = {"run_ups": data.run_ups(), "samples": samples}
    script = partial(by, task="identify_script:run", at_least=AT_LEAST, note=ABOUT_SCRIPT, **given)
    contestants = (
        by("here, with intervals and CRLB", "identify_here:run_of_table3", **given),
        script("script: scikit-learn, scipy DE, numpy.linalg.solve", library="scikit-learn", model="numpy"),
        script("script: scikit-learn, scipy DE, ROSS", library=ROSS, model="ROSS"),
    )
    long = {"is_warmed": False, "turns": 9, "budget": 900.0, "limit": 900.0}  # fits differ in number from seed to seed
    return _row("a run of Table 3", contestants, size=samples, size_of="samples", quality=ERROR, **long)


def _rational() -> Row:
    surrogates = {"rational": "rational", "Kriging": "kriging", "response surface": "rsm"}
    contestants = tuple(
        by(label, "identify_here:noiseless", surrogate=surrogate, samples=100)
        for label, surrogate in surrogates.items()
    )
    name = "least squares on a surrogate of 100 samples, exact data"
    return _row(name, contestants, quality="largest relative error", budget=20.0)


def _traced(search: str) -> Row:
    asked = partial(by, task="identify_here:traced", run_ups=data.run_ups(), search=search)
    contestants = asked("with its trace", is_traced=True), asked("evaluations counted alone", is_traced=False)
    return _row(f"trace of {search} on the model", contestants, budget=10.0)


def _generation(optimizer: str, library: str) -> Row:
    size = {"population": POPULATION, "generations": GENERATIONS}
    bare = partial(by, task="search:bare", **size)
    contestants = [
        by("here", "search:here", optimizer=optimizer, **size),
        bare(f"{library} alone", library=library, note=OWN_RULES.get(optimizer, ""), optimizer=library),
    ]
    if optimizer == "de":
        contestants.append(bare("pymoo", library="pymoo", optimizer="pymoo"))
    return Row(
        "optimizers",
        f"a generation of {POPULATION} by {optimizer}",
        tuple(contestants),
        unit="generation",
        quality="misfit at the end",
        is_quick=optimizer == "de",
        budget=10.0,
    )

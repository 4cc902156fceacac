"""A generation of each optimiser at an objective that costs nothing, beside the bare library that it adapts.

Below 1, the ratio is what our adapter, its count of points and its isolation of global generators cost.
"""

from __future__ import annotations

from benchmarks.harness.row import HERE, PEERS, Contestant, Row

LIBRARIES = {"de": "scipy", "pso": "pyswarms", "ga": "deap", "cmaes": "cma"}
POPULATION, GENERATIONS = 100, 50
OWN = {"cmaes": "its own stopping rules off: no restarts"}


def rows() -> list[Row]:
    return [_generation(optimizer, library) for optimizer, library in LIBRARIES.items()]


def _generation(optimizer: str, library: str) -> Row:
    size = {"population": POPULATION, "generations": GENERATIONS}
    bare = "benchmarks.tasks.search_bare:search"
    contestants = [
        Contestant("here", "benchmarks.tasks.search_here:search", {"optimizer": optimizer, **size}),
        Contestant(f"{library} alone", bare, {"library": library, **size}, library, HERE, note=OWN.get(optimizer, "")),
    ]
    if optimizer == "de":
        contestants.append(Contestant("pymoo", bare, {"library": "pymoo", **size}, "pymoo", PEERS))
    return Row(
        "optimizers",
        f"a generation of {POPULATION} by {optimizer}",
        tuple(contestants),
        unit="generation",
        quality="misfit at the end",
        is_quick=optimizer == "de",
        budget=10.0,
    )

"""Contests made by hand: plans of methods × instances, and records.

The traces of the records fall as required.
"""

from bench.jobs.records import RecordWriter
from bench.plan.plan import Cell, ParameterFacts, Plan, ReportSettings, all_runs, write_plan

LEAST = 100.0  # misfit at the maximum nearest to the truth


def contest_plan(methods, instances, repetitions=2, budget=100, report="contest"):
    """A cell for each method (a label) and instance.

    An instance is (family, number of unknowns, further settings of the problem).
    """
    cells = []
    for number, (family, d, *further) in enumerate(instances):
        facts = tuple(ParameterFacts(f"k{at}", "MN/m", 1e6, 50e6, 1e6) for at in range(d))
        problem = {"name": "drawn", "family": family, "instance": number, **(further[0] if further else {})}
        for at, label in enumerate(methods):
            settings = {
                "problem": problem,
                "measurement": {"name": "synthetic", "relative": 0.1},
                "method": {"name": "direct"},
                "optimizer": {"name": "de", "population": 20 + at},
                "surrogate": None,
                "samples": None,
                "study": {"name": "identify", "level": 0.95, "budget": budget, "jacobian_cost": 2},
            }
            place = {"label": label, "problem.family": family, "problem.instance": number}
            cells.append(Cell(place, settings, 0, facts, "c0de"))
    return Plan(
        name="contest",
        report=ReportSettings(table="contest", paper=None, figures=(), exact=None),
        axes=("label", "problem.family", "problem.instance"),
        command=("+experiment=contest",),
        commit="c0de",
        versions={"numpy": "2.0"},
        platform="abacus",
        modules={},
        cells=tuple(cells),
        runs=all_runs(tuple(cells), repetitions, {"numpy": "2.0"}),
    )


def record(d, evaluations, excess, error=None, surrogate=0, seconds=1.0, took=100, status="budget"):
    """Record of a run with this excess and error after these evaluations.

    It ended after `took`.
    """
    unknowns = [
        {
            "name": f"k{at}",
            "unit": "MN/m",
            "si_per_unit": 1e6,
            "true": 50e6,
            "identified": 51e6,
            "at_limit": False,
        }
        for at in range(d)
    ]
    return {
        "status": status,
        "stop": "budget",
        "parameters": unknowns,
        "misfit": 1.0,
        "updates": 0,
        "model_evaluations": took,
        "model_jacobians": 0,
        "surrogate_evaluations": surrogate,
        "seconds": {"model": 0.1 * seconds, "surrogate": 0.0, "search": 0.9 * seconds, "total": seconds},
        "history": [],
        "trace": {
            "evaluations": list(evaluations),
            "jacobians": [0] * len(evaluations),
            "surrogate_evaluations": [surrogate] * len(evaluations),
            "misfit": [LEAST + each for each in excess],
            "seconds": [seconds * each / took for each in evaluations],
            "error": list(excess if error is None else error),
            "least": LEAST,
        },
    }


FAILED = {"status": "error", "error": "ValueError: no luck"}


def write_contest(plan, output, result):
    """The folder of a plan whose run of a label, instance number and repetition has `result` of them.

    None: not run.
    """
    write_plan(plan, output)
    with RecordWriter(output, 0, plan) as writer:
        for run in plan.runs:
            place = plan.cells[run.cell].place
            made = result(place["label"], place["problem.instance"], run.repetition)
            if made is not None:
                writer.result(run, made)
    return output

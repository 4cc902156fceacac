"""Runs of a contest: method, instance, cost until each target, and excess and error at the end.

Methods are compared on the draws, an instance with a seed and a repetition, that all of them have ended;
`Contest.notes` counts the others. A run that failed, or has no trace, has reached nothing, at the cost of its whole
budget.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from bench.jobs.lines import RESULTS
from bench.jobs.records import UNFINISHED
from bench.plan.plan import Plan
from bench.reports.contest.cells import budget, family, identity, is_held_back, method_name, telling_words
from bench.reports.contest.targets import MEASURES, Measure, reached
from bench.reports.identification.trace_table import Traced, jacobian_price
from ksmea.arrays import Array
from ksmea.errors import SettingError

ENDED = ("failed", "surrogate", "cost", "seconds", "model_seconds", "excess", "error")  # what is told of a run's end
# columns of `runs_frame` that are used, and of those of a contest that are told before its end
OF_RUN = ("key", "cell", "seed", "repetition", "status", "time", "time_model", "surrogate_evaluations")
KEPT = ("key", "method", "instance", "draw", "repetition", "status", "price", "budget")


@dataclass(frozen=True)
class Contest:
    """Contest: its instances, methods and runs.

    `instances` has a row for each: family, number in it, unknowns, whether it is held back (None: not stated),
    settings.

    `runs` has a row per compared run: indices of method and instance, its price of a Jacobian and what it took in all. `hits` and
    `overheads` (n_run, n_target) by the name of a measure: cost, and seconds of the method's own, until each target.
    """

    methods: tuple[str, ...]
    instances: pd.DataFrame
    runs: pd.DataFrame
    hits: Mapping[str, Array]
    overheads: Mapping[str, Array]
    traces: Mapping[str, Traced]
    measures: tuple[Measure, ...]  # that any run has values of
    notes: tuple[str, ...]  # what is not compared

    @property
    def families(self) -> Array:
        """Family of each instance, (n_instance,)."""
        return self.instances["family"].to_numpy(str)

    @property
    def unknowns(self) -> Array:
        """How many unknowns each run's instance has, (n_run,)."""
        return self.instances["unknowns"].to_numpy(float)[self.runs["instance"]]

    @property
    def most(self) -> float:
        """Largest cost per unknown that a run may take, so that a score does not depend on other entries.

        Without a common budget it is the largest that any run took.
        """
        budget = self.runs["budget"].astype(float)
        return float(np.max((self.runs["cost"] if budget.isna().any() else budget) / self.unknowns))

    def groups(self) -> dict[str, np.ndarray]:
        """Instances that tables take together (n_instance,): all, then each family where there are several."""
        families = dict.fromkeys(self.families)
        each = {family: self.families == family for family in families} if len(families) > 1 else {}
        return {"all": np.ones(len(self.instances), bool), **each}

    def summed(self, values: Array) -> Array:
        """Values of runs (n_run, …) summed over the draws of each method and instance.

        The sums are (n_method, n_instance, …).
        """
        values = np.asarray(values, dtype=float)
        found = np.zeros((len(self.methods), len(self.instances), *values.shape[1:]))
        np.add.at(found, (self.runs["method"].to_numpy(), self.runs["instance"].to_numpy()), values)
        return found

    def medians(self, values: Array, draws: np.ndarray | None = None) -> Array:
        """Medians (n_instance, n_method) of a value of runs (n_run,) over all or some draws; NaN without one."""
        frame = self.runs[["method", "instance"]].assign(value=values)
        chosen = frame if draws is None else frame[draws]
        table = chosen.groupby(["instance", "method"])["value"].median().unstack()
        return table.reindex(index=range(len(self.instances)), columns=range(len(self.methods))).to_numpy(float)


def contest(plan: Plan, runs: pd.DataFrame, traces: Mapping[str, Traced]) -> Contest:
    """The contest of a plan, its runs (`runs_frame`) and their traces by key, if they have one.

    Raises `SettingError` if a label has several cells of one instance and seed.
    """
    cells = cells_frame(plan)
    ended = runs[~runs["status"].isin(UNFINISHED)].reindex(columns=list(OF_RUN)).merge(cells, on="cell")
    ended["draw"] = ended["seed"].astype(str) + "/" + ended["repetition"].astype(str)
    methods = tuple(label for label in dict.fromkeys(cells["label"]) if label in set(ended["label"]))
    met_by = ended.groupby(["identity", "draw"])["label"].transform("nunique")
    compared = ended[met_by == len(methods)].reset_index(drop=True)
    instances = _instances_frame(plan, cells[cells["identity"].isin(compared["identity"])])
    compared["method"] = pd.Categorical(compared["label"], methods).codes.astype(int)
    compared["instance"] = pd.Categorical(compared["identity"], instances.pop("identity")).codes.astype(int)
    ends = [_end(run, traces.get(run["key"])) for run in compared.to_dict("records")]
    table = _charged(compared[list(KEPT)].join(pd.DataFrame(ends, columns=list(ENDED))))
    hits, overheads = _reached(table, traces)
    measures = tuple(measure for measure in MEASURES if np.isfinite(table[measure.name].astype(float)).any())
    return Contest(
        methods, instances, table, hits, overheads, traces, measures, _notes(cells, ended, compared, methods)
    )


def cells_frame(plan: Plan) -> pd.DataFrame:
    """Label, instance, price of a Jacobian and budget of each cell.

    `SettingError` if a label has several cells of one instance and seed.
    """
    frame = pd.DataFrame(
        {
            "cell": range(len(plan.cells)),
            "label": [method_name(cell) for cell in plan.cells],
            "identity": [identity(cell) for cell in plan.cells],
            "price": [jacobian_price(cell) for cell in plan.cells],
            "budget": [budget(cell) for cell in plan.cells],
        }
    )
    seeds = [cell.seed for cell in plan.cells]
    twice = frame.assign(seed=seeds).duplicated(["label", "identity", "seed"])
    if twice.any():
        raise SettingError(
            f"table=contest: expected one cell of label {frame['label'][twice].iloc[0]} for each instance, got two that differ"
            " otherwise; give each method a label of its own"
        )
    return frame


def _instances_frame(plan: Plan, cells: pd.DataFrame) -> pd.DataFrame:
    """A row for each instance of these cells, in their order."""
    first = cells.drop_duplicates("identity")
    found = [plan.cells[index] for index in first["cell"]]
    frame = pd.DataFrame(
        {
            "identity": first["identity"].to_numpy(),
            "family": [family(cell) for cell in found],
            "unknowns": [len(cell.parameters) for cell in found],
            "held_back": [is_held_back(cell) for cell in found],
            "settings": telling_words(found),
        }
    )
    frame.insert(2, "number", frame.groupby("family").cumcount() + 1)
    return frame


def _notes(
    cells: pd.DataFrame, ended: pd.DataFrame, compared: pd.DataFrame, methods: tuple[str, ...]
) -> tuple[str, ...]:
    """Notes on runs that are omitted from the comparison."""
    notes = [f"{name}: no run has ended; left out" for name in dict.fromkeys(cells["label"]) if name not in methods]
    n_all, n_kept = cells["identity"].nunique(), compared["identity"].nunique()
    draws, kept = (len(each[["identity", "draw"]].drop_duplicates()) for each in (ended, compared))
    if (n_kept, kept) != (n_all, draws):
        lacking = {name: draws - int((ended["label"] == name).sum()) for name in methods}
        unfinished = ", ".join(f"{name} {lacks}" for name, lacks in lacking.items() if lacks)
        notes.append(
            f"compared on the {n_kept} of {n_all} instances and {kept} of {draws} draws that all methods have ended"
            + (f"; not ended: {unfinished}" if unfinished else "")
        )
    if (compared.groupby("identity")["budget"].nunique(dropna=False) > 1).any():
        notes.append("budgets differ between methods: results at the end are not at equal cost")
    return tuple(notes)


def _end(run: Mapping[str, Any], traced: Traced | None) -> dict[str, Any]:
    """Cost, times, excess and error at the end of a run; NaN costs and infinite errors without a trace."""
    if run["status"] not in RESULTS or traced is None or not len(traced.trace.misfit):
        return dict(zip(ENDED, (run["status"] not in RESULTS, False, np.nan, np.nan, np.nan, np.inf, np.inf)))
    return {
        "failed": False,
        "surrogate": run["surrogate_evaluations"] > 0,
        "cost": float(traced.cost(run["price"])),
        "seconds": run["time"],
        "model_seconds": run["time_model"],
        "excess": np.nan_to_num(traced.excess[-1], nan=np.inf, neginf=-np.inf),
        "error": np.nan_to_num(traced.error[-1], nan=np.inf),
    }


def _charged(runs: pd.DataFrame) -> pd.DataFrame:
    """Runs with what those without a trace are charged.

    Their budget, or without one the most that any run took on their instance, and the seconds of their method's median
    run.
    """
    most = runs.groupby("instance")["cost"].transform("max")
    charged = {"cost": runs["cost"].fillna(runs["budget"].astype(float)).fillna(most).fillna(0.0)}
    for name in ("seconds", "model_seconds"):
        charged[name] = runs[name].fillna(runs.groupby("method")[name].transform("median")).fillna(0.0)
    return runs.assign(**charged)


def _reached(runs: pd.DataFrame, traces: Mapping[str, Traced]) -> tuple[dict[str, Array], dict[str, Array]]:
    """Cost, and seconds of the method's own, of each run until each target, by measure.

    A run without a trace, or without the target, has an infinite cost and all its own seconds.
    """
    per_cost = (runs["model_seconds"] / runs["cost"].where(runs["cost"] > 0)).fillna(0.0).to_numpy()
    own = (runs["seconds"] - runs["model_seconds"]).to_numpy()
    hits = {measure.name: np.full((len(runs), len(measure.targets)), np.inf) for measure in MEASURES}
    overheads = {measure.name: np.tile(own[:, None], (1, len(measure.targets))) for measure in MEASURES}
    for number, (key, price, failed) in enumerate(runs[["key", "price", "failed"]].itertuples(index=False)):
        if failed or key not in traces:
            continue
        traced = traces[key]
        costs = traced.costs(price)
        alone = np.maximum(np.array(traced.trace.seconds) - per_cost[number] * costs, 0.0)
        for measure in MEASURES:
            at = reached(getattr(traced, measure.name), measure.targets)
            has = at < len(costs)
            hits[measure.name][number, has] = costs[at[has]]
            overheads[measure.name][number, has] = alone[at[has]]
    return hits, overheads

"""Commands on results that are there: `status`, `explain` and `collect`. They read plan and records, and run nothing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from bench.commands.reference import write_reference
from bench.commands.verify import verify
from bench.jobs.records import RESULTS, read_lines, read_records, running_sessions
from bench.plan.plan import PLAN_FILE, Plan, Run, read_plan
from bench.plan.provenance import code_digest, library_versions, used_modules
from bench.reports.collect import collect, collect_all
from ksmea.errors import SettingError, unknown


def status(words: list[str]) -> int:
    """`status NAME|DIR`: how many of the planned runs are done, running, failed, stale or missing; 0 where all are done."""
    return max(_status(output) for output in _outputs(words, "status"))


def _status(output: Path) -> int:
    plan = read_plan(output)
    running = running_sessions(output)

    def state_and_question(line: dict[str, Any]) -> tuple[str, str]:
        is_running = line["event"] == "started" and line["session"] in running
        return "running" if is_running else line["status"], line["question"]

    records = read_records(output, state_and_question)
    answered = {question for state, question in records.values() if state in RESULTS}
    counts = Counter(_state(run, records, answered) for run in plan.runs)
    n_done = sum(counts[state] for state in RESULTS)
    n_failed = sum(count for state, count in counts.items() if state not in (*RESULTS, "running", "stale", "missing"))
    print(f"{plan.name} in {output}")
    counted = {"planned": len(plan.runs), "done": n_done, "running": counts["running"], "failed": n_failed}
    for label, count in counted.items():
        if label == "running" and not count:
            continue
        reasons = _reasons(counts, label)
        print(f"{label:>8} {count:6d}{'  (' + reasons + ')' if reasons else ''}")
    print(f"{'stale':>8} {counts['stale']:6d}{'  (answered by other code or libraries)' if counts['stale'] else ''}")
    print(f"{'missing':>8} {counts['missing']:6d}")
    return 0 if n_done == len(plan.runs) else 1


def _state(run: Run, records: Mapping[str, tuple[str, str]], answered: set[str]) -> str:
    if run.key in records:
        return records[run.key][0]
    return "stale" if run.question in answered else "missing"


def _reasons(counts: Counter[str], label: str) -> str:
    shown = {"done": ("budget",), "failed": ("error", "timeout", "killed")}.get(label, ())
    return ", ".join(f"{counts[state]} {state}" for state in shown if counts[state])


def explain(words: list[str]) -> int:
    """`explain KEY [NAME|DIR]`: a run's settings, what became of it and why it is stale or failed."""
    if not words:
        raise SettingError("explain: expected the key of a run (see runs.csv), got nothing")
    key, *place = words
    folders = (
        _outputs(place, "explain") if place else sorted(path.parent for path in Path("results").glob(f"**/{PLAN_FILE}"))
    )
    for folder in folders:
        try:
            plan = read_plan(folder)
        except SettingError:
            if place:
                raise
            continue  # the plan of another experiment, which nobody asked for
        for run in plan.runs:
            if run.key.startswith(key):
                print(_explanation(plan, run, folder))
                return 0
    places = ", ".join(map(str, folders)) or "results/*"
    raise SettingError(f"explain: expected the key of a planned run, found no {key!r} in {places}; runs.csv lists them")


def _explanation(plan: Plan, run: Run, folder: Path) -> str:
    cell = plan.cells[run.cell]
    place = ", ".join(f"{axis}={value}" for axis, value in cell.place.items())
    lines = [f"run {run.key} of {plan.name} in {folder}: {place}, seed {cell.seed}, repetition {run.repetition}"]
    for part, settings in cell.settings.items():
        lines.append(f"  {part}: {_in_words(settings)}")
    mine = [line for line in read_lines(folder) if line["event"] == "result" and line["key"] == run.key]
    record = read_records(folder, lambda line: line).get(run.key)
    if record is None:
        lines += _why_stale(plan, run, folder) or ["missing: no attempt was made"]
    else:
        lines.append(f"{record['status']}{': ' + record['error'] if record.get('error') else ''}")
        if record.get("traceback"):
            lines.append(record["traceback"].rstrip())
        if len(mine) > 1:
            lines.append(f"{len(mine)} attempts: {', '.join(line['status'] for line in mine)}")
        if "taken_from" in record:
            lines.append(f"taken over from {record['taken_from']}")
    lines += _what_changed_since_the_plan(plan, cell.settings, cell.code)
    return "\n".join(lines)


def _in_words(settings: Any) -> str:
    if not isinstance(settings, Mapping):
        return "makes no difference" if settings is None else str(settings)
    return ", ".join([str(settings["name"]), *(f"{key}={value}" for key, value in settings.items() if key != "name")])


def _why_stale(plan: Plan, run: Run, folder: Path) -> list[str]:
    """What differs between the plan and the session that answered the same question."""
    sessions: dict[str, dict[str, Any]] = {}
    answer: dict[str, Any] | None = None
    for line in read_lines(folder):
        if line["event"] == "session":
            sessions[line["session"]] = line
        elif line["event"] == "result" and line["question"] == run.question and line["status"] in RESULTS:
            answer = line
    if answer is None:
        return []
    session = sessions.get(answer["session"], {"modules": {}, "versions": {}, "began": "?", "commit": "?"})
    used = used_modules(plan.cells[run.cell].settings)
    changed = _differences(session["versions"], plan.versions)
    changed += _differences({name: session["modules"].get(name) for name in used}, plan.modules, names_only=True)
    reason = "; ".join(changed) or "the set of modules that it uses"
    return [f"stale: answered on {session['began']} at commit {session['commit']}; changed since: {reason}"]


def _what_changed_since_the_plan(plan: Plan, settings: Mapping[str, Any], code: str) -> list[str]:
    used = used_modules(settings)
    changed = _differences(plan.versions, library_versions())
    if code_digest(used) != code:
        changed += _differences({name: plan.modules.get(name) for name in used}, used, names_only=True)
    return (
        [f"since it was planned these have changed, the next call plans it anew: {'; '.join(changed)}"]
        if changed
        else []
    )


def _differences(before: Mapping[str, Any], after: Mapping[str, Any], names_only: bool = False) -> list[str]:
    """Entries of `before` that `after` has otherwise."""
    return [
        name if names_only else f"{name} {value} → {after.get(name)}"
        for name, value in before.items()
        if value != after.get(name)
    ]


def collect_again(words: list[str]) -> int:
    """`collect NAME|DIR`: tables and figures from plan and records; 0 where every planned run has a result."""
    outputs = _outputs(words, "collect")
    codes = [collect(output) for output in outputs]
    if len(outputs) > 1:
        collect_all(outputs[0].parent, outputs)
    return max(codes)


def reference(words: list[str]) -> int:
    """`reference NAME|DIR`: make results/reference/ of an experiment that is done, by committed code."""
    for path in write_reference(_output(words, "reference")):
        print(f"written: {path}")
    return 0


COMMANDS: dict[str, Callable[[list[str]], int]] = {
    "status": status,
    "explain": explain,
    "collect": collect_again,
    "verify": verify,
    "reference": reference,
}


def _output(words: list[str], command: str) -> Path:
    """The folder of one experiment that NAME (below results/) or DIR means."""
    first, *others = _outputs(words, command)
    if others:
        raise SettingError(f"{command}: expected one experiment, got {words[0]} with several; name one, as {first}")
    return first


def _outputs(words: list[str], command: str) -> list[Path]:
    """The folders that NAME (below results/) or DIR means: of an experiment, or of those that it includes."""
    if len(words) != 1:
        raise SettingError(f"{command}: expected one name or folder of results, got {len(words)}")
    for folder in (Path("results") / words[0], Path(words[0])):
        found = (
            [folder]
            if (folder / PLAN_FILE).is_file()
            else sorted(path.parent for path in folder.glob(f"*/{PLAN_FILE}"))
        )
        if found:
            return found
    known = {path.relative_to("results").parts[0] for path in Path("results").glob(f"**/{PLAN_FILE}")}
    raise unknown("results", words[0], known)

"""Code and libraries of a plan: a job computes with these, or not at all.

Other results would answer no planned key.
"""
# Shorter than 40 lines: the one check that a job computes by planned code.

from __future__ import annotations

from bench.plan.outside import FILE, is_file
from bench.plan.plan import Plan
from bench.plan.provenance import code_digest, library_versions, used_modules
from ksmea.errors import SettingError


def require_planned_code(plan: Plan) -> None:
    """`SettingError` if this process would compute by other modules or libraries than planned."""
    here = library_versions()
    if others := [name for name in sorted({*plan.versions, *here}) if plan.versions.get(name) != here.get(name)]:
        differences = ", ".join(f"{name} {plan.versions.get(name)}, here {here.get(name)}" for name in others)
        raise _other(plan, differences)
    for cell in plan.cells:
        modules = used_modules(cell.settings, plan.plugins)
        if code_digest(modules) != cell.code:
            changed = [name for name, digest in modules.items() if plan.modules.get(name) != digest]
            raise _other(plan, f"other modules {', '.join(changed)}" if changed else "fewer modules")


def planned_plugins(plan: Plan) -> dict[str, dict[str, str]]:
    """Plain files of a plan's plugins, each with the expected digests of it and its imports.

    The imports are from next to it.
    """
    digests = {name.removeprefix(FILE): digest for name, digest in plan.modules.items() if is_file(name)}
    return {path: digests for path in sorted({*plan.plugins.values()})}


def _other(plan: Plan, found: str) -> SettingError:
    return SettingError(
        f"{plan.name}: expected the code and libraries of its plan (commit {plan.commit}), found {found};"
        " give the experiment's command again where its jobs run, or install what it was planned with"
    )

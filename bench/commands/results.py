"""Commands by name. Those on results that are there read plan and records, and `verify` alone runs anything.

Each is imported when it is asked for: `status` needs neither tables nor figures.
"""

from __future__ import annotations

from pkgutil import resolve_name

COMMANDS = {
    "status": "bench.commands.status:status",
    "explain": "bench.commands.explain:explain",
    "collect": "bench.commands.collect:collect_again",
    "open": "bench.commands.open:open_page",
    "compare": "bench.commands.compare:compare",
    "merge": "bench.commands.merge:merge",
    "export": "bench.commands.export:export",
    "import": "bench.commands.import_file:import_file",
    "verify": "bench.commands.verify:verify",
    "reference": "bench.commands.reference:reference",
    "draw": "bench.commands.draw:draw",
    "new": "bench.commands.new:new",
}


def run_command(words: list[str]) -> int:
    """Do the command that the first word names; its exit code."""
    code: int = resolve_name(COMMANDS[words[0]])(words[1:])
    return code

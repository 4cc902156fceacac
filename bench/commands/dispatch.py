"""Commands by name.

Commands on finished results read plan and records; `verify` alone runs anything.

Each command is imported when it is requested: `status` needs neither tables nor figures, which take 0.5 s to load.
"""

from __future__ import annotations

COMMANDS = (
    "status",
    "explain",
    "collect",
    "open",
    "compare",
    "merge",
    "export",
    "import",
    "verify",
    "reference",
    "draw",
    "new",
)


def run_command(words: list[str]) -> int:
    """Do the command that the first word names, one of `COMMANDS`; its exit code."""
    name, *others = words
    match name:
        case "status":
            from bench.commands.status import status

            return status(others)
        case "explain":
            from bench.commands.explain import explain

            return explain(others)
        case "collect":
            from bench.commands.collect import collect_again

            return collect_again(others)
        case "open":
            from bench.commands.open import open_page

            return open_page(others)
        case "compare":
            from bench.commands.compare import compare

            return compare(others)
        case "merge":
            from bench.commands.merge import merge

            return merge(others)
        case "export":
            from bench.commands.export import export

            return export(others)
        case "import":
            if others[:1] == ["rotor"]:
                from bench.commands.import_rotor import import_rotor

                return import_rotor(others[1:])
            from bench.commands.import_file import import_file

            return import_file(others)
        case "verify":
            from bench.commands.verify import verify

            return verify(others)
        case "reference":
            from bench.commands.reference import reference

            return reference(others)
        case "draw":
            from bench.commands.draw import draw

            return draw(others)
        case "new":
            from bench.commands.new import new

            return new(others)
    raise ValueError(f"{name} is not a command")

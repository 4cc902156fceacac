"""Habits of wording that make texts hard to read, counted: the count may only fall. Docstrings begin with a short line.

Habits are counted in docs, docstrings and messages. Public functions and contracts of plugins document their arguments.
"""

import ast
import inspect
import re
from pathlib import Path

import bench.plan.report
import bench.plan.study
import ksmea
import ksmea.results
import ksmea.rotor_drawing
from problems.rotor.extension import effect, hooks

ROOT = Path(__file__).resolve().parents[1]
FOLDERS = ("docs", "ksmea", "bench", "problems", "surrogates", "optimizers", "measurements")
MOST = 25  # lower it whenever texts improve
HABITS = re.compile(
    r"\bwhat (?:it|a fit|the fit|the model|they) leaves?\b|\bwhat is left\b|\bleaves? (?:over|noise)\b"  # residuals
    r"|\b(?:is|are) none\b|\bis no [a-z]+\b"  # not, no … exists
    r"|\btold\b|\bask(?:s|ed)? for\b|\bgoes by\b|\bpromis\w+|\bbeliev\w+"  # programs and data do not speak
    r"|Left out:|^The same\b|\bThe same (?:for|of|with|as|from|before)\b"  # Default:, the noun again
    r"|\b(?:fitted|estimated|found|identified|determined|taken?) along\b|\bbesides?\b"  # also, with, in addition
    r"|(?:^|[.;:,] |\()[Ww]here (?:the|a|an|it|that|there|one|no|this|these|data|noise|nothing)\b"  # if
    r"|\bas \w+ as to\b|\bthose (?:of|that|which)\b|\bthat of\b|\bs of a core\b|\bin the median\b",
    re.MULTILINE,
)
FIRST = re.compile(r"(?:What|That|Those|Of|As)\b")  # of a docstring
DOCUMENTED = (*FOLDERS, "hydra_plugins", "benchmarks", "examples", "tests/helpers")
LONGEST_FIRST = 100  # characters
NOT_FIRST = re.compile(r"(?:What|The same|Those|Whether it is what)\b")
# Classes of the Python API and contracts of plugins that are not exported.
RESULTS = [each for module in (ksmea.results, ksmea.rotor_drawing) for each in vars(module).values()]
CONTRACTS = [
    bench.plan.study.Study,
    bench.plan.report.Report,
    hooks.RotorHooks,
    effect.RotorEffect,
    effect.SeatedEffect,
]
FENCE = re.compile(r"```.*?```", re.DOTALL)


def habits(text, *, is_docstring=False):
    return len(HABITS.findall(text)) + bool(is_docstring and FIRST.match(text))


def in_python(source):
    """Habits in the docstrings and texts of a module."""
    tree = ast.parse(source)
    documented = [node for node in ast.walk(tree) if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)]
    docstrings = {id(node.body[0].value) for node in documented if ast.get_docstring(node)}
    texts = [node for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)]
    return sum(habits(node.value, is_docstring=id(node) in docstrings) for node in texts if " " in node.value)


def counts():
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    found = {page: habits(FENCE.sub("", page.read_text(encoding="utf-8"))) for page in pages}
    for path in (path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")):
        found[path] = in_python(path.read_text(encoding="utf-8"))
    return found


def test_habits_become_fewer():
    found = counts()
    worst = sorted(found, key=found.get, reverse=True)[:10]
    listed = "\n".join(f"{found[path]} {path.relative_to(ROOT)}" for path in worst)
    assert sum(found.values()) <= MOST, f"write plainly, or lower another count; most are in\n{listed}"


def test_a_habit_is_counted():
    assert habits("What it leaves is no noise.") == 1 and habits("its residuals are not noise") == 0
    assert in_python('def f():\n    """What is left of it."""') == 1
    assert in_python('def f():\n    """What holds it."""') == 1


def docstrings(source):
    """Line and docstring of each module, class and function."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (found := ast.get_docstring(node)):
            yield getattr(node, "lineno", 1), found


def is_long(docstring):
    """Whether its first paragraph is more than one line of plain length."""
    first, *more = docstring.partition("\n\n")[0].splitlines()
    return len(first) > LONGEST_FIRST or bool(more)


def beginnings(folders, is_wrong):
    """Places and first lines of docstrings with a property."""
    return [
        f"{path.relative_to(ROOT)}:{line}: {text.splitlines()[0]}"
        for folder in folders
        for path in sorted((ROOT / folder).rglob("*.py"))
        for line, text in docstrings(path.read_text(encoding="utf-8"))
        if is_wrong(text)
    ]


def test_docstrings_begin_with_a_short_line():
    found = beginnings(DOCUMENTED, is_long)
    assert not found, f"at most {LONGEST_FIRST} characters, then a blank line and the rest:\n" + "\n".join(found)


def test_docstrings_name_their_topic_first():
    found = beginnings((*DOCUMENTED, "tests"), NOT_FIRST.match)
    assert not found, "begin with a noun or a verb of the field:\n" + "\n".join(found)


def test_a_bad_beginning_is_found():
    assert NOT_FIRST.match("What it is.") and NOT_FIRST.match("Those of a rotor.") and not NOT_FIRST.match("Thosen.")
    assert is_long("x" * 101) and is_long("A line that\ngoes on.") and not is_long("A line.\n\nIt goes on\nhere.")


def without_arguments(name, function, n_bound=0):
    """Its name, if it has parameters other than the object that it belongs to and does not document them."""
    parameters = list(inspect.signature(function).parameters)[n_bound:]
    return [name] if parameters and "Args:" not in (function.__doc__ or "") else []


def undocumented(owner):
    """Public methods of a class that do not state what their arguments are, nor does a base class."""
    for name, member in vars(owner).items():
        function = member.__func__ if isinstance(member, classmethod) else member
        inherited = (inspect.getdoc(getattr(base, name, None)) or "" for base in owner.__mro__[1:])
        if inspect.isfunction(function) and not name.startswith("_") and not any("Args:" in each for each in inherited):
            yield from without_arguments(f"{owner.__name__}.{name}", function, n_bound=1)


def test_public_functions_and_contracts_document_their_arguments():
    exported = [getattr(ksmea, name) for name in ksmea.__all__]
    owners = [each for each in (*exported, *RESULTS, *CONTRACTS) if inspect.isclass(each)]
    own = [each for each in owners if each.__module__.partition(".")[0] in FOLDERS]
    found = [name for each in exported if inspect.isfunction(each) for name in without_arguments(each.__name__, each)]
    found += [name for owner in dict.fromkeys(own) for name in undocumented(owner)]
    assert not found, f"add a section Args with units and shapes: {', '.join(found)}"
    abstract = [getattr(owner, name) for owner in own for name in getattr(owner, "__abstractmethods__", ())]
    unread = [each.__qualname__ for each in abstract if inspect.isfunction(each) and without_arguments("", each, 1)]
    assert not unread, f"add a section Args with units and shapes: {', '.join(unread)}"


def test_a_function_without_documented_arguments_is_found():
    class Owner:
        def read(self, path):
            """Read a file."""

        def write(self):
            """Write a file."""

    assert list(undocumented(Owner)) == ["Owner.read"]

"""Habits of wording that make texts hard to read, counted in docs, docstrings and messages: the count may only fall."""

import ast
import re
from pathlib import Path

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

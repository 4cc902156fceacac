"""Content of Python files, and its copy kept between processes."""

import ast
import hashlib
import os

import pytest

from bench.plan.sources import Source, absolute, kept_sources, read_source
from bench.storage import content_cache
from bench.storage.content_cache import KeptByContent, cache_folder
from bench.storage.own_files import ROOT

FILES = sorted((ROOT / "bench" / "plan").glob("*.py")) + sorted((ROOT / "tests" / "helpers").glob("*.py"))
ODD = '''\
"""Docs."""
from __future__ import annotations
from . import beside, more as other
from ..above import thing
import a.b, c


class One:
    """Docs."""

    def method(self):
        "Docs."
        from .. import inner
        match self:
            case 1:
                import in_a_case
        try:
            pass
        except ValueError:
            import in_a_handler
        else:
            import in_an_else
        finally:
            with open("x"):
                import in_a_with

        async def nested():
            """Docs."""
            return lambda: "no docs"
'''


def by_a_walk_over_all(text, module, is_package):
    """Digest and imports by every node of the tree, expressions too."""
    tree = ast.parse(text)
    names = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)) and ast.get_docstring(
            node
        ):
            node.body[0] = ast.Pass()
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        if isinstance(node, ast.ImportFrom):
            above = module.split(".")[: len(module.split(".")) - node.level + is_package] if node.level else []
            base = ".".join([*above, *([node.module] if node.module else [])])
            names |= {base, *(f"{base}.{alias.name}" for alias in node.names)}
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()[:12], names


@pytest.mark.parametrize("is_package", [False, True])
def test_statements_alone_hold_what_counts(is_package):
    for text in [ODD, *(path.read_text(encoding="utf-8") for path in FILES)]:
        said = read_source(text.encode())
        imports = {absolute(name, "top.middle.own", is_package) for name in said.imports}
        assert (said.digest, imports) == by_a_walk_over_all(text, "top.middle.own", is_package)


def test_line_ends_of_other_systems_are_no_change():
    assert read_source(ODD.replace("\n", "\r\n").encode()) == read_source(ODD.encode())


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(content_cache.FOLDER, str(tmp_path / "cache"))
    return tmp_path / "cache" / content_cache.OWN


def length(content):
    return len(content)


def never(content):
    raise AssertionError("made again")


def test_a_later_process_finds_what_was_made(folder):
    first = KeptByContent("a.json", int, length)
    assert first.of(b"three") == 5
    first.keep()
    assert KeptByContent("a.json", int, never).of(b"three") == 5


def test_other_content_is_another_entry(folder):
    first = KeptByContent("a.json", int, length)
    first.of(b"three")
    first.keep()
    assert KeptByContent("a.json", int, length).of(b"three and more") == 14


def test_what_another_process_wrote_meanwhile_is_whole(folder):
    one, other = KeptByContent("a.json", int, length), KeptByContent("a.json", int, length)
    one.of(b"1"), other.of(b"22")
    one.keep()
    other.keep()
    third = KeptByContent("a.json", int, length)
    assert (third.of(b"1"), third.of(b"22")) == (1, 2)
    assert [path.name for path in folder.iterdir()] == ["a.json"]


@pytest.mark.parametrize(
    "content", [b"", b"{", b'{"x": "no number"}', b"[" * 100_000, b"\xff\xfe", b'{"x\xff": 1}', b"3"]
)
def test_a_damaged_file_is_as_none(folder, content):
    folder.mkdir(parents=True)
    (folder / "a.json").write_bytes(content)
    again = KeptByContent("a.json", int, length)
    assert again.of(b"three") == 5
    again.keep()
    assert KeptByContent("a.json", int, never).of(b"three") == 5


def test_a_pipe_in_its_place_is_not_waited_for(folder):
    folder.mkdir(parents=True)
    os.mkfifo(folder / "a.json")
    assert KeptByContent("a.json", int, length).of(b"three") == 5


def test_a_folder_that_cannot_be_made_costs_the_memory_alone(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv(content_cache.FOLDER, str(tmp_path / "file" / "cache"))
    values = KeptByContent("a.json", int, length)
    assert values.of(b"three") == 5
    values.keep()


def test_an_empty_name_keeps_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(content_cache.FOLDER, "")
    values = KeptByContent("a.json", int, length)
    assert values.of(b"three") == 5
    values.keep()
    assert list(tmp_path.iterdir()) == []


def test_without_a_choice_it_lies_where_the_system_keeps_such_files(monkeypatch, tmp_path):
    monkeypatch.delenv(content_cache.FOLDER, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "ksmea-bench"
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder() == tmp_path / "home" / ".cache" / "ksmea-bench"


def test_of_very_many_entries_those_in_use_stay(folder, monkeypatch):
    monkeypatch.setattr(content_cache, "MOST", 3)
    for names in ([b"1", b"22", b"333"], [b"4444"]):
        values = KeptByContent("a.json", int, length)
        for name in names:
            values.of(name)
        values.keep()
    assert KeptByContent("a.json", int, never).of(b"4444") == 4
    with pytest.raises(AssertionError, match="made again"):
        KeptByContent("a.json", int, never).of(b"1")


def test_sources_are_kept_as_they_are_read(folder):
    first = kept_sources()
    said = first.of(ODD.encode())
    first.keep()
    assert isinstance(said, Source)
    assert kept_sources().of(ODD.encode()) == said

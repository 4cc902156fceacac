"""`help` answers the terms of the glossary, from the page that the documentation shows."""

import re

import pytest

from bench.help.glossary import entries, plain
from bench.storage.own_files import GLOSSARY


def test_every_row_of_the_page_is_an_entry_without_markup():
    rows = [line for line in GLOSSARY.read_text("utf-8").splitlines() if re.match(r"\| (?!term|---)", line)]
    found = entries()
    assert len(found) == len(rows) > 80
    for entry, row in zip(found, rows):
        assert not re.search(r"[`*\\]|\]\(", f"{entry}"), row
        assert entry.meaning and entry.term and plain(entry.term) in entry.names


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["CRLB"], "CRLB (glossary, estimation): Cramér–Rao lower bound: the smallest standard deviation"),
        (["crlb"], "Cramér–Rao lower bound"),
        (["ΔBIC"], "deviance drop minus ln n per further unknown"),
        (["delta bic"], "deviance drop minus ln n per further unknown"),
        (["log decrement"], "log decrement (glossary, the rotor): δ = −2π Re λ/|Im λ|"),
        (["log", "decrement"], "log decrement (glossary, the rotor)"),
        (["decrement"], "log decrement (glossary, the rotor)"),
        (["predictive gain"], "log predictive density of left-out data"),
        (["at_limit"], "end of the search range of an unknown"),
        (["runout"], "probe reading from a surface that is not concentric"),  # below the effect of this name
        (["open set"], "(contest.md)"),  # a link as its text
    ],
)
def test_help_answers_a_term(words, said, enter):
    page = enter("help", *words)
    assert (page.code, page.err) == (0, "") and said in page.out


def test_a_term_is_added_to_what_has_its_name_and_does_not_hide_it(enter):
    page = enter("help", "runout").out
    assert page.startswith("effect=runout: ") and page.index("(glossary") > page.index("effect.position")
    assert "glossary" not in enter("help", "optimizer", "de").out


def test_a_misspelt_term_is_proposed_with_the_command(enter):
    ended = enter("help", "log decremnt")
    assert ended.code == 2
    assert "did you mean 'log decrement'?" in ended.err
    assert ended.err.strip().endswith("help 'log decrement'")
    assert "did you mean 'CRLB'?" in enter("help", "CRLX").err

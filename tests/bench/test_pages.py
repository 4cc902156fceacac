"""Pages of results: what they are made of, what an index tells, and whether two results agree."""

import re
import shlex
import subprocess
import sys
from html import unescape

import numpy as np
import pytest

from bench.commands.folders import folders
from bench.commands.open import open_page
from bench.plan.page import Page, Prose, Section, Table
from bench.reports.comparison.comparison import difference
from bench.reports.pages.bundle import asset
from bench.reports.pages.document import document, facts_of
from bench.reports.pages.index import index_page, page_facts, write_index
from bench.reports.pages.prose import columns_of
from bench.reports.response_blocks import orbits
from ksmea.errors import SettingError
from ksmea.records.estimate import Shown
from ksmea.show.charts.colours import CATEGORIES, DARK, GROUND, LIGHT
from ksmea.show.charts.responses import Response
from ksmea.show.text import aligned

SERIES = ("model", "measured", "interval", "paper", "reference", "context", "alike", "ink")
HOSTILE = "</script><img src=x onerror=alert(1)>\u202e"
IDENTIFY = [
    "+experiment=identify", "measurement=synthetic", "measurement.kind=complex", "measurement.relative=0.05",
    "optimizer.screening=200", "optimizer.starts=2", "workers=1",
]  # fmt: skip


def luminance(colour):
    """Relative luminance of sRGB (WCAG 2.2)."""
    digits = colour.lstrip("#")
    digits = "".join(2 * each for each in digits) if len(digits) == 3 else digits
    parts = np.array([int(digits[at : at + 2], 16) / 255 for at in (0, 2, 4)])
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return linear @ (0.2126, 0.7152, 0.0722)


def contrast(one, other):
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def variables():
    """The colours of the page, light and dark, by name."""
    blocks = re.findall(r":root \{([^}]*)\}", asset("page.css"))
    return [dict(re.findall(r"--(\w+): (#\w+)", block)) for block in blocks]


def test_colours_are_seen_in_light_and_in_dark():
    light, dark = variables()[:2]
    assert dark["ground"] != light["ground"]
    for theme in (light, dark):
        for text in ("ink", "muted", "link"):
            for ground in ("ground", "raised"):
                assert contrast(theme[text], theme[ground]) >= 4.5, (text, ground)  # WCAG 2.2, 1.4.3 (AA)
        assert contrast(theme["ink"], theme["button"]) >= 4.5
    for theme, colours in ((light, LIGHT), (dark, DARK)):
        assert colours[GROUND] == (theme["ground"] + "fff")[:7]
        for colour in [*CATEGORIES, *SERIES]:
            assert contrast(colours[colour], theme["ground"]) >= 3, colour  # 1.4.11, graphics
    on_dark = {}
    for role, on_white in LIGHT.items():  # a page replaces colours by what they are on white
        assert on_dark.setdefault(on_white, DARK[role]) == DARK[role]
    assert len(set(on_dark.values())) == len(on_dark)  # and what it saves is as on white again


def test_hostile_texts_stand_on_the_page_as_text():
    import pandas as pd

    sections = [Section(HOSTILE, (Prose(HOSTILE), Table(pd.DataFrame({HOSTILE: [HOSTILE]}), HOSTILE)))]
    page = document(HOSTILE, Page(HOSTILE, about=HOSTILE), sections, {"name": HOSTILE}, {}).decode()
    assert "<img" not in page and "\u202e" not in page and page.count("</script>") == 1
    assert facts_of(page)["name"] == HOSTILE


@pytest.mark.parametrize(
    "rows", [[["kxx", "50.01", "[49.9, 50.1]"], ["", "7", "–"]], [["a b c", "", "x"], ["d", "", "y z"]]]
)
def test_aligned_columns_become_the_table_that_they_were(rows):
    head = ["name", "value", "interval"]
    assert columns_of(aligned(head, rows).splitlines()) == [head, *rows]


def test_two_identifications_from_their_pages_to_the_comparison(enter, monkeypatch):
    ended = enter(*IDENTIFY, output="results/identify")
    assert ended.code == 0, ended.err
    page = ended.output / "index.html"
    first = page.read_bytes()
    assert enter("collect", "identify").code == 0 and page.read_bytes() == first  # the same records, the same bytes
    facts = facts_of(first[:8192].decode("utf-8", "ignore"))
    assert (
        facts["failed"] == 0
        and facts["runs"] == 1
        and facts["headline"].startswith("All 5 unknowns are known: kxx, kyy to ")
    )
    text = unescape(first.decode())
    assert all(each in text for each in ("95 % interval [", "commit ", "+experiment=plan", "measurement.relative=0.05"))
    index = (ended.output.parent / "index.html").read_text()
    assert 'href="identify/index.html"' in index and "unknowns are known" in index

    enter(*IDENTIFY, "seed=1", "output=results/two")
    compared = enter("compare", "identify", "two", output="results/compare_identify_two")
    assert compared.code == 0, compared.err
    assert "combined standard deviations" in compared.out and re.search(r"seed +0 +1", compared.out)
    assert {path.name for path in compared.output.iterdir()} == {"compare.csv", "index.html"}
    same = enter("compare", "identify", "identify").out
    assert "all 5 parameters" in same and "No setting that both have differs" in same and "same data" in same
    refused = enter("compare", "identify")
    assert refused.code == 2 and "expected two names" in refused.err

    def fails(*arguments):
        raise ValueError("no such luck")

    monkeypatch.setattr("bench.reports.identification.report.identification_page", fails)
    ended = enter("collect", "identify", output="results/identify")
    assert ended.code == 0 and "index.html: cannot be drawn (ValueError: no such luck)" in ended.err
    assert (ended.output / "identify.csv").is_file() and not page.exists()


def test_what_writes_pages_imports_no_plotly():
    code = "import sys, bench.reports.collect, bench.reports.pages.bundle as b; b.packed(); sys.exit('plotly' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_page_of_others_is_not_replaced_by_an_index(tmp_path):
    (tmp_path / "index.html").write_text("<p>mine</p>")
    with pytest.raises(SettingError, match="found another page"):
        write_index(tmp_path)
    assert (tmp_path / "index.html").read_text() == "<p>mine</p>"


def test_an_index_tells_of_folders_whose_plan_or_page_is_broken(tmp_path):
    for name, plan, page in (("<b>", "{", None), ("b", '{"name": 3}\n', '<meta name="ksmea-bench" content="[]">')):
        (tmp_path / name).mkdir()
        (tmp_path / name / "plan.jsonl").write_text(plan)
        if page:
            (tmp_path / name / "index.html").write_text(page)
    page = index_page(tmp_path).decode()
    assert "&lt;b&gt;" in page and "<b>" not in page and page.count("No page yet") == 2


def test_an_index_names_the_command_that_finds_a_nested_folder(tmp_path, monkeypatch):
    folder = tmp_path / "results" / "both" / "the 2nd"
    folder.mkdir(parents=True)
    (folder / "plan.jsonl").write_text('{"name": "x"}\n')
    monkeypatch.chdir(tmp_path)
    command = str(page_facts(folder)["headline"]).partition(": ")[2]
    assert folders(shlex.split(command)[4:], "collect") == [folder.relative_to(tmp_path)]


def test_orbits_of_a_skew_pair_are_those_of_x_and_y():
    xy = np.array([[3.0 + 1j, -2j], [1.0, 2.0 - 1j]])
    turn = np.array([[1.0, 1.0], [1.0, -1.0]]) / np.sqrt(2)  # what probes at 45° and −45° read of x and y
    drawn = [
        orbits(
            Response(
                np.array([1e3, 2e3]), channels, values, has_phase=True, sd=None, curves={}, at_speeds={"m": values}
            )
        )
        for channels, values in (
            (("x at 0.1 m", "y at 0.1 m"), xy),
            (("45° at 0.1 m", "-45° at 0.1 m"), xy @ turn.T),
        )
    ]
    assert list(drawn[0].planes) == list(drawn[1].planes) == ["0.1 m"]
    assert np.array(drawn[1].planes["0.1 m"]["measured"]) == pytest.approx(
        np.array(drawn[0].planes["0.1 m"]["measured"])
    )
    one_way = Response(np.array([1e3]), ("45° at 1 m", "-135° at 1 m"), xy[:1], True, None, {}, {})
    assert not one_way.planes()


def test_open_says_where_the_page_lies_without_a_display(tmp_path, monkeypatch, capsys):
    for name in ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SettingError, match="run an experiment first"):
        open_page([])
    (tmp_path / "results").mkdir()
    monkeypatch.setattr("sys.platform", "linux")
    assert open_page([]) == 0 and "no browser here" in capsys.readouterr().out
    assert (tmp_path / "results" / "index.html").is_file()
    opened = []
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr("webbrowser.open", lambda address: opened.append(address) or True)
    assert open_page([]) == 0 and opened == [(tmp_path / "results" / "index.html").as_uri()]


def test_a_difference_is_in_combined_standard_deviations():
    """95 % half-widths of 1.96 are standard deviations of 1: two of them, √2 combined."""
    one, other = (Shown(value, value - 1.959964, value + 1.959964, "N") for value in (10.0, 13.0))
    assert difference(one, other) == pytest.approx(3 / np.sqrt(2), rel=1e-6)
    assert difference(other, one) == pytest.approx(-3 / np.sqrt(2), rel=1e-6)
    open_above = Shown(10.0, 9.0, np.nan, "N")  # the side that faces the other
    assert np.isnan(difference(open_above, other)) and not np.isnan(difference(Shown(20.0, 9.0, np.nan, "N"), other))


def test_a_report_that_tells_nothing_of_a_page_has_one(plan):
    import pandas as pd

    from bench.plan.report import Made
    from bench.reports.pages.experiment import experiment_page

    runs = pd.DataFrame({"key": ["a", "b"], "status": ["done", "error"], "error": ["", HOSTILE]})
    page = experiment_page(plan, Made("found <it>", {}, runs), {"x.png": b"png"}, "").decode()
    assert "found &lt;it&gt;" in page and "explain b" in page and "<img src=x" not in page and "data:image/png" in page


def test_the_file_of_a_page_is_named_once():
    for title, shown in (("diagnose: a.csv", "diagnose: a.csv · 75 speeds"), ("two", "two · a.csv · 75 speeds")):
        page = document(title, Page("it fits", about="a.csv · 75 speeds"), (), {}, {}).decode()
        assert f'<p class="about">{shown}</p>' in page


def test_a_headline_stands_first():
    page = document("x", Page("it fits"), (Section("a", ()),), {}, {}).decode()
    assert page.index("<h1>It fits</h1>") < page.index("<main>")

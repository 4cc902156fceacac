"""Pages as a browser shows them: nothing from a network, no error, controls that work, narrow, dark and printed."""

import base64
import shutil
from pathlib import Path

import pandas as pd
import pytest

from bench.reports.pages.experiment import PAGE
from bench.reports.pages.index import write_index
from browser import browser, errors, overflow, requests, shown
from ksmea.show.charts.colours import DARK, LIGHT, MEASURED, MODEL

CHEAP = ["optimizer.screening=200", "optimizer.starts=2", "workers=1"]
HOSTILE = "<img src=x onerror=window.hit=1>.csv"

WebDriverWait = pytest.importorskip("selenium.webdriver.support.ui").WebDriverWait

pytestmark = pytest.mark.xdist_group("browser")


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    with browser(tmp_path_factory.mktemp("browser")) as opened:
        yield opened


@pytest.fixture(scope="module")
def identified(apart, tmp_path_factory):
    """The page of an identification of complex data at two planes."""
    words = ["+experiment=identify", "measurement=synthetic", "measurement.kind=complex", "measurement.relative=0.05"]
    ended = apart(
        *words,
        *CHEAP,
        "problem.sensors=[0.1,0.5]",
        draws=True,
        cwd=tmp_path_factory.mktemp("page"),
        output="results/identify",
    )
    assert ended.code == 0, ended.err
    return ended.output / PAGE


@pytest.fixture(scope="module")
def many(apart, tmp_path_factory):
    """Page of four planes: eight channels are too many to be seen at once."""
    words = ["+experiment=identify", "measurement=synthetic", "measurement.kind=complex", "measurement.relative=0.05"]
    words += ["problem.sensors=[0.1,0.2,0.5,1.0]", "study.intervals=none"]
    ended = apart(*words, *CHEAP, draws=True, cwd=tmp_path_factory.mktemp("many"), output="results/identify")
    assert ended.code == 0, ended.err
    return ended.output / PAGE


@pytest.mark.parametrize(("width", "dark"), [(1200, False), (400, True)])
def test_it_is_drawn_without_an_error_or_a_network(driver, identified, width, dark):
    shown(driver, identified, width, dark)
    assert errors(driver) == [] and requests(driver) == [] and overflow(driver) <= 0
    plots = driver.execute_script("return document.querySelectorAll('figure.plot .canvas .main-svg').length")
    assert plots >= 4 and driver.execute_script("return document.querySelector('.still').hidden")
    ground = driver.execute_script("return getComputedStyle(document.body).backgroundColor")
    ink = driver.execute_script("return getComputedStyle(document.querySelector('.canvas .xtick text')).fill")
    assert (ground, ink) == (
        ("rgb(20, 24, 28)", "rgb(230, 232, 234)") if dark else ("rgb(255, 255, 255)", "rgb(26, 29, 33)")
    )


COLOURS = """
const named = (name) => [...document.querySelectorAll('figure.plot .canvas')].flatMap((canvas) => canvas.data ?? []).find((trace) => trace.name === name);
return [named("measured").marker.color, named("fitted").line.color];
"""


def test_figures_change_their_colours_with_the_system_and_are_printed_light(driver, identified):
    light, dark = ([colours[role] for role in (MEASURED, MODEL)] for colours in (LIGHT, DARK))
    shown(driver, identified, 1200)
    assert driver.execute_script(COLOURS) == light
    for scheme, expected in (("dark", dark), ("light", light), ("dark", dark)):
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "", "features": features})
        WebDriverWait(driver, 30).until(lambda _, expected=expected: driver.execute_script(COLOURS) == expected)
    driver.execute_script("dispatchEvent(new Event('beforeprint'))")
    assert driver.execute_script(COLOURS) == light
    driver.execute_script("dispatchEvent(new Event('afterprint'))")
    assert driver.execute_script(COLOURS) == dark and errors(driver) == []


SEEN = "return [...arguments[0].data].filter((trace) => trace.visible !== false).map((trace) => trace.meta?.channel)"


@pytest.mark.parametrize("width", [1200, 400])
def test_controls_work(driver, many, width):
    shown(driver, many, width)
    canvas = driver.find_element("css selector", "figure:has(select[data-key=channel]) .canvas")
    choose = "const s = arguments[0].closest('figure').querySelector('select'); s.value = arguments[1]; s.dispatchEvent(new Event('change'));"
    assert set(driver.execute_script(SEEN, canvas)) == {"x at 0.1 m"}  # of eight channels the first
    driver.execute_script(choose, canvas, "y at 0.5 m")
    assert set(driver.execute_script(SEEN, canvas)) == {"y at 0.5 m"}
    assert (
        len(driver.execute_script("return arguments[0].layout.shapes.filter(({ yref }) => yref === 'y3')", canvas)) == 2
    )
    span = "const [a, b] = arguments[0]._fullLayout.xaxis.range; return b - a"
    press = "arguments[0].closest('figure').querySelector(`button[data-do=${arguments[1]}]`).click()"
    whole = driver.execute_script(span, canvas)
    back = driver.find_element("css selector", "figure:has(select[data-key=channel]) button[data-do=reset]")
    assert not back.is_displayed()
    driver.execute_script("Plotly.relayout(arguments[0], {'xaxis.range': [2000, 3000]})", canvas)
    assert driver.execute_script(span, canvas) == pytest.approx(1000)
    assert back.is_displayed()
    driver.execute_script(press, canvas, "reset")
    assert driver.execute_script(span, canvas) == pytest.approx(whole, rel=1e-6)
    move = "const s = document.querySelector('[data-orbit]'); s.value = 3; s.dispatchEvent(new Event('input')); return document.querySelector('output').textContent"
    said = driver.execute_script(move)
    assert "rpm" in said and said.count("whirl") == 4  # of four planes


def test_each_figure_is_saved_as_picture_and_as_its_own_numbers(driver, many, tmp_path):
    shown(driver, many, 1200)
    driver.execute_cdp_cmd("Browser.setDownloadBehavior", {"behavior": "allow", "downloadPath": str(tmp_path)})
    figures = driver.find_elements("css selector", "figure.plot")
    assert all(figure.find_element("css selector", ".save").is_displayed() for figure in figures)
    figure = driver.find_element("css selector", "figure:has(select[data-key=channel])")
    name = figure.get_attribute("data-name")
    for kind, begins in (("png", b"\x89PNG"), ("svg", b"<svg"), ("csv", b"x axis,y axis,series")):
        driver.execute_script("arguments[0].click()", figure.find_element("css selector", f".save [data-do={kind}]"))
        file = tmp_path / f"{name}.{kind}"
        WebDriverWait(driver, 30).until(lambda _, file=file: file.exists() and file.stat().st_size)
        assert file.read_bytes().startswith(begins)
    saved = pd.read_csv(tmp_path / f"{name}.csv")
    shown_points = driver.execute_script(
        "return arguments[0].data.filter((each) => each.visible !== false).map((each) => [each.name, [...each.x], [...each.y]])",
        figure.find_element("css selector", ".canvas"),
    )
    expected = [
        (name, x, y) for name, xs, ys in shown_points for x, y in zip(xs, ys) if x is not None and y is not None
    ]
    assert len(saved) == len(expected)
    assert saved["x"].to_numpy() == pytest.approx([x for _, x, _ in expected])
    assert saved["y"].to_numpy() == pytest.approx([y for *_, y in expected])
    assert saved["series"].fillna("").tolist() == [name or "" for name, *_ in expected]
    assert set(saved["x axis"]) == {"speed (rpm)"} and "amplitude (µm 0-peak)" in set(saved["y axis"])
    assert errors(driver) == [] and requests(driver) == []


@pytest.mark.slow
def test_a_table_that_is_wider_than_the_page_says_so(driver, identified):
    wide = "return [...document.querySelectorAll('.scroll')].map((box) => box.scrollWidth > box.clientWidth + 1)"
    told = "return [...document.querySelectorAll('.more')].map((said) => !said.hidden)"
    for width in (400, 1200):
        shown(driver, identified, width)
        driver.execute_script("for (const each of document.querySelectorAll('details')) each.open = true")
        both = f"const told = () => {{ {told} }}, wide = () => {{ {wide} }}; return [told(), wide()]"
        WebDriverWait(driver, 30).until(
            lambda _, both=both: len({str(each) for each in driver.execute_script(both)}) == 1
        )
        assert any(driver.execute_script(told)) == (width == 400)


def test_tables_are_sorted_by_a_button(driver, identified):
    shown(driver, identified, 1200)
    first = "return document.querySelector('table').tBodies[0].rows[0].cells[0].textContent"
    press = "document.querySelector('table th button').click()"
    assert driver.execute_script(first) == "kxx"
    driver.execute_script(press)
    assert driver.execute_script(first) == "cxx"
    driver.execute_script(press)
    assert driver.execute_script(first) == "u"


@pytest.mark.slow
def test_it_is_printed_light_and_whole(driver, identified):
    shown(driver, identified, 1200, dark=True)
    printed = driver.execute_cdp_cmd("Page.printToPDF", {"printBackground": True})
    assert base64.b64decode(printed["data"]).startswith(b"%PDF")
    driver.execute_cdp_cmd(
        "Emulation.setEmulatedMedia",
        {"media": "print", "features": [{"name": "prefers-color-scheme", "value": "dark"}]},
    )
    ground = driver.execute_script("return getComputedStyle(document.body).backgroundColor")
    assert ground == "rgb(255, 255, 255)" and errors(driver) == []
    assert not driver.find_element("css selector", ".controls").is_displayed()


@pytest.mark.slow
def test_markup_in_names_does_nothing(driver, apart, identified, tmp_path):
    fleet = tmp_path / "fleet"
    fleet.mkdir()
    root = Path(__file__).parents[2]
    shutil.copy(root / "docs/examples/run_up.csv", fleet / HOSTILE)
    words = ["+experiment=identify", "problem.sensors=[0.1]", "measurement.path=fleet/*.csv", *CHEAP]
    ended = apart(*words, draws=True, cwd=tmp_path, output="results/identify_fleet")
    shown(driver, ended.output / PAGE, 1200)
    assert errors(driver) == [] and requests(driver) == []
    assert driver.execute_script("return window.hit === undefined && !document.querySelector('img[src=x]')")
    assert HOSTILE in driver.find_element("css selector", "main").text
    shown(driver, ended.output.parent / PAGE, 400)
    assert errors(driver) == [] and requests(driver) == [] and overflow(driver) <= 0


def test_a_narrow_index_shows_every_result_whole(driver, tmp_path):
    """No box of it scrolls sideways; runs and failures are told beside their numbers."""
    for name in ("diagnose_" + "x" * 60, "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "plan.jsonl").write_text('{"name": "diagnose"}\n')
    shown(driver, write_index(tmp_path), 400)
    scrolls = (
        "return [...document.querySelectorAll('.scroll')].filter((box) => box.scrollWidth > box.clientWidth + 1).length"
    )
    assert overflow(driver) <= 0 and driver.execute_script(scrolls) == 0 and errors(driver) == []
    shown(driver, tmp_path / "index.html", 1200)
    assert driver.execute_script("return getComputedStyle(document.querySelector('.index tr')).display") == "table-row"

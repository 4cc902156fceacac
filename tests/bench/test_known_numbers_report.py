"""Reports of a rotor with tolerances, as the quick start has them: text, tables, figures and page."""

import re

import pytest

FILE = "docs/examples/drawn.yaml"


@pytest.fixture
def report(enter, pytestconfig):
    """The command of the page, with further words."""

    def made(experiment, *words):
        rotor = f"problem.file={pytestconfig.rootpath / FILE}"
        command = [
            f"+experiment={experiment}",
            "problem=rotor",
            rotor,
            "measurement.relative=0.05",
            "workers=1",
            *words,
        ]
        ended = enter(*command, output=f"results/{experiment}")
        assert ended.code == 0
        return ended

    return made


def test_identifiability_weighs_a_better_drawing(report):
    ended = report("identifiability", "study.variations=[numbers]")
    assert (
        "kxx: 95 % of its variance by these numbers, 5 % by noise; measure the density of steel better (60 %)"
        in ended.out
    )
    assert re.search(r"present +2 ", ended.out) and re.search(r"density of steel +1 ", ended.out)
    assert re.search(r"all numbers +0\.1 ", ended.out)
    rows = ended.table("identifiability").query("variation == 'numbers' and parameter == 'kxx'")
    assert len(rows) == 14 and rows["crlb_pct"].to_numpy()[-1] == pytest.approx(0.1 / 1.96, rel=0.06)  # one digit shown
    assert (ended.output / "identifiability.png").exists()
    page = (ended.output / "index.html").read_text(encoding="utf-8")
    assert "number that is exact" in page and "measure the density of steel better" in page


def test_a_plan_says_what_measuring_the_drawing_is_worth(report):
    ended = report("plan", "study.target=kxx")
    of_numbers = re.search(r"- measure the density of steel.*", ended.out)[0]
    assert "(−78 %)" in of_numbers and of_numbers.endswith("repeating the present run instead: −1.7 %")
    assert "(−19 %)" in re.search(r"- add a second run.*", ended.out)[0]
    rows = ended.table("plan").query("family == 'numbers' and parameter == 'kxx'")
    assert rows["number"].tolist() == ["density of steel", "mass of disk 3", "Young’s modulus of steel"]
    page = (ended.output / "index.html").read_text(encoding="utf-8")
    assert "number that is exact" in page and "until they are as good as exact" in page

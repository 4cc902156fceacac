"""The page on models of other programs: its command prints what it shows, and what it writes is diagnosed."""

import shutil

import pytest

from bench import main
from problems.rotor_file import RotorFile
from shown_output import require_shown
from shown_pages import DOCS, blocks, commands, text_of

PAGE = DOCS / "import_rotor.md"
MOST_WORDS = 500
SHAFT = (
    "element,layer,length [mm],outer_diameter_left [mm],outer_diameter_right [mm],young_modulus [GPa],density [kg/m3],shear_modulus [GPa]\n"
    + "".join(f"{element},1,80,40,40,210,7850,80\n" for element in range(1, 9))
)
DISKS = "station,mass [kg],polar_inertia [kg m2],diametral_inertia [kg m2]\n4,5,0.02,0.01\n"
BEARING = "speed [rpm],kxx [N/m],kyy [N/m],cxx [N s/m],cyy [N s/m]\n1000,1e7,2e7,1e3,2e3\n4000,2e7,3e7,1e3,2e3\n"


@pytest.fixture
def shown(tmp_path, monkeypatch):
    """Words of the page's imports, in a reader's working directory."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "docs").mkdir()
    shutil.copytree(DOCS / "examples", tmp_path / "docs" / "examples")
    for name, text in (("shaft", SHAFT), ("disks", DISKS), ("left", BEARING), ("right", BEARING)):
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    return [list(command.words[3:]) for command in commands(PAGE) if command.words[3:5] == ("import", "rotor")]


def test_the_model_of_the_page_is_imported_as_it_shows(shown, capsys):
    assert main.run(shown[0]) == 0
    [transcript] = blocks(text_of(PAGE), "text")
    require_shown(transcript, capsys.readouterr().out)


def test_a_plane_of_unbalance_is_all_that_a_diagnosis_asks_for(shown):
    assert "--unbalance" in shown[1] and main.run(shown[1]) == 0
    problem = RotorFile(file="pump.yaml").build()
    assert problem.parameters.names == ("u1", "stiffness1", "damping1", "stiffness2", "damping2")


def test_tables_are_imported_as_the_page_says(shown):
    assert main.run(shown[2]) == 0
    rotor = RotorFile(file="pump.yaml").build().rotor
    assert [each.position for each in rotor.bearings] == pytest.approx([0.08, 0.64])


def test_the_page_is_short():
    assert len(text_of(PAGE).split()) <= MOST_WORDS

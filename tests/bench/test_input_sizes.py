"""Files that are too large are refused by their size, before they are read or unpacked."""

import io
import os
import struct
import tracemalloc
import zlib

import numpy as np
import pytest
from scipy.io import savemat

from ksmea.errors import SettingError
from ksmea.settings.regular_files import read_input
from measurements.campaign import CampaignFile
from measurements.formats.binary import mat
from measurements.formats.binary.mat import read_mat
from tiers import mostly_slow

GIGABYTES = 3 * 2**30
MEMORY = 200 * 2**20  # bytes that a refusal may take: far less than what is refused


@pytest.mark.parametrize(
    ("file", "words"),
    mostly_slow(
        [
            ("rotor.yaml", ["problem=rotor", "problem.file=rotor.yaml"]),
            ("extended.yaml", ["problem=extended", "problem.file=extended.yaml"]),
            ("campaign.yaml", ["measurement=campaign", "measurement.path=campaign.yaml"]),
            *(
                (f"run.{kind}", ["measurement=file", f"measurement.path=run.{kind}"])
                for kind in ("csv", "mat", "xlsx", "uff")
            ),
            ("run.mat", ["import", "run.mat", "--out", "run.csv"]),
            ("model.toml", ["import", "rotor", "model.toml", "--out", "rotor.yaml"]),
        ],
        but=["rotor.yaml", "run.csv", "run.xlsx"],
    ),
)
def test_a_file_of_gigabytes_is_not_read(file, words, enter, tmp_path):
    (tmp_path / file).touch()
    os.truncate(tmp_path / file, GIGABYTES)  # it takes no room on the disk
    tracemalloc.start()
    ended = enter(*words)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert ended.code == 2 and ended.err.count("\n") == 1 and file in ended.err and "expected at most" in ended.err
    assert peak < MEMORY


def test_a_file_without_a_size_of_its_own_is_not_read_for_ever():
    with pytest.raises(SettingError, match="at most 3 bytes, got 4"):
        read_input("/proc/self/status", "text", 3, "expected at most 3 bytes, got {}".format)


def saved(**variables):
    file = io.BytesIO()
    savemat(file, variables, do_compression=True)
    return file.getvalue()


def test_compressed_variables_count_together(monkeypatch):
    """Each is small enough, all of them are not; they are counted block by block, before SciPy unpacks any."""
    monkeypatch.setattr(mat, "MOST_UNPACKED", 32 * 2**20)
    content = saved(**{f"v{number}": np.zeros(2**20) for number in range(8)})
    assert len(content) < 2**20
    tracemalloc.start()
    with pytest.raises(SettingError, match="whole variables of at most 32 MB, got more"):
        read_mat(content, "run.mat", [])
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 8 * 2**20
    assert len(read_mat(saved(**{f"v{number}": np.zeros(2**20) for number in range(3)}), "run.mat", []).columns) == 3


def test_whole_numbers_count_as_what_they_become(monkeypatch):
    monkeypatch.setattr(mat, "MOST_UNPACKED", 2**20)
    with pytest.raises(SettingError, match="expected at most 1 MB of numbers, got more"):
        read_mat(saved(n=np.zeros(2**18, dtype=np.int8)), "run.mat", [])


def test_a_stream_that_ends_early_or_is_none():
    whole = zlib.compress(bytes(10**6))
    for body, line in (
        (whole[:-9], "a variable that ends early"),
        (b"", "a variable that ends early"),
        (b"x" * 9, "Error -3"),
    ):
        content = b"MATLAB 5.0".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(body)) + body
        with pytest.raises(SettingError, match=line):
            read_mat(content, "run.mat", [])


def test_the_data_files_of_a_campaign_count_together(tmp_path):
    for number in range(5):
        (tmp_path / f"{number}.csv").touch()
        os.truncate(tmp_path / f"{number}.csv", 63 * 2**20)
    runs = "\n".join(f"  - {{name: r{number}, file: {number}.csv}}" for number in range(5))
    (tmp_path / "campaign.yaml").write_text(f"runs:\n{runs}\n")
    with pytest.raises(SettingError, match=r"campaign\.yaml: expected at most 256 MB of data files, got 315 MB"):
        CampaignFile(path=str(tmp_path / "campaign.yaml")).read()

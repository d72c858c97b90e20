"""The example that fits a policy to choices finds parameters that are known."""

import subprocess
import sys
from pathlib import Path

import pytest
from builders import play_study, small_study, write_study

ROOT = Path(__file__).parents[1]


def test_it_finds_the_parameters_of_the_agent_that_played(tmp_path):
    played = small_study(("cognitive:softmax-memory?failure=3&recent=-2",), (0.0, 0.4), 1, 25)
    directory = write_study(tmp_path / "study", played, play_study(played))
    line = [sys.executable, ROOT / "examples/fit_policy.py", directory, "--agent", *played.agents]
    said = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    found = dict(word.rstrip(",").split(" ") for word in said.partition(": ")[2].splitlines()[0].split(", "))
    assert float(found["failure"]) == pytest.approx(3, abs=0.6)
    assert float(found["recent"]) == pytest.approx(-2, abs=0.6)
    fitted, blind = (float(part.split(" ")[-1].rstrip(".")) for part in said.splitlines()[1].split(";"))
    assert fitted > blind + 100

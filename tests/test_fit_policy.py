"""The example that fits a policy to choices finds parameters that are known."""

import runpy
from pathlib import Path

import pytest
from builders import play_study, small_study, write_study

EXAMPLE = Path(__file__).parents[1] / "examples" / "fit_policy.py"


def test_it_finds_the_parameters_of_the_agent_that_played(tmp_path, monkeypatch, capsys):
    played = small_study(("cognitive:softmax-memory?failure=3&recent=-2",), (0.0, 0.4), 1, 15)
    directory = write_study(tmp_path / "study", played, play_study(played))
    monkeypatch.setattr("sys.argv", [str(EXAMPLE), str(directory), "--agent", *played.agents])
    runpy.run_path(str(EXAMPLE), run_name="__main__")
    first, second = capsys.readouterr().out.splitlines()
    found = dict(word.split(" ") for word in first.partition(": ")[2].split(", "))
    assert float(found["failure"]) == pytest.approx(3, abs=0.6)
    assert float(found["recent"]) == pytest.approx(-2, abs=0.6)
    fitted, blind = (float(part.split(" ")[-1].rstrip(".")) for part in second.split(";"))
    assert fitted > blind + 100

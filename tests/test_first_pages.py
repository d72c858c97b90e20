"""What the first pages say of their studies is what these studies give, with the commands that the pages show."""

import re
from functools import cache
from pathlib import Path
from statistics import fmean
from tempfile import TemporaryDirectory

import pytest
from typer.testing import CliRunner

import lockprobe
from lockprobe.analysis.loops import any_loop
from lockprobe.analysis.proportions import difference, proportion
from lockprobe.cli import build
from lockprobe.studies.studyfile import study

ROOT = Path(__file__).parents[1]
PAGE = "curves-and-causes.md"


def text_of(name):
    return " ".join((ROOT / "docs" / name).read_text("utf-8").split())


@cache
def trials(agents, **options):
    with TemporaryDirectory() as directory:
        return lockprobe.run_study(study("flips", agent=agents, **options), Path(directory) / "study")


def solved(agent, rate, /, agents, **options):
    return sum(trial.solved for trial in trials(agents, **options) if (trial.agent, trial.p) == (agent, rate))


def test_the_first_study():
    first = ("human-inspired", "random")
    counts = [solved("human-inspired", p, first) for p in (0.0, 0.6)]
    assert "It solves {} of 18 trials when told the truth and {} of 18 at".format(*counts) in text_of("start.md")
    (blind,) = {solved("random", p, first) for p in (0.0, 0.2, 0.4, 0.6)}
    assert f"and solves {blind} of 18 at every flip rate" in text_of("start.md")
    assert len(trials(first)) == 2 * 72


def test_more_trials_show_the_effect():
    counts = [solved("human-inspired", p, ("human-inspired",), p=(0, 0.6), trials=20) for p in (0, 0.6)]
    assert "solves {} of 60 trials when told the truth and {} of 60 at".format(*counts) in text_of("start.md")
    assert difference(proportion(counts[0], 60), proportion(counts[1], 60)).high < 0


def test_the_trial_that_is_watched(tmp_path):
    (wanted,) = re.findall(r"replay first '(.*?)'$", (ROOT / "docs/start.md").read_text("utf-8"), re.MULTILINE)
    lockprobe.run_study(study("flips", agent=("human-inspired", "random")), tmp_path / "first")
    printed = CliRunner().invoke(build(["replay"]), ["replay", str(tmp_path / "first"), wanted]).output
    (shown,) = re.findall(
        r"^```text\n(.*?)^```$", (ROOT / "docs/start.md").read_text("utf-8"), re.MULTILINE | re.DOTALL
    )
    assert shown.splitlines() == [line.rstrip() for line in printed.splitlines()[1:5]]
    assert (
        re.search(r"solved after (\d+) steps", printed)[1]
        == re.search(r"solves this box at step (\d+)", text_of("start.md"))[1]
    )


CURVES = {"agents": ("world:loop-breaker", "cognitive:perseverant"), "p": (0, 0.4), "trials": 100}


@pytest.mark.parametrize(
    ("agent", "said"),
    [("world:loop-breaker", "goes from {} to {} of 300 trials solved"), ("cognitive:perseverant", "from {} to {}.")],
)
def test_two_curves_of_different_cause_rise(agent, said):
    assert f"`{agent}` " + said.format(*(solved(agent, p, **CURVES) for p in (0, 0.4))) in text_of(PAGE)


def test_loops_become_rarer_in_the_agent_that_lies_help_by_what_they_say():
    looping, steps = {}, {}
    for agent in CURVES["agents"]:
        for p in (0, 0.4):
            sequences = [trial.actions for trial in trials(**CURVES) if (trial.agent, trial.p) == (agent, p)]
            looping[agent, p] = sum(any_loop(one) for one in sequences)
            steps[agent, p] = fmean(map(len, sequences))
    said = "`cognitive:perseverant` falls from {} to {} of 300 trials".format(
        *(looping["cognitive:perseverant", p] for p in (0, 0.4))
    )
    assert said in text_of(PAGE)
    said = "{} of 300 trials at a flip rate of 0 and {} at 0.4".format(
        *(looping["world:loop-breaker", p] for p in (0, 0.4))
    )
    assert said in text_of(PAGE)
    said = "from {:.1f} to {:.1f} steps on average".format(*(steps["cognitive:perseverant", p] for p in (0, 0.4)))
    assert said in text_of(PAGE)

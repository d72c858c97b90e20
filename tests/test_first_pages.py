"""What the first pages say of their studies is what these studies give, with the commands that the pages show."""

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from placeholders import undrawn
from typer.testing import CliRunner

import lockprobe
from lockprobe.cli import build
from lockprobe.foundation.formatting import p_cell
from lockprobe.report.rows.primary import primary_lines
from lockprobe.report.table_rows import points_cell, share_of_row
from lockprobe.studies.options.studyfile import study

ROOT = Path(__file__).parents[1]


def text_of(name):
    return " ".join((ROOT / "docs" / name).read_text("utf-8").split())


FIRST = ("cognitive:perseverant", "human-inspired", "random")


def flips_alone(agents):
    """The study of the first command without its other conditions, which change no number of these."""
    whole = study("flips", agent=agents)
    fresh = tuple(one for one in whole.conditions if one.label in whole.flip_labels)
    return replace(whole, conditions=fresh, strategy_conditions=())


@pytest.mark.slow
def test_the_first_study(tmp_path):
    played = lockprobe.run_study(flips_alone(FIRST), tmp_path / "first")
    page = (ROOT / "docs/start.md").read_text("utf-8")
    solved = Counter((trial.agent, trial.p) for trial in played if trial.solved)
    for agent in FIRST:
        (row,) = re.findall(rf"^\| `{re.escape(agent)}` \|.*$", page, re.MULTILINE)
        assert row.endswith("| {} | {} | {} | {} |".format(*(solved[agent, p] for p in (0.0, 0.2, 0.4, 0.6))))
    assert (len(played), study("flips", agent=FIRST).size) == (3 * 4 * 300, 3 * 8 * 300)


def test_the_answer_that_the_readme_quotes(tmp_path):
    """The first command plays the same trials of these two agents, and more."""
    lockprobe.run_study(flips_alone(FIRST[:2]), tmp_path / "first")
    with undrawn():
        found = lockprobe.results(tmp_path / "first")
    page = (ROOT / "README.md").read_text("utf-8")
    (quoted,) = re.findall(r"^> (False .*)", page, re.MULTILINE)
    assert found.answer == quoted
    for line in primary_lines(found):
        shares = [share_of_row(row) for row in (line.first, line.second)]
        change = [points_cell(line.change), p_cell(line.change.p_value), line.verdict]
        assert f"| {' | '.join([line.label, *shares, *change])} |" in page


def test_the_groups_of_a_lesson_find_what_it_says(tmp_path):
    said = r"play the same study with (\d+), (\d+) and (\d+) trials per repetition: .* --p 0,0\.6 --seed (\d+) --trials (\d+) --out group-1"
    ((*sizes, seed, typed),) = [map(int, found) for found in re.findall(said, text_of("teaching.md"))]
    answers = []
    for size in sizes[:2]:  # the third has more trials of the same
        planned = study("flips", agent=("human-inspired", "random"), p=(0, 0.6), trials=size, seed=seed)
        lockprobe.run_study(planned, tmp_path / str(size))
        with undrawn():
            answers.append(lockprobe.results(tmp_path / str(size)).answer.split()[0])
    assert answers == ["No", "False"]
    assert typed == sizes[0]


def test_the_trial_that_is_watched(tmp_path):
    (wanted,) = re.findall(r"replay first '(.*?)'$", (ROOT / "docs/start.md").read_text("utf-8"), re.MULTILINE)
    lockprobe.run_study(study("flips", agent=FIRST, p=[0.4], trials=10, repetitions=1), tmp_path / "first")
    printed = CliRunner().invoke(build(["replay"]), ["replay", str(tmp_path / "first"), wanted]).output
    (shown,) = re.findall(
        r"^```text\n(.*?)^```$", (ROOT / "docs/start.md").read_text("utf-8"), re.MULTILINE | re.DOTALL
    )
    assert shown.splitlines() == [line.rstrip() for line in printed.splitlines()[1:5]]
    assert (
        re.search(r"solved after (\d+) steps", printed)[1]
        == re.search(r"solves this box at step (\d+)", text_of("start.md"))[1]
    )


def of_300(agent, **asked):
    """Of 300 trials how many are solved."""
    parts = (lockprobe.population(agent, repetition=part, trials=100, **asked) for part in (1, 2, 3))
    return sum(int(part.solved.sum()) for part in parts)


def rise(agent):
    """Trials of 300 that are solved at a flip rate of 0 and of 0.4."""
    return [of_300(agent, p=p, modality="symbolic?tell=state") for p in (0, 0.4)]


def test_two_curves_of_different_cause_rise():
    text = text_of("why.md")
    assert (
        "`cognitive:loop-breaker` goes from {} to {} of 300 trials solved".format(*rise("cognitive:loop-breaker"))
        in text
    )
    assert "`cognitive:perseverant` from {} to {}.".format(*rise("cognitive:perseverant")) in text

"""What pages show of studies is what these studies give, with the commands, files and code that the pages show."""

import re
import shlex
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from placeholders import undrawn
from provider_server import here
from typed import in_process

import lockprobe
from lockprobe.foundation.errors import BadValue
from lockprobe.foundation.formatting import p_value
from lockprobe.report.format import entry_text
from lockprobe.report.primary import primary_lines
from lockprobe.studies.options.studyfile import study

DOCS = Path(__file__).parents[1] / "docs"


def text_of(name):
    return " ".join((DOCS / name).read_text("utf-8").split())


def blocks(page, kind):
    return re.findall(rf"^```{kind}\n(.*?)^```$", (DOCS / page).read_text("utf-8"), re.DOTALL | re.MULTILINE)


FIRST = ("cognitive:perseverant", "human-inspired", "random")


@pytest.mark.slow
def test_the_first_study_and_the_answer_that_the_readme_quotes(tmp_path):
    """The first command without its other conditions, which change no number of these."""
    whole = study("flips", agent=FIRST)
    fresh = tuple(one for one in whole.conditions if one in whole.flip_axis)
    played = lockprobe.run_study(replace(whole, conditions=fresh, strategy_conditions=()), tmp_path / "first")
    page = (DOCS / "start.md").read_text("utf-8")
    solved = Counter((trial.agent, trial.p) for trial in played if trial.solved)
    for agent in FIRST:
        (row,) = re.findall(rf"^\| `{re.escape(agent)}` \|.*$", page, re.MULTILINE)
        assert row.endswith("| {} | {} | {} | {} |".format(*(solved[agent, p] for p in (0.0, 0.2, 0.4, 0.6))))
    assert (len(played), whole.size) == (3 * 4 * 300, 3 * 8 * 300)
    with undrawn():
        found = lockprobe.results(tmp_path / "first")
    page = (DOCS.parent / "README.md").read_text("utf-8")
    (quoted,) = re.findall(r"^> (False .*)", page, re.MULTILINE)
    assert found.answer == quoted
    for line in [one for one in primary_lines(found) if one.agent != "random"]:
        shares = [entry_text(row) for row in (line.first, line.second)]
        said = p_value(line.change.p_value).removeprefix("P ").removeprefix("= ")
        change = [entry_text(line.change), said, line.verdict]
        assert f"| {' | '.join([line.label, *shares, *change])} |" in page


@pytest.mark.slow
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
    (wanted,) = re.findall(r"replay first '(.*?)'$", (DOCS / "start.md").read_text("utf-8"), re.MULTILINE)
    lockprobe.run_study(study("flips", agent=FIRST, p=[0.4], trials=10, repetitions=1), tmp_path / "first")
    printed = in_process("replay", tmp_path / "first", wanted).output
    (shown,) = blocks("start.md", "text")
    assert shown.splitlines() == [line.rstrip() for line in printed.splitlines()[1:5]]
    steps = re.search(r"solved after (\d+) steps", printed)[1]
    assert f"solves this box at step {steps}." in text_of("start.md")


@pytest.mark.slow
def test_lies_that_act_only_in_loops_help_the_loop_breaker(tmp_path):
    rows = dict(re.findall(r"^\| `(.*?)`(?:: [^|]*)? \| (\d+) \|$", (DOCS / "why.md").read_text("utf-8"), re.MULTILINE))
    specs = {arm: arm.replace("lie", "flip?p=0.4") for arm in rows}
    asked = {"p": (0,), "condition": [*specs.values()], "repetitions": 1, "trials": 150}
    planned = study("flips", agent="cognitive:loop-breaker", **asked)
    solved = Counter(trial.condition for trial in lockprobe.run_study(planned, tmp_path / "in-loops") if trial.solved)
    assert {arm: str(solved[spec]) for arm, spec in specs.items()} == rows


@pytest.mark.slow
def test_one_lie_at_the_end_of_a_loop(tmp_path):
    record = tmp_path / "record"
    lockprobe.run_study(study("flips", agent="cognitive:loop-breaker", p=(0,), trials=20), record)
    printed = in_process("branch", record, "--at", "onset", "--told", "truth,lie,lie-truth").output
    rows = re.findall(r"onset +\S+ +(\d+) % +\+(\d+) \[(\S+), (\S+)\] .* (\d+)$", printed, re.MULTILINE)
    (truth, lie, low, high, n), (_, back, back_low, back_high, _) = rows
    assert (
        f"After a true report {truth} % of these {n} trials are solved. One lie adds {lie} points (95 % interval "
        f"{low} to {high}), one lie that the truth corrects at once {back} ({back_low} to {back_high})."
    ) in text_of("why.md")


def test_the_device_of_the_page_keeps_the_contract_and_is_played(tmp_path, monkeypatch):
    *_, module, contract = blocks("../robot/docs/robot.md", "py")
    (tmp_path / "bench.py").write_text(module, "utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    exec(compile(contract, "robot.md", "exec"), {})
    trial = lockprobe.run_trial(agent="human-inspired", plant="python:bench:Bench", p=0.4, seed=1)
    assert trial.actions == lockprobe.run_trial(agent="human-inspired", p=0.4, seed=1).actions
    assert {step.sensed["force_n"] for step in trial.steps} == {2.0, 20.0}


def test_a_server_of_ones_own_plays_the_pilot_with_and_without_facts(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (facts,) = blocks("models.md", "toml")
    (tmp_path / "facts.toml").write_text(facts, "utf-8")
    (own,) = [block for block in blocks("models.md", "sh") if "BASE_URL" in block]
    typed = re.fullmatch(r"export LAB_BASE_URL=\S+/v1 LAB_API_KEY=(\w+)\nuv run lockprobe (.*)\n", own)
    words = [*shlex.split(typed[2]), "--no-report"]
    with here() as server:
        monkeypatch.setenv("LAB_BASE_URL", server.url)
        monkeypatch.setenv("LAB_API_KEY", typed[1])
        with pytest.raises(BadValue, match="expected none with llm:openai-api/lab/qwen, whose price is not known"):
            in_process(*words, "--budget", "1")
        assert in_process(*words).exit_code == 0
        monkeypatch.setenv("LOCKPROBE_MODEL_FACTS", "facts.toml")
        assert in_process(*(word.replace("own-pilot", "again") for word in words), "--budget", "1").exit_code == 0
    assert [len(lockprobe.load(tmp_path / name)) for name in ("own-pilot", "again")] == [4, 4]

"""What pages show is typed: their code runs, and their studies give the numbers that stand there."""

import re
import shlex
from collections import Counter
from pathlib import Path

import pytest
from provider_server import here
from typed import in_process
from typer.testing import CliRunner

import lockprobe
from lockprobe.cli import build
from lockprobe.foundation.errors import BadValue
from lockprobe.studies.options.studyfile import study

IN_ARM = {"lie": "flip?p=0.4"}
"""The condition of an arm whose name is not its spec."""

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"


def blocks(page, kind):
    return re.findall(rf"^```{kind}\n(.*?)^```$", (DOCS / page).read_text("utf-8"), re.DOTALL | re.MULTILINE)


def words(page):
    return " ".join((DOCS / page).read_text("utf-8").split())


def test_lies_that_act_only_in_loops_help_the_loop_breaker(tmp_path):
    rows = dict(re.findall(r"^\| `(.*?)` \| (\d+) \|", (DOCS / "why.md").read_text("utf-8"), re.MULTILINE))
    planned = study(
        "flips",
        agent="cognitive:loop-breaker",
        p=(0,),
        condition=[IN_ARM.get(arm, arm) for arm in rows],
        repetitions=1,
        trials=150,
    )
    solved = Counter(trial.condition for trial in lockprobe.run_study(planned, tmp_path / "in-loops") if trial.solved)
    assert {arm: str(solved[IN_ARM.get(arm, arm)]) for arm in rows} == rows


def test_one_lie_at_the_end_of_a_loop(tmp_path):
    record = tmp_path / "record"
    lockprobe.run_study(study("flips", agent="cognitive:loop-breaker", p=(0,), trials=20), record)
    asked = ["branch", str(record), "--at", "onset", "--told", "truth,lie,lie-truth", "--act", "random"]
    printed = CliRunner().invoke(build(["branch"]), asked).output
    rows = re.findall(r"onset +\S+ +(\d+) % +\+(\d+) \[(\S+), (\S+)\] .* (\d+)$", printed, re.MULTILINE)
    (truth, lie, *lie_ends, n), (_, back, *back_ends, _), (_, step, *step_ends, _) = rows
    lie_between, back_between, step_between = map(" to ".join, (lie_ends, back_ends, step_ends))
    said = (
        f"After a true report {truth} % of these {n} trials are solved. One lie adds {lie} points "
        f"(95 % interval {lie_between}), one lie that the truth corrects at once {back} ({back_between})."
    )
    assert said in words("why.md")
    assert f"One random step instead adds {step} points ({step_between})" in words("why.md")


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
        with pytest.raises(BadValue, match="expected no budget with llm:openai-api/lab/qwen, whose price is not known"):
            in_process(*words, "--budget", "1")
        assert in_process(*words).exit_code == 0
        monkeypatch.setenv("LOCKPROBE_MODEL_FACTS", "facts.toml")
        assert in_process(*(word.replace("own-pilot", "again") for word in words), "--budget", "1").exit_code == 0
    assert [len(lockprobe.load(tmp_path / name)) for name in ("own-pilot", "again")] == [4, 4]

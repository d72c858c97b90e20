"""How a run goes and what it costs: what is counted, what people read in lines, and what programs read."""

import asyncio
from pathlib import Path

import pytest
from builders import SOLUTION, call_of, make_trial, write_study

from lockprobe.agents.catalogue import resolve
from lockprobe.cli.format_cost import estimate_lines
from lockprobe.cli.run_study import Progress
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.estimate import estimates
from lockprobe.studies.costs.spending import spent_by_agent, total
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import Journal
from lockprobe.trial.model_call import Usage

MODEL = "llm:openai/gpt-4o"
ONE = study("flips", agent=MODEL, trials=1, p=[0], repetitions=1)
USED = Usage(calls=1, input_tokens=1000, output_tokens=1000)


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    for module in ("cli.run_study", "studies.costs.call_log"):
        monkeypatch.setattr(f"lockprobe.{module}.time.monotonic", lambda: now[0])
    return now


def test_after_a_resume_trials_are_of_the_study_and_the_time_left_is_of_this_run(tmp_path, clock):
    planned = study("flips", agent="random", p=[0], trials=55, repetitions=1)
    done = [make_trial(SOLUTION, trial=n) for n in range(1, 53)]
    with Journal.open(write_study(tmp_path / "s", planned, done), planned) as journal:
        progress = Progress(planned, journal)
        progress.begin(planned, journal, 3)
        progress.agent(resolve("random"), 3)
        assert progress.line().startswith("random  52/55 trials · 52 of 52 solved")
        assert "… left" in progress.line()
        clock[0] = 20.0
        broken = make_trial([0], trial=53, broken="plant")
        progress.trial(broken, 1)
    assert progress.line().startswith("random  53/55 trials · 52 of 52 solved")
    assert "40 s left" in progress.line()
    assert progress.line().endswith("1 error: plant 1")


def test_a_provider_that_makes_us_wait_is_spoken_of(tmp_path, clock):
    with Journal.open(tmp_path, ONE) as journal:
        progress = Progress(ONE, journal)
        progress.begin(ONE, journal, 1)
        progress.agent(resolve(MODEL), 1)
        plan = next(ONE.plans(MODEL))
        for step in range(1, 4):
            asyncio.run(journal.calls.write(call_of(plan, step, usage=USED, retries=2)))
        asyncio.run(journal.calls.reserve(call_of(plan, 4)))
        assert "on the way" not in progress.line()
        clock[0] = 42.0
        assert "1 call on the way, the oldest for 42 s" in progress.line()
    spent = f"${total(spent_by_agent(read_calls(tmp_path)).values()).dollars:.2g} spent, 6 retries"
    assert spent in progress.line()
    assert progress.spent() == [f"All calls: {spent}"]


COST_PAGE = Path(__file__).parents[2] / "docs" / "cost.md"


def test_an_estimate_says_its_range_and_the_date_of_its_prices_as_the_docs_do():
    quoted = COST_PAGE.read_text("utf-8").split("```text\n")[1].partition("```")[0]
    lines = estimate_lines(estimates(study("flips", agent="llm:openai/gpt-4o", full=True), {})[0])
    for said, line in zip(lines, quoted.splitlines(), strict=False):
        assert said.startswith(line.removesuffix("…"))
    (first, second) = estimate_lines(estimates(study("flips", agent="llm:openai-api/some/model", trials=1), {})[0])
    assert first.startswith("llm:openai-api/some/model: 21 trials, about ")
    assert second == "  the price is not known (set it with LOCKPROBE_MODEL_FACTS=FILE.toml)"

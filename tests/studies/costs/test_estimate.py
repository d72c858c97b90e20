"""What a study is said to cost before it is played, held against what it then costs."""

import json
import re

import pytest
from builders import SOLUTION, call_of, make_trial
from provider_server import here, joints, names, truthful

from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.boxes.solve import random_curve
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.estimate import SMALLEST_CACHED, estimates
from lockprobe.studies.costs.spending import Ledger
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.trial_rows import Timing, row_of
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.model_call import Usage

SPEC = "llm:openai-api/fake/model"
FACTS = """
[[model]]
match = ["openai-api/fake/model"]
most_output = 4000
price = { input = 2, cached = 1, output = 10, date = "2026-01-02", source = "made up" }
[[model]]
match = ["openai-api/fake/thinks"]
reasons = true
picture_tokens = 500
"""
USED = Usage(calls=1, input_tokens=1000, output_tokens=70)
WITHIN = 1.5
"""By which factor an estimate may be off, either way, for a model that plays blindly and writes a sentence a step."""


@pytest.fixture(autouse=True)
def facts(tmp_path, monkeypatch):
    (tmp_path / "models.toml").write_text(FACTS)
    monkeypatch.setenv(OWN_FACTS, str(tmp_path / "models.toml"))


def planned(*agents, **settings):
    return study(
        StudyOptions(agent=list(agents or [SPEC]), **({"p": [0, 0.4], "trials": 5, "repetitions": 1} | settings))
    )


def known(trial):
    """What the store knows of a trial."""
    return row_of(trial, Timing(key=trial.key, seconds=1.0, steps=len(trial.steps)), "").known(trial.group)


def counted(text):
    return len(re.findall(r"\w+|[^\w\s]", text))


def guessing(request):
    """A reply at random that says something, with a count of what was really sent and written."""
    status, body = truthful(request)
    reply = json.loads(body["choices"][0]["message"]["content"])
    listing = joints(request)
    reply["joint"] = listing[int(names(request["messages"])[1], 16) % len(listing)]
    reply["hypothesis"] = "The joint on the right seems to be free, and the others wait for it."
    text = json.dumps(reply)
    body["choices"][0]["message"]["content"] = text
    sent = sum(counted(str(message["content"])) for message in request["messages"]) + counted(
        str(request["response_format"])
    )
    body["usage"] = {"prompt_tokens": sent, "completion_tokens": counted(text), "total_tokens": sent + counted(text)}
    return status, body


def close(one, other, factor=WITHIN):
    return other / factor <= one <= other * factor


def test_an_estimate_comes_true(tmp_path, monkeypatch):
    plan = planned()
    before = estimates(plan, {})[0]
    with here(guessing) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        trials = run_study(plan, tmp_path / "study")
    assert all(trial.error is None for trial in trials)
    spent = Ledger(plan, read_calls(tmp_path / "study")).by_agent[SPEC]
    assert close(before.expected.calls, spent.usage.calls)
    assert close(before.expected.input_tokens, spent.usage.input_tokens)
    assert close(before.expected.output_tokens, spent.usage.output_tokens)
    assert close(before.dollars(before.expected, cached=False), spent.dollars)
    assert close(before.repeated, spent.repeated_tokens / spent.usage.input_tokens, 1.1)
    assert spent.dollars < before.dollars(before.most, cached=False) <= before.most_dollars
    assert spent.usage.calls <= before.full.calls == 200

    half = [trial for trial in trials if trial.trial <= 2]
    kept = [call for call in read_calls(tmp_path / "study") if call.key in {trial.key for trial in half}]
    after = estimates(plan, {trial.key: known(trial) for trial in half}, kept)[0]
    assert (after.trials, after.rests_on) == (6, len(kept))
    rest = spent.usage.input_tokens - sum(call.usage.input_tokens for call in kept)
    assert close(after.full.input_tokens / after.full.calls, rest / (spent.usage.calls - len(kept)), 1.4)
    per_reply = spent.usage.output_tokens / spent.usage.calls
    assert close(after.expected.output_tokens / after.expected.calls, per_reply, 1.02)


def test_an_agent_that_has_not_played_is_taken_to_be_blind():
    plan = planned(trials=100)
    blind = sum(1 - solved for solved in random_curve(plan.box, 20)[:-1])
    found = estimates(plan, {})[0]
    assert (found.trials, found.rests_on) == (200, 0)
    assert found.expected.calls == round(200 * blind)
    assert found.full.calls == found.most.calls == 200 * 20


def test_one_that_has_played_is_taken_to_go_on_like_that():
    plan = planned()
    trials = [make_trial(SOLUTION, agent=SPEC, trial=n) for n in (1, 2, 3)]
    done = {trial.key: known(trial) for trial in trials}
    replies = [
        call_of(trial, step, turn=turn, usage=USED)
        for trial in trials
        for step in (1, 2, 3, 4)
        for turn in ((1, 2) if step == 1 else (1,))
    ]
    found = estimates(plan, done, replies)[0]
    assert (found.trials, found.rests_on) == (7, 15)
    assert found.expected.calls == 7 * 5  # four steps and a repair each
    assert found.expected.output_tokens == 7 * 5 * 70
    assert found.expected.input_tokens == pytest.approx(7 * 5 * 1000, rel=0.01)


def test_a_trial_that_was_broken_off_costs_what_is_left_of_it():
    plan = planned(trials=1, p=[0])
    trial = next(plan.plans(SPEC))
    made = [call_of(trial, step, usage=Usage(calls=1)) for step in range(1, 16)]
    whole, rest = estimates(plan, {})[0], estimates(plan, {}, made)[0]
    assert (whole.full.calls, rest.full.calls, rest.most.calls) == (20, 5, 5)
    assert rest.full.input_tokens > whole.full.input_tokens / 4  # the last requests are the longest


def lasting(trial, steps):
    """A trial that is solved in its last step; the joint of the target is locked until then."""
    return make_trial([0] * (steps - 4) + [*SOLUTION], agent=SPEC, trial=trial)


def replied(trial, steps):
    """The calls of a trial that was broken off."""
    broken = make_trial([], agent=SPEC, trial=trial, broken="model")
    return [call_of(broken, step, usage=USED) for step in range(1, steps + 1)]


def test_how_far_trials_come_is_told_by_those_that_were_broken_off_too():
    plan = planned(trials=5, p=[0])
    done = {trial.key: known(trial) for trial in (lasting(1, 5), lasting(2, 9))}
    calls = [*replied(3, 4), *replied(4, 6)]
    found = estimates(plan, done, calls)[0]
    # step 5 ends one of the three that are known to have been in it and of which it is known how it went
    # trial 3: steps 5, and 6 to 9 by two thirds; trial 4: steps 7 to 9; trial 5: five steps, and four by two thirds
    assert found.expected.calls == round((1 + 4 * 2 / 3) + 3 + (5 + 4 * 2 / 3))


def test_nothing_is_said_of_agents_that_ask_nobody_or_owe_nothing():
    assert estimates(planned("random", "human-inspired"), {}) == []
    plan = planned(trials=1, p=[0])
    done = make_trial(SOLUTION, agent=SPEC)
    assert estimates(plan, {done.key: known(done)}) == []
    broken = make_trial([0], agent=SPEC, broken="model")
    assert estimates(plan, {broken.key: known(broken)})[0].trials == 1


def test_money_follows_cache_and_what_is_known():
    found = estimates(planned(), {})[0]
    fresh, cached = (found.dollars(found.full, cached=hits) for hits in (False, True))
    assert 0 < cached < fresh < found.most_dollars
    unknown = estimates(planned("llm:openai-api/other/model"), {})[0]
    assert unknown.dollars(unknown.full, cached=True) is unknown.most_dollars is unknown.price is None


def test_only_prefixes_that_providers_keep_count_as_cached():
    short, long = estimates(planned(max_steps=3), {})[0], estimates(planned(max_steps=60), {})[0]
    assert short.repeated > 0.5
    assert short.full.cached_tokens == 0  # never SMALLEST_CACHED tokens long
    assert long.full.cached_tokens > long.full.input_tokens / 2
    assert short.full.input_tokens / short.full.calls < SMALLEST_CACHED


def test_reasoning_counts_as_written():
    plain, thinks = (estimates(planned(spec), {})[0] for spec in (SPEC, "llm:openai-api/fake/thinks"))
    per_reply = thinks.expected.output_tokens / thinks.expected.calls
    assert per_reply > 10 * plain.expected.output_tokens / plain.expected.calls
    capped = estimates(planned("llm:openai-api/fake/thinks?max_tokens=50"), {})[0]
    assert capped.expected.output_tokens == pytest.approx(50 * capped.expected.calls, rel=0.01)


def test_a_budget_of_very_many_steps_is_estimated_at_once():
    found = estimates(planned(max_steps=3000, trials=1), {})[0]
    assert found.full.calls == found.most.calls == 2 * 3000
    assert found.expected.input_tokens < found.full.input_tokens < found.most.input_tokens

"""What a study is said to cost before it is played, held against what it then costs."""

import json
import re
from pathlib import Path

import pytest
from builders import SOLUTION, make_trial
from provider_server import here, joints, names, replying, truthful, words

from lockprobe.agents.llm.model_facts import OWN_FACTS, ModelFacts
from lockprobe.agents.llm.settings import Model, ModelSettings
from lockprobe.boxes.solve import random_curve
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.estimate import REPLY, estimates, request_sizes, tokens
from lockprobe.studies.costs.spending import spent_by_agent
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.store import OnRecord
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.running.single import run_trial

SPEC, THINKS = "llm:openai-api/fake/model", "llm:openai-api/fake/thinks"
FACTS = """
[[model]]
match = ["openai-api/fake/model"]
most_output = 4000
price = { input = 2, cached = 1, output = 10, date = "2026-01-02", source = "made up" }
[[model]]
match = ["openai-api/fake/thinks"]
reasons = true
"""
CURT = Path(__file__).parents[2] / "interventions" / "curt.txt"


@pytest.fixture(autouse=True)
def facts(tmp_path, monkeypatch):
    (tmp_path / "models.toml").write_text(FACTS)
    monkeypatch.setenv(OWN_FACTS, str(tmp_path / "models.toml"))


def planned(*agents, **settings):
    return study(
        StudyOptions(agent=list(agents or [SPEC]), **({"p": [0, 0.4], "trials": 5, "repetitions": 1} | settings))
    )


def guessing(request):
    """A reply at random that says something, with a count of what was really sent and written."""
    status, body = truthful(request)
    reply = json.loads(body["choices"][0]["message"]["content"])
    listing = joints(request)
    reply["joint"] = listing[int(names(request["messages"])[1], 16) % len(listing)]
    reply["hypothesis"] = "The joint on the right seems to be free, and the others wait for it."
    text = json.dumps(reply)
    body["choices"][0]["message"]["content"] = text
    said = "".join(str(message["content"]) for message in request["messages"]) + str(request["response_format"])
    sent, wrote = (len(re.findall(r"\w+|[^\w\s]", one)) for one in (said, text))
    body["usage"] = {"prompt_tokens": sent, "completion_tokens": wrote, "total_tokens": sent + wrote}
    return status, body


def test_an_estimate_comes_true(tmp_path):
    """Within a factor of 1.5, for a model that plays blindly and writes a sentence a step."""
    plan = planned()
    before = estimates(plan, {})[0]
    with here(guessing):
        trials = run_study(plan, tmp_path / "study")
    assert all(trial.error is None for trial in trials)
    spent = spent_by_agent(read_calls(tmp_path / "study"))[SPEC]
    for what in ("calls", "input_tokens", "output_tokens"):
        assert 1 / 1.5 < getattr(before.low, what) / getattr(spent.usage, what) < 1.5
    low, high = before.dollars()
    assert 1 / 1.5 < low / spent.dollars < 1.5
    assert low < high
    assert spent.usage.calls <= before.high.calls == 200


def test_an_agent_is_taken_to_be_blind_or_to_play_to_the_end_and_what_is_done_costs_nothing():
    plan = planned(trials=100)
    blind = sum(1 - solved for solved in random_curve(plan.box, 20)[:-1])
    found = estimates(plan, {})[0]
    assert (found.trials, found.low.calls, found.high.calls) == (200, round(200 * blind), 200 * 20)
    trials = make_trial(SOLUTION, agent=SPEC), make_trial([0], agent=SPEC, trial=2, broken="model")
    done = {trial.key: OnRecord.of(trial) for trial in trials}
    assert estimates(plan, done)[0].trials == 199  # what broke is owed
    assert estimates(planned("random", "human-inspired"), {}) == []
    assert estimates(planned(trials=1, p=[0]), done) == []


def test_a_price_that_is_not_known_is_none_and_reasoning_counts_as_written():
    plain, thinks = (estimates(planned(spec), {})[0] for spec in (SPEC, THINKS))
    assert (thinks.dollars(), thinks.price) == (None, None)
    assert thinks.high.output_tokens > 10 * plain.high.output_tokens
    capped = estimates(planned(f"{THINKS}?max_tokens=50"), {})[0]
    assert capped.high.output_tokens == 50 * capped.high.calls
    long = estimates(planned(max_steps=60, trials=1), {})[0]
    assert long.high.calls == 2 * 60


def model(images=0, **facts):
    return Model(name="openai-api/fake/model", settings=ModelSettings(images=images), facts=ModelFacts(**facts))


@pytest.mark.parametrize(
    "spec",
    ["truth", "hypothesis?ask=off", "hypothesis?ask=after", "distract?p=1", "history?last=3", f"prompt?file={CURT} + warn"],
)  # fmt: skip
def test_requests_are_taken_to_be_as_large_as_those_that_are_sent(spec):
    """At every step, held against a provider that answers as the made-up trial does; labels are of equal length."""
    with here(lambda request: replying(request, joints(request)[0], REPLY["hypothesis"])) as provider:
        trial = run_trial(agent=SPEC, condition=spec, max_steps=12)
    assert trial.error is None
    plan = study("flips", agent=SPEC, condition=spec, max_steps=12)
    sizes = request_sizes(plan.plan(SPEC, plan.conditions[-1], 1, 1), model())[1]
    sent = [sum(tokens(words(message)) + 4 for message in request["messages"]) for request in provider.requests]
    form = tokens(json.dumps(provider.requests[-1]["response_format"]["json_schema"]["schema"]))
    taken = (sizes - form)[: len(sent)]
    assert taken[0] == pytest.approx(sent[0], rel=0.05)
    assert sum(taken) == pytest.approx(sum(sent), rel=0.08)

"""The seven arms of the study of controls differ on the wire in the reports at the selected steps, and in nothing else."""

import json
import re

import pytest
from provider_server import here

import lockprobe
from lockprobe.statistics.design import ARMS
from lockprobe.studies.options.studyfile import study

AGENT = "llm:openai-api/fake/model"

NAMING = re.compile(r"\b(truth|true|lies?|false|flips?|distract|condition|arms?|retract)|[?&]\w+=")
"""What would tell a model which arm it is in: a word, or an option of a spec."""


@pytest.fixture(scope="module")
def asked():
    """Arm -> the last request of one trial, which holds all messages of it; the model acts alike in every arm."""
    found = {}
    with here(keep=True) as provider, pytest.MonkeyPatch.context() as patch:
        patch.setenv("FAKE_BASE_URL", provider.url)
        patch.setenv("FAKE_API_KEY", "nobody-asks-for-one")
        for condition in study("why", agent=AGENT).conditions:
            trial = lockprobe.run_trial(agent=AGENT, condition=condition, trial=2, seed=2)
            assert trial.ending in ("solved", "max_steps")
            found[condition.label] = provider.requests[-1]
    return found


def differing(asked, arm):
    """Messages that an arm changes against the arm of true reports."""
    pairs = zip(asked[arm]["messages"], asked["truth"]["messages"], strict=True)
    return [at for at, (mine, true) in enumerate(pairs) if mine != true]


def test_every_arm_changes_the_reports_of_the_same_steps_and_nothing_else(asked):
    assert list(asked) == list(ARMS)
    hit = differing(asked, "lie")
    assert len(hit) > 1
    for arm, request in asked.items():
        assert {**request, "messages": ()} == {**asked["truth"], "messages": ()}
        assert differing(asked, arm) == ([] if arm == "truth" else hit)
        assert all(request["messages"][at]["role"] == "user" for at in hit)


def test_no_message_names_the_arm(asked):
    for request in asked.values():
        assert NAMING.findall(json.dumps({**request, "response_format": ""}).lower()) == []

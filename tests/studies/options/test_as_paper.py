"""``--as-paper``: ordinary settings, one labelling and one panel for a study, and nothing that follows the interlock."""

from dataclasses import replace

import pytest
from provider_server import here, replying, words

from lockprobe.agents.llm.settings import Access
from lockprobe.foundation.errors import Conflict
from lockprobe.report.verify import verify
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import Limits, run_study

ONE_BY_ONE = {
    "modality": "symbolic?tell=state&form=json",
    "shuffle": "study",
    "layout": "dealt",
    "hypothesis": "off",
    "assessment": True,
    "max_steps": 20,
    "repetitions": 3,
    "trials": 10,
    "p": [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6],
}


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("p", [0.0, 0.4]), ("trials", 2), ("max_steps", 9), ("layout", "shuffled"), ("shuffle", "trial"),
        ("assessment", False), ("hypothesis", "before"), ("strategy_trials", 5),
    ],
)  # fmt: skip
def test_an_option_that_is_given_wins(name, value):
    found = study("flips", agent="random", as_paper=True, **{name: value})
    assert getattr(found, name) == (tuple(value) if name == "p" else value)
    assert found.modalities == (ONE_BY_ONE["modality"],)


def test_only_the_papers_studies_are_as_in_the_paper():
    with pytest.raises(Conflict, match="^--as-paper cannot be combined with why: the studies of the paper are flips"):
        study("why", agent="random", as_paper=True)


FIRST = """\
You are trying to open a lockbox, a panel with 4 joints.
Every joint has two positions, 0 and 1. The joints lock each other in a hidden way: whether a joint can move depends on \
the positions of other joints. If you attempt a joint that is not locked, it moves to its other position; if it is \
locked, nothing happens.
The box is open as soon as the target joint moves. You have 20 steps. In every step you choose one joint to attempt. \
Then you are told the position of every joint. You are not told whether a joint moved: find out by comparing \
successive reports.
Reply with one JSON object and nothing else:
{"last_action": "moved" or "did not move" ("none" in the first step), "joint": the joint to attempt next}
The panel's joints: C, D, B, A. The target joint: B.

{"positions": {"C": 0, "D": 0, "B": 0, "A": 0}}"""


def test_a_hosted_model_is_sent_these_messages(tmp_path, monkeypatch):
    """Labels and states of all joints after every step, no outcome, no hypothesis, and the last action assessed."""
    monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
    chosen = iter("CADC")

    with here(lambda request: replying(request, next(chosen)), keep=True) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        asked = {"as_paper": True, "p": [0], "trials": 1, "repetitions": 1}
        found = study("flips", agent="llm:openai-api/fake/model", **asked)
        limits = Limits(access=Access(connections=1))
        run_study(replace(found, max_steps=4), tmp_path / "study", limits=limits)
    sent = server.requests[-1]
    assert [(one["role"], words(one)) for one in sent["messages"]] == [
        ("user", FIRST.replace("20 steps", "4 steps")),
        ("assistant", '{"last_action": "none", "joint": "C"}'),
        ("user", '{"attempted": "C", "positions": {"C": 0, "D": 0, "B": 0, "A": 0}}'),
        ("assistant", '{"last_action": "moved", "joint": "A"}'),
        ("user", '{"attempted": "A", "positions": {"C": 0, "D": 0, "B": 0, "A": 1}}'),
        ("assistant", '{"last_action": "moved", "joint": "D"}'),
        ("user", '{"attempted": "D", "positions": {"C": 0, "D": 1, "B": 0, "A": 1}}'),
    ]
    form = sent["response_format"]["json_schema"]["schema"]
    assert form["properties"] == {
        "last_action": {"type": "string", "enum": ["moved", "did not move"]},
        "joint": {"type": "string", "enum": ["C", "D", "B", "A"]},
    }
    assert form["required"] == ["last_action", "joint"]
    assert [check for check in verify(tmp_path / "study") if not check.holds] == []

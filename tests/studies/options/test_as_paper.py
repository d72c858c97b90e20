"""``--as-paper``: ordinary settings, one labelling and one panel for a study, and nothing that follows the interlock."""

from dataclasses import replace
from functools import cache

import pytest
from provider_server import here, replying, words

from lockprobe.agents.llm.settings import Access
from lockprobe.boxes.layouts import locking_pairs, neighbours
from lockprobe.foundation.errors import Conflict
from lockprobe.report.verify import verify
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import Limits, run_study
from lockprobe.trial.plan import Names

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
SEEDS = range(200)


def test_the_modality_study_has_the_three_observations_of_the_paper():
    shown = study("modalities", as_paper=True)
    assert shown.modalities == ("rgb", "rgbd", "symbolic?tell=state&form=json")
    assert (shown.repetitions, shown.trials, shown.p, shown.plant) == (1, 10, (0.0,), "fast-twin")
    assert (shown.shuffle, shown.layout, shown.hypothesis) == ("study", "dealt", "off")


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


@pytest.mark.parametrize(
    ("name", "asked", "message"),
    [
        ("why", {}, "--as-paper cannot be combined with why: the studies of the paper are flips and modalities"),
        ("flips", {"shuffle": "never"}, "--as-paper cannot be combined with --shuffle never: labels along the panel"),
        (
            "flips",
            {"plant": "manual?camera=pictures", "modality": "rgb"},
            "--as-paper cannot be combined with pictures of manual.camera=pictures: painted labels stand along",
        ),
    ],
)
def test_what_it_cannot_be_combined_with_is_refused(name, asked, message):
    with pytest.raises(Conflict, match=f"^{message}"):
        study(name, agent="random", as_paper=True, **asked)


@cache
def drawn(seed, name="chain-4"):
    """The names and the panel of the first trial of a study."""
    found = study("flips", agent="random", as_paper=True, seed=seed, box=name)
    plan = found.plan("random", found.conditions[0], 1, 1)
    return Names(plan), plan.box


def test_over_seeds_neighbours_lock_each_other_as_often_as_by_chance():
    """On chain-4, 3 of 6 pairs lock each other, so 1.5 of 3 pairs of neighbours do on average, and never none or all."""
    listed, labelled, placed = [], [], []
    for seed in SEEDS:
        names, dealt = drawn(seed)
        locking = locking_pairs(dealt)
        by_label = sorted(range(4), key=lambda joint: names.labels[joint])
        for order, found in ((names.order, listed), (by_label, labelled)):
            found.append(sum(tuple(sorted(order[i : i + 2])) in locking for i in range(3)))
        placed.append(len(locking & neighbours(dealt)))
    for found in (listed, labelled, placed):
        assert {*found} == {1, 2}
        assert 1.35 <= sum(found) / len(found) <= 1.65


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

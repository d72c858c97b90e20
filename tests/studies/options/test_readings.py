"""Readings of a false report as a factor: what is played, by whom, and what is refused."""

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interventions.conditions import interventions_in
from lockprobe.studies.options.asked_conditions import READINGS
from lockprobe.studies.options.presets import preset
from lockprobe.studies.options.studyfile import study

MODEL, STRATEGY = "llm:local", "random"
FULL = preset("flips")
SHORT = FULL.when["short"]
KEPT = [f"flip?p={p:g}&others=kept" for p in SHORT.p if p]


def labels(planned, agent=None):
    own = planned.conditions if agent is None else planned.conditions_of(agent)
    return [one.label for one in own]


def test_words_name_readings_and_all_are_the_two_by_two():
    fresh, kept, sticky, transient = (
        labels(study("flips", agent=STRATEGY, p=[0.4], readings=word))
        for word in ("fresh", "kept", "sticky", "transient")
    )
    assert [fresh, kept] == [["flip?p=0.4"], ["flip?p=0.4&others=kept"]]
    assert [sticky, transient] == [["flip?p=0.4&inverts=position&others=kept"], ["flip?p=0.4&inverts=position"]]
    planned = study("flips", agent=STRATEGY, p=[0, 0.4], readings="all")
    assert labels(planned) == [
        "truth", "flip?p=0.4", "flip?p=0.4&others=kept", "flip?p=0.4&inverts=position",
        "flip?p=0.4&inverts=position&others=kept",
    ]  # fmt: skip
    assert [interventions_in(one)[0].reading for one in planned.conditions[1:]] == [
        "re-observed outcome noise", "integrated outcome noise", "memoryless state noise", "latched state noise",
    ]  # fmt: skip
    assert len(READINGS) == 4


def test_asked_for_they_are_played_by_every_agent_beside_other_conditions():
    planned = study("flips", agent=[MODEL, STRATEGY], p=[0, 0.4], readings=["fresh,kept"], condition="nudge")
    assert labels(planned, MODEL) == labels(planned) == ["truth", "flip?p=0.4", "flip?p=0.4&others=kept", "nudge"]
    assert planned.p == (0, 0.4)
    assert labels(study("flips", agent=MODEL, readings="kept", p=[0, 0.2])) == ["truth", "flip?p=0.2&others=kept"]


def test_the_short_study_and_the_papers_play_lies_that_stay_where_that_costs_nothing():
    short, full = (study("flips", agent=[MODEL, STRATEGY], full=whole) for whole in (False, True))
    rates = [f"flip?p={p:g}" for p in SHORT.p if p]
    assert labels(short, MODEL) == ["truth", "flip?p=0.4"]
    assert labels(short, STRATEGY) == ["truth", *rates, *KEPT, "no-feedback"]
    assert short.size_of(MODEL) == 2 * FULL.repetitions * SHORT.trials
    assert labels(study("flips", agent=MODEL), MODEL) == ["truth", *rates]  # which nobody else would play
    assert len(labels(full, STRATEGY)) == 2 * len(FULL.p) - 1
    assert labels(full, MODEL) == labels(full)[: len(FULL.p)]


@pytest.mark.parametrize(
    "asked",
    [{"p": [0, 0.4]}, {"trials": 3}, {"flip": "sticky"}, {"modality": "symbolic"}, {"condition": "nudge"}],
    ids=str,
)
def test_who_asks_for_anything_gets_that_alone(asked):
    assert not study("flips", agent=STRATEGY, **asked).strategy_conditions


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"readings": "afresh"}, "readings: got 'afresh', expected one of fresh, kept, "),
        (
            {"readings": "fresh,re-observed"},
            "readings: got 'fresh,re-observed', expected at least one, and every one once",
        ),
        ({"readings": "all", "flip": "sticky"}, "readings: got 'all', expected none with --flip sticky"),
        ({"readings": "all", "study": "why"}, "readings: got 'all', expected none with why; flips plays them"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(asked, said):
    with pytest.raises(BadValue) as refused:
        study(asked.pop("study", "flips"), **asked)
    assert str(refused.value).startswith(said)

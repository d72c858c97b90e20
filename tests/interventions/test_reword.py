"""Other words, the same facts."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lockprobe.interventions.reword import SENTENCES, Reword, pattern_of
from lockprobe.interventions.words import TextChannel
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.record import Percept, Task
from lockprobe.trial.trial_json import trial_to_json

TASK = Task(joints=("B", "A", "H"), target="A", budget=20)


def facts(text):
    """What a report says, whatever its words: (outcome, joint), and the joints at 1."""
    found = []
    for (said, others), what in zip(SENTENCES.items(), ("moved", "blocked", "attempted", "there"), strict=True):
        for sentence in (said, *others):
            found += [(what, fact) for fact in re.findall(pattern_of(sentence), text)]
    return sorted(found)


percepts = st.builds(
    Percept,
    joint=st.sampled_from((None, *TASK.joints)),
    outcome=st.sampled_from(("moved", "blocked", None)),
    positions=st.none() | st.tuples(st.booleans(), st.booleans(), st.booleans()),
)


@given(percepts, st.integers(0, 10_000))
def test_every_fact_parses_back(percept, seed):
    rng = np.random.default_rng(seed)
    plain = TextChannel().perceive(percept, (), TASK, rng)
    other = Reword(p=1).perceive(plain, (), TASK, rng)
    told = percept.joint is not None and percept.outcome is not None
    said = ([(percept.outcome, percept.joint)] if told else []) + (
        []
        if percept.positions is None
        else [("there", ", ".join(j for j, at in zip(TASK.joints, percept.positions, strict=True) if at) or "none")]
    )
    assert facts(plain.text) == facts(other.text) == sorted(said)
    assert (plain.text == other.text) == (plain.text == "")
    assert replace(other, text="") == replace(plain, text="")


def test_every_paraphrase_says_one_thing_only():
    everything = [sentence for said, others in SENTENCES.items() for sentence in (said, *others)]
    assert len(set(everything)) == len(everything)
    assert len({len(others) for others in SENTENCES.values()}) == 1
    for sentence in everything:
        assert len(facts(sentence.format("B"))) == 1


@pytest.mark.parametrize(
    "agent", ["human-inspired", "round-robin", "cognitive:perseverant", "ideal-observer", "random"]
)
def test_every_strategy_plays_byte_for_byte_as_before(agent):
    plain, other = (run_trial(agent=agent, p=0.3, seed=5, condition=c) for c in ("", "reword?p=1"))
    assert [step.told for step in plain.steps] != [step.told for step in other.steps]
    assert plain.ending == other.ending
    one, another = (
        trial_to_json(replace(plain, opening="", steps=tuple(replace(step, told="") for step in trial.steps)))
        for trial in (plain, other)
    )
    assert one == another


def test_it_acts_after_the_words_wherever_it_stands():
    one, other = (run_trial(condition=c) for c in ("reword?p=1 + drop?p=0.5", "drop?p=0.5 + reword?p=1"))
    assert one.steps == other.steps
    assert [channel["channel"] for channel in one.channels[-3:]] == ["Drop", "TextChannel", "Reword"]
    assert [step.told for step in one.steps if step.told_moved is None] == [""] * sum(
        step.told_moved is None for step in one.steps
    )


def test_reports_reworded_at_a_smaller_p_are_reworded_alike_at_a_larger():
    few, many = ([step.told for step in run_trial(condition=f"reword?p={p}").steps] for p in (0.4, 0.8))
    plain = [step.told for step in run_trial().steps]
    assert all(a in (said, b) for a, b, said in zip(few, many, plain, strict=True))
    assert plain != few != many


def test_sentences_of_others_stay():
    said = "The handles stand in a row. You attempted B. At 1: B, A. It is late."
    told = Reword(p=1).perceive(Percept(text=said), (), TASK, np.random.default_rng(1)).text
    assert told.startswith("The handles stand in a row. ")
    assert told.endswith(". It is late.")
    assert facts(told) == [("attempted", "B"), ("there", "B, A")]

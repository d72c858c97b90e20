"""Strategies' trials on the kernel have the records of the loop, byte by byte."""

import asyncio
from dataclasses import replace
from typing import get_args

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.box import Shuffle
from lockprobe.boxes.families import find_box
from lockprobe.foundation.plugins import allow
from lockprobe.simulation.many_trials import minds_of, play_many
from lockprobe.studies.options.studyfile import trial_study
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.trial_json import trial_to_json

AGENTS = (
    *("random", "random-no-repeat", "round-robin", "human-inspired:proximity?lapse=0.1", "human-inspired"),
    *("cognitive:perseverant", "cognitive:loop-breaker", "ideal-observer"),
)
BOTH = ("symbolic", "symbolic?form=json")
WORDS = (*BOTH, "symbolic?tell=state", "symbolic?tell=outcome&form=json", "symbolic?places=yes")
FLIPS = ("", "p=0", "p=1", "p=0.4", "p=0.4&others=kept", "p=0.3&inverts=position&keep=0.5", "p=0.3&inverts=position")
ANY = (*FLIPS, "p=0.3&inverts=position&others=noisy")
PARTS = ("p=0.4&part=outcome", "p=0.4&part=position&keep=0.5")

BEGUN = replace(find_box("chain-4"), name="begun", initial=(False, True, False, True))
"""A box whose joints do not all start at 0."""


def plans_of(agent, condition, **asked):
    planned = trial_study(agent, condition=condition, **asked)
    return [planned.plan(agent, planned.conditions[0], *where) for where in ((1, 1), (1, 2), (2, 1), (2, 2), (3, 9))]


@settings(max_examples=40, deadline=None)
@given(
    agent=st.sampled_from(AGENTS),
    told=st.tuples(st.sampled_from(ANY), st.sampled_from(WORDS))
    | st.tuples(st.sampled_from(PARTS), st.sampled_from(BOTH)),
    box=st.sampled_from(["chain-3", BEGUN, "common-effect-4"]),
    seed=st.integers(0, 99),
    shuffle=st.sampled_from(get_args(Shuffle)),
    layout=st.sampled_from(["fixed", "dealt"]),
    assessment=st.booleans(),
    max_steps=st.integers(1, 25),
)
def test_the_records_are_those_of_the_loop(agent, told, **asked):
    flip, modality = told
    plans, player = plans_of(agent, flip and f"flip?{flip}", modality=modality, **asked), resolve(agent).make()
    minds = minds_of(player, plans[0])
    many = [*play_many(plans[:3], minds), *play_many(plans[3:], minds)]  # with the minds of the trials before

    async def one_by_one():
        return [(await play_timed(plan, player))[0] for plan in plans]

    assert [*map(trial_to_json, many)] == [*map(trial_to_json, asyncio.run(one_by_one()))]


@pytest.mark.parametrize(
    ("agent", "condition"),
    [
        *(("random", f"flip?p=0.4&{more}") for more in ("at=3", "only=moved", "while=looping")),
        *(("random", condition) for condition in ("nudge", "flip?p=0.4 + flip?p=0.4", "tremble?p=0.1")),
        ("python:randomly:Mine", "flip?p=0.4"),
    ],
)
def test_what_the_kernel_does_not_know_is_the_loops(tmp_path, monkeypatch, agent, condition):
    (tmp_path / "randomly.py").write_text(
        "from lockprobe.agents.strategies import RandomAgent\nclass Mine(RandomAgent): ..."
    )
    monkeypatch.syspath_prepend(tmp_path)
    allow(agent)
    assert minds_of(resolve(agent).make(), plans_of(agent, condition)[0]) is None

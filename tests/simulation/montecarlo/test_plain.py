"""The plain loop is the closed loop of a trial, without its records."""

from typing import get_args

import pytest
from diary import Diary, as_recorded
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe import run_trial
from lockprobe.boxes.box import Shuffle
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.simulation.montecarlo.plain import heeds_order, play_plainly, policy_of, world_of
from lockprobe.simulation.montecarlo.streams import FromTree, order_of

FLIPS = [
    *(OutcomeFlip(inverts=inverts, keep=keep) for inverts in ("position", "outcome") for keep in (0, 0.5, 1)),
    OutcomeFlip(inverts="position", others="noisy"),
]
PARTS = [OutcomeFlip(part="outcome"), *(OutcomeFlip(part="position", keep=keep) for keep in (0, 0.5))]
TOLD = st.tuples(st.sampled_from(FLIPS), st.sampled_from(["state", "outcome", "both"])) | st.tuples(
    st.sampled_from(PARTS), st.just("both")
)
"""What a false report is, and what reports tell; one part of it alone needs both."""


@settings(max_examples=25, deadline=None)
@given(
    name=st.sampled_from(["chain-2", "chain-4", "reset", "random-5-17", "chain-8"]),
    told_by=TOLD,
    p=st.sampled_from([0.0, 0.3, 1.0]),
    seed=st.integers(0, 9),
    trial=st.integers(1, 5),
    shuffle=st.sampled_from(get_args(Shuffle)),
    max_steps=st.integers(1, 25),
)
def test_a_trial_played_plainly_is_the_trial_on_record(name, told_by, p, seed, trial, shuffle, max_steps):
    like, tell = told_by
    world = world_of(name, flip=like.at_rate(p), max_steps=max_steps, tell=tell)
    tree = FromTree(seed, 2, len(box(name).joints), order=order_of(box(name), shuffle, seed), flips=0, draws=0)
    played = play_plainly(Diary(), world, *tree.luck(trial - 1))
    recorded = run_trial(
        agent=Diary(),
        box=name,
        condition=[like.at_rate(p)],
        seed=seed,
        repetition=2,
        trial=trial,
        shuffle=shuffle,
        max_steps=max_steps,
        modality=f"symbolic?tell={tell}",
    )
    assert (played.joints, played.moved, played.told_moved, played.solved) == as_recorded(recorded)


def test_only_what_looks_at_places_in_the_listing_heeds_its_order():
    heedless = ("random", "random-no-repeat", "human-inspired:proximity", "cognitive:random-map",
                "cognitive:loop-breaker", "cognitive:softmax-memory?closed=1")  # fmt: skip
    heeding = ("round-robin", "cognitive:softmax-memory?position=1")
    assert not any(heeds_order(policy_of(agent)) for agent in heedless)
    assert all(map(heeds_order, (*map(policy_of, heeding), Diary())))


def test_mistakes_are_one_line():
    with pytest.raises(UnknownName, match=r"^no agent is called 'rundom'"):
        policy_of("rundom")
    with pytest.raises(UnknownName, match=r"^no box is called 'chain-9'"):
        world_of("chain-9", flip=OutcomeFlip(), max_steps=20)
    with pytest.raises(BadValue, match=r"^max_steps: got 20000, expected a whole number from 1 to 10000$"):
        world_of("chain-4", flip=OutcomeFlip(), max_steps=20_000)

"""An episode without the loop says what the loop says, step by step, and the loop writes its record."""

from dataclasses import dataclass
from typing import get_args

import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import LayoutKind, Shuffle
from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.gymnasium.held_episode import HeldEpisode
from lockprobe.interfaces.gymnasium.plain_episode import PlainBox, PlainEpisode, is_plain
from lockprobe.interfaces.gymnasium.settings import EpisodeKey, read_settings
from lockprobe.interfaces.gymnasium.single import LockboxEnv
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.trial.plan import Names

CONDITIONS = [
    "truth",
    "flip?p=1",
    "flip?p=0.4",
    "flip?p=0.4&others=kept",
    "flip?p=0.4&keep=0.5",
    "flip?p=0&keep=0.5",
    "flip?p=0.4&inverts=position",
    "flip?p=0.4&inverts=position&others=noisy",
    "flip?p=0.4&part=outcome",
    "flip?p=0.4&inverts=position&keep=0.5&part=position",
    "flip?p=0.3&inverts=position + flip?p=0 + flip?p=0.4&keep=0.7",
]
WHOLE = ["symbolic", "symbolic?form=json&places=yes"]
TELLING = [*WHOLE, "symbolic?tell=state", "symbolic?tell=outcome"]
asked_for = st.fixed_dictionaries(
    {
        "box": st.sampled_from(["chain-2", "chain-4", "chain-6"]),
        "layout": st.sampled_from(get_args(LayoutKind)),
        "shuffle": st.sampled_from(get_args(Shuffle)),
        "max_steps": st.sampled_from([3, 20]),
        "steps_left": st.booleans(),
        "info": st.sampled_from([None, "truth"]),
    }
)


def said(episode):
    return episode.observation(), episode.info(), episode.words()


@pytest.mark.parametrize("condition", CONDITIONS)
@given(asked=asked_for, data=st.data(), key=st.builds(EpisodeKey, st.integers(), st.integers(1, 9), st.integers(1, 99)))
@settings(max_examples=15, deadline=None)
def test_it_says_what_the_loop_says(condition, asked, data, key):
    modality = data.draw(st.sampled_from(WHOLE if "part" in condition else TELLING))
    read = read_settings(asked | {"condition": condition, "modality": modality})
    plain, loop = PlainEpisode(read, PlainBox(read), key), HeldEpisode(read, key)
    assert data_equivalence(said(plain), said(loop), exact=True)
    rng = np.random.default_rng(abs(key.seed))
    while loop.ending is None:
        action = int(rng.integers(len(read.study.box.joints)))
        plain.attempt(action)
        loop.attempt(action)
        assert data_equivalence(said(plain), said(loop), exact=True)
        assert plain.ending == loop.ending
    assert plain.record() == loop.finished


def test_the_record_is_made_once_when_it_is_asked_for(monkeypatch):
    made, record = [], PlainEpisode.record
    monkeypatch.setattr(PlainEpisode, "record", lambda episode: made.append(episode) or record(episode))
    env = LockboxEnv(p=0.3)
    env.reset(seed=4)
    for joint in (3, 2, 1, 0):
        env.step(joint)
    assert made == []
    assert env.trial.solved
    env.reset()
    assert env.trial is env.trial
    assert len(made) == 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Never(OutcomeFlip):
    """A flip of a package: it looks like one, and says the truth."""

    def perceive(self, percept, past, task, rng):
        return percept


@pytest.mark.parametrize(
    "asked",
    [
        {"condition": "flip?p=0.4&only=moved"},
        {"condition": "flip?p=0.4&at=3"},
        {"condition": "flip?p=0.4 + tremble?p=0.1"},
        {"condition": "drop?p=0.1"},
        {"condition": [Never(p=0.4)]},
        {"plant": "fast-twin"},
    ],
)
def test_nothing_but_flips_of_all_attempts_alike_is_plain(asked):
    read = read_settings(asked)
    assert not is_plain(read)
    with pytest.raises(BadValue, match="vectorization_mode="):
        PlainBox(read)
    assert is_plain(read_settings({"condition": "flip?p=0.2&keep=0.5 + flip?p=0.1", "layout": "shuffled"}))


def test_a_flip_of_a_package_acts_as_it_is_written():
    env = LockboxEnv(condition=[Never(p=1.0)])
    env.reset(seed=1)
    told, *_ = env.step(3)
    assert told[2:].tolist() == [2, 0, 0, 0, 1]


def test_listings_of_many_trials_are_those_of_each():
    keys = [EpisodeKey(seed, repetition, trial) for seed in (0, 2**64) for repetition in (1, 3) for trial in (1, 2, 9)]
    for shuffle in get_args(Shuffle):
        for layout in get_args(LayoutKind):
            read = read_settings({"shuffle": shuffle, "layout": layout, "box": "chain-6"})
            plans = [read.plan(*key) for key in keys]
            each = [[read.study.box.names.index(plan.box.names[at]) for at in Names(plan).order] for plan in plans]
            assert PlainBox(read).listings(keys).tolist() == each

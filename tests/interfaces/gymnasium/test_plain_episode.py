"""An episode without the loop says what the loop says, step by step, and the loop writes its record."""

from typing import get_args

import numpy as np
import pytest
from gymnasium.utils.env_checker import data_equivalence
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.boxes.box import LayoutKind, Shuffle
from lockprobe.interfaces.gymnasium.held_episode import HeldEpisode
from lockprobe.interfaces.gymnasium.plain_episode import PlainEpisode
from lockprobe.interfaces.gymnasium.plain_rules import PlainRules
from lockprobe.interfaces.gymnasium.settings import EpisodeKey, read_settings
from lockprobe.interfaces.gymnasium.single import LockboxEnv

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
    plain, loop = PlainEpisode(read, PlainRules(read), key), HeldEpisode(read, key)
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

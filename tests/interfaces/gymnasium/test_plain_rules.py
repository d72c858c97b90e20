"""Which settings are plain, and that nothing else is played by their rules."""

from dataclasses import dataclass

import pytest

from lockprobe.foundation.errors import BadValue
from lockprobe.interfaces.gymnasium.plain_episode import PlainEpisode
from lockprobe.interfaces.gymnasium.plain_rules import PlainRules, is_plain
from lockprobe.interfaces.gymnasium.settings import EpisodeKey, read_settings
from lockprobe.interfaces.gymnasium.single import LockboxEnv
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.words import TextChannel


@dataclass(frozen=True, slots=True, kw_only=True)
class Never(OutcomeFlip):
    """A flip of a package: it looks like one, and says the truth."""

    def perceive(self, percept, past, task, rng):
        return percept


PLAIN = [
    {},
    {"p": 0.4, "flip": "sticky", "shuffle": "trial"},
    {"condition": "flip?p=0.2&keep=0.5 + flip?p=0.1&inverts=position&others=noisy", "layout": "shuffled"},
    {"modality": "symbolic?tell=state&form=json", "box": "chain-6", "steps_left": True},
]
OTHERS = [
    {"condition": "flip?p=0.4&only=moved"},
    {"condition": "flip?p=0.4&at=3"},
    {"condition": "flip?p=0.4 + tremble?p=0.1"},
    {"condition": "drop?p=0.1"},
    {"condition": [Never(p=0.4)]},
    {"plant": "fast-twin"},
]


@pytest.mark.parametrize("asked", PLAIN)
def test_flips_of_all_attempts_alike_are_plain(asked):
    env = LockboxEnv(**asked)
    env.reset(seed=1)
    assert is_plain(env.settings)
    assert isinstance(env._episode, PlainEpisode)


@pytest.mark.parametrize("asked", OTHERS)
def test_whatever_else_acts_is_not(asked):
    env_settings = read_settings(asked)
    assert not is_plain(env_settings)
    with pytest.raises(BadValue, match="vectorization_mode="):
        PlainRules(env_settings)


def test_a_flip_of_a_package_acts_as_it_is_written():
    env = LockboxEnv(condition=[Never(p=1.0)])
    env.reset(seed=1)
    told, *_ = env.step(3)
    assert told[2:].tolist() == [2, 0, 0, 0, 1]


def test_listings_of_many_trials_are_those_of_each():
    keys = [EpisodeKey(seed, repetition, trial) for seed in (0, 2**64) for repetition in (1, 3) for trial in (1, 2, 9)]
    for shuffle in ("never", "study", "trial"):
        for layout in ("fixed", "dealt", "shuffled"):
            rules = PlainRules(read_settings({"shuffle": shuffle, "layout": layout, "box": "chain-6"}))
            each = [list(rules.listing(key)) for key in keys]
            assert [list(listing) for listing in rules.listings(keys)] == each
            assert rules.same_listing == (len({str(listing) for listing in each}) == 1)


def test_words_do_not_matter_to_the_rules():
    assert type(read_settings({}).chain[-1]) is TextChannel
    rules = PlainRules(read_settings({"modality": "symbolic?tell=outcome&places=yes"}))
    assert (rules.tells_positions, rules.tells_outcomes) == (False, True)

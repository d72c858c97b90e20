"""One box: Gymnasium's contract, and the very trials that a study plays."""

import copy
import pickle
from dataclasses import dataclass, replace
from typing import get_args

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import FlattenObservation, FrameStackObservation, TimeLimit
from hypothesis import given, settings
from hypothesis import strategies as st

import lockprobe.interfaces.gymnasium
from lockprobe import run_trial, tidy_rows
from lockprobe.boxes.box import Shuffle
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import BadValue, ChannelFault, UnknownName
from lockprobe.interfaces.gymnasium.single import LockboxEnv
from lockprobe.interventions.done import Tremble
from lockprobe.interventions.flip import OutcomeFlip
from lockprobe.interventions.told import Drop
from lockprobe.trial.record import Percept
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

FLIPS = ("re-observed", "integrated", "outcome-only")


def made(**asked):
    return gymnasium.make(lockprobe.interfaces.gymnasium.ENVIRONMENT, **asked)


def flip(p, others="fresh"):
    return f"flip?p={p}&others={others}"


def episode(env, actions, **asked):
    """Observations and rewards of one episode under these actions, until it ends."""
    told, rewards = [env.reset(**asked)[0]], []
    for action in actions:
        seen, reward, terminated, truncated, _ = env.step(action)
        told.append(seen)
        rewards.append(reward)
        if terminated or truncated:
            break
    return np.array(told).tolist(), rewards


@pytest.mark.parametrize(
    "asked",
    [
        {},
        {"box": "chain-2", "condition": flip(0.5, "kept"), "shuffle": "trial"},
        {"box": "chain-8", "condition": flip(0.3, "kept"), "steps_left": True, "max_steps": 5},
        {"condition": [OutcomeFlip(p=1.0), OutcomeFlip(p=0.2, others="kept")], "info": "truth", "step_cost": 0.1},
        {"modality": "symbolic?tell=state", "p": 0.4, "layout": "shuffled"},
        {"modality": "symbolic?tell=outcome", "condition": "tremble?p=0.3 + yoked?p=0.2"},
        {"condition": [Drop(p=0.5), Tremble(p=0.2)], "steps_left": True},
        {"condition": "delay?lag=2", "shuffle": "trial"},
    ],
)
def test_gymnasium_finds_nothing_to_say_against_it(asked):
    check_env(made(**asked).unwrapped)


@pytest.mark.parametrize("kind", FLIPS)
@given(
    seed=st.integers(0, 10_000), repetition=st.integers(1, 9), trial=st.integers(1, 99), shuffle=st.sampled_from(get_args(Shuffle)),
    p=st.sampled_from([0.0, 0.3, 1.0]), name=st.sampled_from(["chain-3", "chain-4", "chain-6"]),
)  # fmt: skip
@settings(max_examples=20, deadline=None)
def test_an_episode_is_the_trial_of_the_study(kind, seed, repetition, trial, shuffle, p, name):
    there = run_trial(
        agent="random",
        box=name,
        p=p,
        flip=kind,
        seed=seed,
        repetition=repetition,
        trial=trial,
        shuffle=shuffle,
        modality="symbolic",
    )
    env = LockboxEnv(box=name, p=p, flip=kind, shuffle=shuffle)
    first, _ = env.reset(seed=seed, options={"repetition": repetition, "trial": trial})
    assert first[0] == there.listing.index(there.labels[0])
    for step in there.steps:
        action = there.listing.index(step.decision.joint)
        told, reward, terminated, truncated, info = env.step(action)
        assert told[1:3].tolist() == [action + 1, 1 + step.told_moved]
        if kind == "outcome-only":
            assert step.told_state is None
            assert len(told) == 3
        else:
            at = dict(zip(there.listing, told[3:].tolist(), strict=True))
            assert "".join(str(at[label]) for label in there.labels) == step.told_state
        assert info == {}
    assert (terminated, truncated) == (there.ending == "solved", there.ending == "budget")
    assert reward == float(terminated)
    here = env.trial
    named = {"key": there.key, "study": there.study, "agent": there.agent}
    assert replace(here, **named) == replace(there, steps=here.steps)
    assert [replace(step, decision=None) for step in here.steps] == [
        replace(step, decision=None) for step in there.steps
    ]


def record_of(env, there, **options):
    """The record of the episode in which the same joints are chosen."""
    env.reset(seed=there.seed, options=options)
    for step in there.steps:
        env.step(there.listing.index(there.labels[there.joints.index(step.chosen or step.joint)]))
    return env.trial


@pytest.mark.parametrize(
    "asked",
    [
        {"p": 0.3, "flip": "sticky"},
        {"condition": "tremble?p=0.3 + flip?p=0.2", "layout": "shuffled"},
        {"condition": "force?at=2 + delay?lag=1", "p": 0.4, "max_steps": 9},
        {"condition": [Drop(p=0.3)], "modality": "symbolic?tell=state", "shuffle": "never", "box": "chain-6"},
        {"condition": "yoked?p=0.4 + correction?p=0.5", "modality": "symbolic?form=json&places=yes"},
    ],
)
@pytest.mark.parametrize("seed", [1, 5])
def test_under_every_condition_the_record_is_that_of_the_trial(asked, seed):
    there = run_trial(agent="random", seed=seed, repetition=2, trial=7, **({"modality": "symbolic"} | asked))
    here = record_of(LockboxEnv(**({"shuffle": "trial"} | asked)), there, repetition=2, trial=7)
    assert here.key == there.key.replace("trial/random", "lockbox/gymnasium", 1)
    assert replace(here, key="", study="", agent="", steps=()) == replace(there, key="", study="", agent="", steps=())
    assert [replace(step, decision=None) for step in here.steps] == [
        replace(step, decision=None) for step in there.steps
    ]


@given(seed=st.integers(0, 10_000), p=st.sampled_from([0.0, 0.5]), actions=st.lists(st.integers(0, 3), min_size=1))
@settings(max_examples=30, deadline=None)
def test_reports_of_states_hold_no_outcome(seed, p, actions):
    """Two boxes whose told states agree look alike, whatever really moved; and what is told follows the flips."""
    env = LockboxEnv(modality="symbolic?tell=state", p=p, box="chain-4", shuffle="trial")
    told, _ = episode(env, actions[:20], seed=seed)
    assert env.settings.sizes[2] == 1
    assert {one[2] for one in told} == {0}
    other = LockboxEnv(p=p, box="chain-4", shuffle="trial", info="truth")
    both, _ = episode(other, actions[:20], seed=seed)
    assert [one[:2] + one[3:] for one in told] == [one[:2] + one[3:] for one in both]
    *_, info = env.reset()
    assert info == {}


def test_a_finished_episode_is_a_record_that_the_analyses_take():
    env = LockboxEnv(condition=flip(0.5))
    assert env.trial is None
    episode(env, [3, 2, 1, 0], seed=4)
    assert env.trial.solved
    assert env.trial.channels == run_trial(p=0.5, modality="symbolic").channels
    assert trial_from_json(trial_to_json(env.trial)) == env.trial
    assert [row["moved"] for row in tidy_rows([env.trial])] == [1, 1, 1, 1]
    finished = env.trial
    env.reset()
    env.step(0)
    assert env.trial is finished


def test_the_end_is_decided_by_the_truth():
    _, rewards = episode(LockboxEnv(condition=flip(1.0)), [3, 2, 1, 0, 0])
    assert rewards == [0.0, 0.0, 0.0, 1.0]
    told, rewards = episode(LockboxEnv(condition=flip(1.0), max_steps=7, step_cost=0.25), [0] * 9)
    assert rewards == [-0.25] * 7
    assert all(entry[2] == 2 for entry in told[1:])  # the target is said to move every time


def test_the_last_step_can_solve_it():
    env = LockboxEnv(max_steps=4)
    env.reset()
    assert [env.step(joint)[2:4] for joint in (3, 2, 1, 0)] == [(False, False)] * 3 + [(True, False)]


@dataclass(frozen=True)
class Silent:
    def perceive(self, percept, past, task, rng):
        return Percept(joint=percept.joint)


def test_what_is_not_told_is_not_seen():
    actions = [1, 2, 3, 1, 2]
    chain, free = box("chain-4"), replace(box("chain-4"), interlock={"revolute-left": ({"slider-1": True},)})
    quiet = [episode(LockboxEnv(box=one, condition=[Silent()]), actions, seed=1)[0] for one in (chain, free)]
    plain = [episode(LockboxEnv(box=one), actions, seed=1)[0] for one in (chain, free)]
    assert quiet[0] == quiet[1] == [[0, 0, 0], *([0, joint + 1, 0] for joint in actions)]
    assert plain[0] != plain[1]


def test_the_truth_is_there_for_those_who_ask():
    env = LockboxEnv(box="chain-6", condition=flip(0.5), info="truth", shuffle="trial")
    joints, total = (0, 1, 2, 3, 4) * 3, 0  # never all six, so never solved
    for seed in range(20):
        _, info = env.reset(seed=seed)
        before, moves = info["truth"]["positions"], 0
        assert not info["truth"]["moved"]
        for joint in joints:
            *_, info = env.step(joint)
            after, moved = info["truth"]["positions"], info["truth"]["moved"]
            assert np.flatnonzero(before != after).tolist() == [joint] * moved
            before, moves = after, moves + moved
        assert list(info) == ["truth"]
        total += moves
    assert total > 20


def test_a_seed_fixes_everything_after_it_and_a_reset_goes_on():
    actions = np.random.default_rng(0).integers(4, size=20).tolist()
    env, other = (LockboxEnv(condition=flip(0.5), shuffle="trial") for _ in range(2))
    first = [episode(env, actions, **asked) for asked in ({"seed": 7}, {}, {})]
    assert [episode(other, actions, **asked) for asked in ({"seed": 7}, {}, {})] == first
    assert episode(other, actions[:3], seed=7, options={"trial": 2})[0] == first[1][0][:4]  # not played to its end
    assert episode(other, actions) == first[2]
    assert len({str(one) for one in first}) == 3
    assert episode(env, actions, seed=8) != first[0]
    assert episode(env, actions, options={"repetition": 2, "trial": 1}) != episode(env, actions, seed=8)


def test_without_a_seed_every_environment_has_its_own_luck():
    actions = np.random.default_rng(0).integers(4, size=20).tolist()
    assert len({str(episode(LockboxEnv(condition=flip(0.5), shuffle="trial"), actions)) for _ in range(4)}) == 4


def test_conditions_share_their_luck():
    def false_reports(p):
        env = LockboxEnv(condition=flip(p), info="truth")
        env.reset(seed=3)
        steps = [env.step(joint) for joint in (1, 2, 3, 1, 3, 2) * 3]
        return {i for i, (told, *_, info) in enumerate(steps) if (told[2] == 2) != info["truth"]["moved"]}

    assert false_reports(0.0) == set()
    assert false_reports(0.2) < false_reports(0.5) < false_reports(1.0) == set(range(18))


@pytest.mark.parametrize("condition", [flip(0.5, "kept"), "flip?p=0.5 + drop?p=0.3"])
@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_as_the_original_does(copied, condition):
    env = made(condition=condition, shuffle="trial", info="truth", max_steps=9)
    env.reset(seed=2)
    for action in (0, 1, 2):
        env.step(action)
    twin = copied(env)
    rest = [0, 3, 1, 2, 3, 0]
    assert repr([twin.step(action) for action in rest]) == repr([env.step(action) for action in rest])
    assert twin.unwrapped.trial == env.unwrapped.trial == copied(twin).unwrapped.trial
    assert twin.reset()[0].tolist() == env.reset()[0].tolist()


def test_the_panel_in_words_says_what_is_told():
    env = made(render_mode="ansi", condition=flip(1.0))
    env.reset(seed=1)
    assert env.render() == "Joints: 0 A, 1 B, 2 C, 3 D. Target: A. Steps left: 20.\nAt 1: none."
    env.step(3)
    assert env.render() == "Joints: 0 A, 1 B, 2 C, 3 D. Target: A. Steps left: 19.\nD did not move. At 1: none."
    quiet = LockboxEnv(render_mode="ansi", modality="symbolic?tell=outcome")
    quiet.reset(seed=1)
    quiet.step(3)
    assert quiet.render().endswith("\nD moved.")
    assert LockboxEnv().render() is None


def test_standard_wrappers_take_its_observations():
    env = FrameStackObservation(made(), stack_size=3)
    assert env.observation_space.contains(env.reset(seed=1)[0])
    flat = FlattenObservation(made(steps_left=True, max_steps=6))
    assert flat.observation_space.shape == (4 + 5 + 3 + 2 * 4 + 7,)
    assert flat.reset(seed=1)[0].sum() == 8  # one in every entry
    shorter = TimeLimit(made(), max_episode_steps=2)
    shorter.reset(seed=1)
    assert [shorter.step(0)[3] for _ in range(2)] == [False, True]


def test_the_settings_can_be_written_down_and_made_again():
    env = made(box="chain-3", condition=flip(0.5), max_steps=9)
    again = gymnasium.make(gymnasium.envs.registration.EnvSpec.from_json(env.spec.to_json()))
    assert again.unwrapped.settings == env.unwrapped.settings


def test_a_mistake_is_said_in_one_line():
    with pytest.raises(BadValue, match="^modality: got 'rgb', expected a plant with a camera, fast-twin or twin"):
        made(observation="rgb")
    with pytest.warns(UserWarning, match="render_mode='ascii'"):
        blind = made(render_mode="ascii")
    blind.reset(seed=1)
    with pytest.raises(
        UnknownName,
        match="^no render mode is called 'ascii' .did you mean 'ansi'..; there are: ansi, rgb_array, depth_array$",
    ):
        blind.unwrapped.render()
    env = LockboxEnv()
    with pytest.raises(ResetNeeded):
        env.step(0)
    for options, message in (
        ({"trail": 1}, "no option of reset is called 'trail' .did you mean 'trial'"),
        ({"trial": 0}, "trial: got 0, expected a whole number of at least 1"),
    ):
        with pytest.raises((BadValue, UnknownName), match=message):
            env.reset(options=options)
    env.reset()
    for action in (4, -1, 1.0, "A"):
        with pytest.raises(BadValue, match="action: got .*, expected a whole number from 0 to 3"):
            env.step(action)
    episode(env, [3, 2, 1, 0])
    with pytest.raises(ResetNeeded):
        env.step(0)


@dataclass(frozen=True)
class Breaks:
    def perceive(self, percept, past, task, rng):
        if percept.joint is not None:
            raise ValueError("no light")
        return percept


def test_a_channel_that_breaks_is_no_failure_to_solve():
    env = LockboxEnv(condition=[Breaks()])
    env.reset(seed=1)
    with pytest.raises(ChannelFault, match="ValueError: no light"):
        env.step(0)
    assert env.trial is None
    with pytest.raises(ResetNeeded):
        env.step(0)
    env.reset()

"""Many boxes at once play what as many single environments play, step by step."""

from typing import get_args

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import data_equivalence
from gymnasium.vector import AsyncVectorEnv, AutoresetMode, SyncVectorEnv
from hypothesis import given, settings
from hypothesis import strategies as st

import lockprobe.interfaces.gymnasium
from lockprobe.boxes.box import Joint, LayoutKind, Lockbox, Shuffle
from lockprobe.foundation.errors import BadValue, UnknownName
from lockprobe.interfaces.gymnasium.vector import LockboxVectorEnv
from lockprobe.trial.record import Percept

COUNT = 6
FORK = Lockbox(
    name="fork",
    joints=tuple(Joint(name=name, kind="prismatic") for name in "tabc"),
    interlock={"t": ({"a": True}, {"b": False, "c": True}), "a": ({"b": True},), "b": ({"c": False},)},
    initial=(False, False, True, False),
    target="t",
)


def made(mode=None, count=COUNT, **asked):
    return gymnasium.make_vec(
        lockprobe.interfaces.gymnasium.ENVIRONMENT, num_envs=count, vectorization_mode=mode, **asked
    )


def equal(one, other):
    """Equal in every number, kind of number and key."""
    return all(data_equivalence(here, there, exact=True) for here, there in zip(one, other, strict=True))


flips = st.builds(
    "flip?p={}&inverts={}&keep={}".format,
    st.sampled_from([0.0, 0.2, 0.6, 1.0]),
    st.sampled_from(["position", "outcome"]),
    st.sampled_from([0.0, 0.5, 1.0]),
)
further = st.sampled_from(
    [
        "flip?p=0.4&inverts=position&others=noisy",
        "flip?p=0.4&part=outcome",
        "flip?p=0.4&part=position",
        "flip?p=0.4&inverts=position&keep=0.5&part=position",
    ]
)
by_flips = st.fixed_dictionaries({"condition": st.lists(flips | further, min_size=1, max_size=3).map(" + ".join)})
by_condition = st.fixed_dictionaries(
    {},
    optional={
        "condition": st.sampled_from(
            [
                "truth",
                "flip?p=0.4",
                "flip?p=0.3&others=kept",
                "flip?p=0.4&inverts=outcome&keep=0.7",
                "flip + flip?p=0.5",
            ]
        ),
        "modality": st.sampled_from(["symbolic", "symbolic?tell=state", "symbolic?tell=outcome&form=json"]),
        "layout": st.sampled_from(get_args(LayoutKind)),
    },
) | st.fixed_dictionaries(
    {
        "p": st.sampled_from([0.0, 0.4, 1.0]),
        "flip": st.sampled_from(["transient", "sticky", "independent", "integrated", "outcome-only"]),
        "modality": st.sampled_from([None, "symbolic?tell=outcome"]),
    }
)
general = st.fixed_dictionaries(
    {
        "box": st.sampled_from(["chain-2", "chain-3", "chain-4", FORK]),
        "max_steps": st.sampled_from([2, 7, 20]),
        "shuffle": st.sampled_from(get_args(Shuffle)),
        "steps_left": st.booleans(),
        "step_cost": st.sampled_from([0.0, 0.125]),
        "info": st.sampled_from([None, "truth"]),
    }
)
asked_for = st.builds(lambda some, others: some | others, general, by_flips | by_condition)


@given(asked=asked_for, seed=st.integers(0, 10_000))
@settings(max_examples=12, deadline=None)
def test_it_plays_as_so_many_single_environments(asked, seed):
    ours, sync = made(**asked), made("sync", **asked)
    assert (type(ours.unwrapped), type(sync.unwrapped)) == (LockboxVectorEnv, SyncVectorEnv)
    assert ours.observation_space == sync.observation_space
    assert ours.action_space == sync.action_space
    assert equal(ours.reset(seed=seed), sync.reset(seed=seed))
    rng, ended = np.random.default_rng(seed), 0
    for _ in range(45):
        joints = rng.integers(ours.single_action_space.n, size=COUNT)
        here = ours.step(joints)
        assert equal(here, sync.step(joints))
        assert here[0] in ours.observation_space
        ended += int((here[2] | here[3]).sum())
    assert ended > COUNT  # every environment began anew at least once
    assert equal(ours.reset(), sync.reset())
    joints = rng.integers(ours.single_action_space.n, size=COUNT)
    assert equal(ours.step(joints), sync.step(joints))


@given(asked=asked_for, seeds=st.lists(st.none() | st.integers(0, 99), min_size=COUNT, max_size=COUNT), data=st.data())
@settings(max_examples=8, deadline=None)
def test_seeds_options_and_masks_mean_the_same(asked, seeds, data):
    ours, sync = made(**asked), made("sync", **asked)
    options = {"repetition": data.draw(st.integers(1, 5)), "trial": data.draw(st.integers(1, 30))}
    rng = np.random.default_rng(1)

    def go_on():
        for _ in range(4):
            joints = rng.integers(ours.single_action_space.n, size=COUNT)
            assert equal(ours.step(joints), sync.step(joints))

    for env in (ours, sync):
        env.reset(seed=5)
    assert equal(ours.reset(seed=seeds, options=dict(options)), sync.reset(seed=seeds, options=dict(options)))
    go_on()
    mask = np.array(data.draw(st.lists(st.booleans(), min_size=COUNT, max_size=COUNT)))
    mask[data.draw(st.integers(0, COUNT - 1))] = True
    here, there = (env.reset(seed=seeds, options={"reset_mask": mask.copy()}) for env in (ours, sync))
    assert (here[0] == there[0]).all()
    go_on()


def test_an_end_is_followed_by_a_reset_whatever_the_action_is():
    ours = made(count=2, max_steps=2)
    assert ours.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP
    ours.reset(seed=1)
    ours.step(np.array([3, 3]))
    *_, truncated, _ = ours.step(np.array([2, 2]))
    assert truncated.all()
    told, rewards, terminated, truncated, _ = ours.step(np.array([1, 0]))
    assert told.tolist() == [[0] * 7] * 2
    assert not np.any([rewards, terminated, truncated])


def test_several_processes_play_the_same():
    asked = {"condition": "flip?p=0.4", "shuffle": "trial", "max_steps": 3}
    ours, apart = made(count=2, **asked), made("async", count=2, vector_kwargs={"context": "spawn"}, **asked)
    try:
        assert isinstance(apart.unwrapped, AsyncVectorEnv)
        assert equal(ours.reset(seed=2), apart.reset(seed=2))
        for joint in range(6):
            joints = np.array([joint % 4, 3 - joint % 4])
            assert equal(ours.step(joints), apart.step(joints))
    finally:
        apart.close()


def test_what_is_returned_is_not_written_to_again():
    ours = made(info="truth")
    first, info = ours.reset(seed=1)
    held = (first, info["truth"]["positions"], info["truth"]["moved"])
    kept = [array.copy() for array in held]
    for joint in (3, 2, 1):
        ours.step(np.full(COUNT, joint))
    assert all((now == then).all() for now, then in zip(held, kept, strict=True))


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.uint64])
def test_every_kind_of_whole_number_is_an_action(kind):
    envs = [made(box="chain-8", condition="flip?p=0.4&keep=0.5", info="truth") for _ in range(2)]
    for env in envs:
        env.reset(seed=1)
    for joint in (7, 6, 5, 4, 7, 0):
        here, there = (env.step(np.full(COUNT, joint, dtype=one)) for env, one in zip(envs, (kind, int), strict=True))
        assert equal(here, there)


class Dim:
    def perceive(self, percept, past, task, rng):
        return Percept(joint=percept.joint, outcome=percept.outcome)


def test_a_mistake_is_said_in_one_line():
    for asked, message in (
        (
            {"condition": [Dim()]},
            'expected a flip of p, inverts, others, keep and part alone; vectorization_mode="sync" plays any other',
        ),
        ({"render_mode": "ansi"}, 'render_mode: got .ansi., expected None; vectorization_mode="sync" renders'),
        (
            {"observation": "rgb", "plant": "fast-twin"},
            "observation: got .rgb., expected symbolic; vectorization_mode=",
        ),
        (
            {"plant": "twin"},
            'plant: got .twin., expected symbolic; vectorization_mode="sync" or "async" plays all others',
        ),
        ({"condition": "tremble?p=0.2"}, "condition: got .tremble.p=0.2., .*plays any other"),
        ({"condition": "phantom?p=0.2"}, "condition: got .phantom.p=0.2., .*plays any other"),
        ({"condition": "flip?p=0.2&only=moved"}, "condition: got .flip.p=0.2&only=moved., .*plays any other"),
        ({"seed": 3}, r"seed: got 3, expected reset\(seed=...\)"),
        ({"count": 0}, "num_envs: got 0, expected a whole number of at least 1"),
    ):
        with pytest.raises(BadValue, match=message):
            made(**asked)
    with pytest.raises(UnknownName, match="no setting of the environment is called 'max_episode_steps'"):
        made(max_episode_steps=3)
    ours = made(p=0.5)
    with pytest.raises(ResetNeeded):
        ours.step(np.zeros(COUNT, dtype=int))
    with pytest.raises(ResetNeeded):
        ours.reset(options={"reset_mask": np.arange(COUNT) < 2})
    for seed in ([1, 2], 1.5):
        with pytest.raises(BadValue, match="seed: got .*, expected a whole number, or 6 of them"):
            ours.reset(seed=seed)
    with pytest.raises(BadValue, match="reset_mask: got .*, expected an array of 6 truth values"):
        ours.reset(options={"reset_mask": np.ones(3, dtype=bool)})
    with pytest.raises(UnknownName, match="no option of reset is called 'p'"):
        ours.reset(options={"p": 0.5})
    ours.reset(seed=1)
    for actions in (np.full(COUNT, 4), np.full(COUNT, -1), np.zeros(2, dtype=int), np.zeros(COUNT), 0):
        with pytest.raises(BadValue, match="actions: got .*, expected 6 whole numbers from 0 to 3"):
            ours.step(actions)


def test_boxes_of_one_name_differ_in_luck_and_unseeded_ones_too():
    ours = made(count=50, p=0.5, shuffle="trial")
    for seed in (3, None):
        ours.reset(seed=seed)
        told = np.array([ours.step(np.full(50, joint % 4))[0] for joint in range(8)])
        assert len({told[:, i].tobytes() for i in range(50)}) > 40

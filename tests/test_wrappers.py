"""The wrappers around environments of others: the laws of studies, luck by address, a record of truth and told."""

import json
from dataclasses import replace
from functools import partial
from itertools import pairwise, permutations

import gymnasium
import numpy as np
import pytest
from blicket import PLAYS, SILENT, outcome
from gymnasium.utils.env_checker import check_env
from minigrid_door import NAME, believer

import lockprobe
from lockprobe.interfaces.episodes.reading import read_episodes
from lockprobe.interfaces.gymnasium.environment import LockboxEnv
from lockprobe.trial.luck import Luck
from lockprobe.wrappers import Delay, FalseReports, Record, Tremble, Withhold

LIE, GAP, LATE, SLIP = (partial(FalseReports, p=0.4), partial(Withhold, p=0.3), partial(Delay), partial(Tremble, p=0.3))
SURE, WRITE = partial(FalseReports, p=1), partial(Record, agent="a", condition="c")


def wrapped(wraps, named=outcome, env=None):
    env = gymnasium.make("Blicket-v0") if env is None else env
    for wrap in wraps:
        env = wrap(env, **({} if wrap.func in (Tremble, Record) else {"outcome": named}))
    return env


def played(env, actions, seed=1):
    told = [env.reset(seed=seed)]
    while len(told) <= len(actions) and not any(told[-1][2:4]):
        told.append(env.step(actions[len(told) - 1]))
    return told


def rows(path):
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()]


def changed(before, action, after):
    return ("it changed", "it stayed") if np.any(before != after) else None


LAWS = {
    "flip?p=0.5&only=blocked": [partial(FalseReports, p=0.5, only="blocked")],
    "tremble?p=0.3 + flip?p=1&while=looping": [SLIP, partial(SURE, while_="looping")],
    "flip?p=0.4 + flip?p=0.4&only=moved&at=1;3;4;5": [LIE, partial(LIE, only="moved", at=[1, 3, 4, 5])],
    "drop?p=0.3 + tremble?p=0.3 + flip?p=0.4 + tremble?p=0.3": [GAP, SLIP, LIE, SLIP],
    "tremble?p=0.3&at=2 + flip?p=0.4 + delay?lag=1 + flip?p=0.4": [partial(SLIP, at=[2]), LIE, LATE, LIE],
    "flip?p=0.4 + drop?p=0.4&luck=flip": [LIE, partial(Withhold, p=0.4, luck="flip")],
    "delay?lag=3 + delay?lag=1 + delay?lag=0": [partial(Delay, lag=3), LATE, partial(Delay, lag=0)],
}


@pytest.mark.parametrize("condition", LAWS)
@pytest.mark.parametrize("seed", [*range(15), 2**62])
def test_around_a_lockbox_the_wrappers_tell_what_the_condition_of_a_study_tells(condition, seed):
    """Two implementations held together; the box has the name of the environment's class, so the luck is one."""
    box = replace(lockprobe.box("chain-4"), name="LockboxEnv")
    asked = {"box": box, "modality": "symbolic?tell=outcome", "shuffle": "trial"}
    actions, named = np.random.default_rng(seed).integers(4, size=20).tolist(), ("blocked", "moved")
    ours = wrapped(LAWS[condition], lambda before, action, after: named[:: 3 - 2 * after[2]], LockboxEnv(**asked))
    theirs = LockboxEnv(condition=condition, **asked)
    for given in (seed, None):  # an episode, and the next one
        for mine, other in zip(played(ours, actions, given), played(theirs, actions, given), strict=True):
            assert (mine[-1]["told"], mine[1:-1]) == ((None, *named)[other[0][2]], other[1:-1])


@pytest.mark.filterwarnings("ignore:.*is different from the unwrapped version")
@pytest.mark.parametrize("order", [*permutations([LIE, GAP, LATE, SLIP])])
def test_they_nest_in_any_order_and_gymnasium_has_nothing_to_say_against_it(order, tmp_path):
    paths = [tmp_path / f"{place}.jsonl" for place in range(5)]
    for place, path in enumerate(paths):
        played(wrapped([*order[:place], partial(WRITE, path=path), *order[place:]]), [0, 1, 2, 3] * 5)
    first, *others = map(rows, paths)
    assert others == [first] * 4
    for before, row in pairwise(first):
        assert row["told_falsely"] == (row["told"] not in (None, before["outcome"]))
    check_env(wrapped([*order, partial(WRITE, path=tmp_path / "checked.jsonl")]))
    for other, named in (("FrozenLake-v1", changed), (NAME, believer.outcome)):
        check_env(wrapped(order, named, gymnasium.make(other)), skip_render_check=True)


class Switches(gymnasium.Env):  # no text, no end, any action, and the observation is one array that changes
    observation_space, action_space = gymnasium.spaces.MultiBinary(2), gymnasium.spaces.Discrete(2, start=5)

    def reset(self, *, seed=None, options=None):
        self.on = np.zeros(2, np.int8)
        return self.on, {}

    def step(self, action):
        self.on[1] ^= str(action) == "6"
        return self.on, 0.5, False, False, {"told": "by itself"}


TOLD = [
    ([SURE], outcome, f"On the machine: A. {PLAYS}", PLAYS),
    ([partial(Withhold, p=1)], outcome, "On the machine: A. ", None),
    ([SURE], changed, f"On the machine: A. {SILENT} It stayed.", "it stayed"),
    ([partial(SURE, tell=lambda seen, truth, said: f"{truth}/{said}"), GAP], outcome, f"{SILENT}/{PLAYS}", PLAYS),
]


@pytest.mark.parametrize(("wraps", "named", "seen", "told"), TOLD)
def test_a_text_says_what_is_told_in_place_of_the_truth_or_as_a_sentence_more(wraps, named, seen, told):
    observation, *_, info = played(wrapped(wraps, named), [0])[1]
    assert (observation, info) == (seen, {"told": told})


def test_a_record_holds_whole_episodes_and_what_was_cut_short_without_an_end_and_report_reads_it(tmp_path):
    write = partial(WRITE, path=(path := tmp_path / "e.jsonl"))
    env = wrapped([partial(Tremble, p=1), SURE, write], changed, Switches())
    for seed in (3, None, 4):  # the third is under way when the process stops
        env.reset(seed=seed)
        observation, *_, info = env.step(np.int64(5))
        assert (observation.tolist(), info) == ([0, 1], {"told": "it stayed"})
    found = [[row[name] for name in ("task", "seed", "episode", "action", "done", "outcome")] for row in rows(path)]
    assert found == [["Switches", 3, episode, 5, 6, "it changed"] for episode in (1, 2)]
    again, other = (wrapped([partial(write, condition=name)], env=Switches()) for name in "cd")
    assert [again.holds(3), again.holds(3, 2), again.holds(4), other.holds(3)] == [True, True, False, False]
    with pytest.raises(lockprobe.UserMistake, match=r"episode: got '1 of seed 3', expected one that .* does not hold"):
        again.reset(seed=3)
    did = ["x" * 2000, "x" * 1999 + "y", "\ud800", np.float64(0.5), np.zeros(2), {"x": np.ones(1)}, (1,), None]
    path.write_text(path.read_text().rstrip())  # the last line has no end
    played(write(gymnasium.wrappers.TimeLimit(Switches(), len(did))), did)  # cut short with a reward
    played(write(gymnasium.make("FrozenLake-v1", is_slippery=False)), [1, 2])  # ended without one
    found = read_episodes([path])
    assert ([len({*one}) for one in found.actions], found.solved.tolist()[2:]) == ([1, 1, len(did), 2], [0, 0])
    for line in ("[1]", "{", "[" * 10**5, '{"agent": "a", "condition": "c", "task": "Switches"}'):
        path.write_text(f"\n{line}\n")
        with pytest.raises(lockprobe.UserMistake, match=r"\A.*e.jsonl: line 2: got [^\n]*\Z"):
            write(Switches())


REFUSED = {
    **{f"outcome: got {given}, expected a function of 3": partial(wrapped, [LIE], given) for given in (None, len)},
    "tell: got 3, expected a function of 3": partial(wrapped, [partial(LIE, tell=3)]),
    "outcome and tell of Withhold: got .*, expected those": lambda: GAP(wrapped([LIE]), outcome=changed),
    "Tremble: got <TimeLimit.*, expected Lockprobe's": lambda: SLIP(gymnasium.wrappers.TimeLimit(wrapped([LIE]), 9)),
    "actions of Tremble: got Box": lambda: SLIP(gymnasium.make("Pendulum-v1")),
    "outcome: got 'yes', expected two": lambda: played(wrapped([LIE], lambda *seen: "yes"), [0]),
    "outcome: got .'a', 'a'., expected two": lambda: played(wrapped([LIE], lambda *seen: ("a", "a")), [0]),
    "outcome: got .'1{1001}', ''., expected": lambda: played(wrapped([LIE], lambda *seen: ("1" * 1001, "")), [0]),
    "score: got 7, expected": lambda: played(WRITE(gymnasium.make(NAME), path="x/e", score=lambda _: 7), [0] * 1000),
}


@pytest.mark.parametrize("said", REFUSED)
def test_a_mistake_is_one_line(said):
    with pytest.raises(lockprobe.UserMistake, match=rf"\A.*{said}[^\n]*\Z"):
        REFUSED[said]()


def test_a_believer_loses_two_steps_for_each_lie_that_the_door_did_not_open(tmp_path):
    """Computed by hand: from its luck each episode, and from the steps of the truth how many are lost."""
    believer.main(tmp_path / "door.jsonl", range(60))
    found = {(row["condition"], row["seed"]): row for row in rows(tmp_path / "door.jsonl")}
    door = {row["seed"]: row["step"] for row in rows(tmp_path / "door.jsonl")[::-1] if row["told"]}
    needed = [found["flip?p=0", seed]["step"] for seed in range(60)]
    for p in (0, 0.2, 0.4):
        for seed, steps in enumerate(needed):
            luck, lost = Luck(seed=seed, box=NAME, repetition=1, trial=1), 0
            while luck.at("channel-0", door[seed] + lost).random() < p:
                lost += 2
            last, end = found[f"flip?p={p}", seed], steps + lost
            wins, score = end <= 14, 1 - 0.9 * (end / 14)
            assert (last["step"], last["solved"], last["score"]) == (min(end, 14), wins, score * wins)

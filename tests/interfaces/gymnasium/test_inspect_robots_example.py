"""The example in which policies of Inspect Robots play a lockbox: their loop and ours say the same."""

import importlib.util
import json
import math
from pathlib import Path

import numpy as np
import pytest

import lockprobe
from lockprobe.boxes.solve import random_success
from lockprobe.testing import ScriptedProvider

inspect_robots = pytest.importorskip("inspect_robots")

from inspect_robots.conformance import assert_embodiment_conformant  # noqa: E402
from inspect_robots.rollout import derive_seed  # noqa: E402

PATH = Path(__file__).parents[3] / "examples" / "inspect_robots_lockbox.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("inspect_robots_lockbox", PATH)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def played(example, tmp_path_factory):
    """The baseline under true reports, under false ones, and with hands that tremble."""

    def one(condition):
        body = example.LockboxEmbodiment(condition)
        return example.evaluate(example.RandomJoints(), body, 150, str(tmp_path_factory.mktemp("logs"))), body.trials

    return {condition: one(condition) for condition in ("", "flip?p=0.4", "tremble?p=1")}


class Listed(inspect_robots.PolicyBase):
    """Attempts joints by a list, and keeps what it was shown."""

    def __init__(self, joints):
        self.joints, self.seen = joints, []

    def bind(self, embodiment_info):
        self.info = inspect_robots.PolicyInfo(name="listed", action_space=embodiment_info.action_space)

    def act(self, observation):
        self.seen.append(observation)
        targets = np.array(observation.state["joint_pos"])
        joint = self.joints[len(self.seen) - 1]
        targets[joint] = 1 - targets[joint] if targets[joint] != 0.5 else 1.0
        return inspect_robots.ActionChunk(actions=[inspect_robots.Action(data=targets)])


def positions(state):
    return [float(bit) for bit in state]


def test_the_embodiment_conforms(example):
    assert_embodiment_conformant(example.LockboxEmbodiment(box="fork").info)


def test_the_baseline_is_solved_as_often_as_chance_says_and_false_reports_change_nothing_of_it(played):
    log, trials = played[""]
    chance = random_success(lockprobe.box("chain-4"))
    assert abs(log.results.metrics["success_at_end"] - chance) < 4 * math.sqrt(chance * (1 - chance) / 150)
    _, told_falsely = played["flip?p=0.4"]
    assert [trial.actions for trial in told_falsely] == [trial.actions for trial in trials]
    steps = [step for trial in told_falsely for step in trial.steps]
    assert 0.35 < sum(step.told_falsely for step in steps) / len(steps) < 0.45


def test_both_records_agree_on_who_solved_the_box(played):
    for log, trials in played.values():
        theirs = [scene.epochs[0]["success_at_end"] for scene in log.samples]
        assert theirs == [float(trial.solved) for trial in trials]


def test_interventions_on_what_is_done_act_in_their_loop(played):
    (_, steady), (_, trembling) = played[""], played["tremble?p=1"]
    assert all(step.chosen is None for trial in steady for step in trial.steps)
    assert all(step.chosen not in {None, step.joint} for trial in trembling for step in trial.steps)


def test_a_policy_is_shown_what_a_study_would_tell_and_never_the_truth(example, tmp_path):
    body, policy = example.LockboxEmbodiment("flip?p=0.5"), Listed([3, 2, 3, 1, 0, 2] * 4)
    example.evaluate(policy, body, 1, str(tmp_path))
    (trial,) = body.trials
    study = lockprobe.study(agent="random", p=[0.5], trials=1, repetitions=1, seed=derive_seed(0, 0, 0))
    labels = dict(zip(trial.joints, trial.labels, strict=True))
    script = lockprobe.testing.ScriptedAgent(joints=tuple(trial.listing.index(labels[one]) for one in trial.actions))
    same = lockprobe.run_trial(agent=script, p=0.5, seed=study.seed)
    assert same.actions == trial.actions
    assert [step.told_state for step in same.steps] == [step.told_state for step in trial.steps]
    order = [trial.labels.index(label) for label in trial.listing]
    for shown, step in zip(policy.seen[1:], trial.steps, strict=False):
        assert {*shown.state} == {"joint_pos", "target"}
        assert list(shown.state["joint_pos"]) == [positions(step.told_state)[i] for i in order]
    assert any(step.told_falsely for step in trial.steps)
    assert shown.state["target"] == trial.listing.index(labels[trial.target]) + 1


def test_a_report_that_is_withheld_is_no_position(example, tmp_path):
    body, policy = example.LockboxEmbodiment("drop?p=1"), Listed([0, 1, 2, 3] * 5)
    example.evaluate(policy, body, 1, str(tmp_path))
    assert {float(one) for shown in policy.seen[1:] for one in shown.state["joint_pos"]} == {0.5}
    assert len(body.trials[0].steps) == len(policy.seen)


def test_what_acts_on_words_is_refused_in_one_line(example):
    with pytest.raises(
        lockprobe.UserMistake, match=r"condition: got 'nudge', expected interventions on reports or actions"
    ):
        example.LockboxEmbodiment("nudge")


def test_their_language_model_agent_opens_the_box_with_one_call_per_attempt(example, tmp_path, monkeypatch):
    pytest.importorskip("inspect_robots_agent")
    monkeypatch.setenv("SCRIPTED_KEY", "nobody-asks-for-one")
    body, plan = example.LockboxEmbodiment(), []

    def reply(request):
        if not plan:  # it is asked for the first time when the first trial has begun
            episode = body._env.unwrapped._episode
            plan.extend(episode._listing.index(joint) + 1 for joint in (3, 2, 1, 0))
        joint = plan[len(provider.requests) - 1]
        call = {"targets": {f"joint_{joint}": 1}, "note": "the next one"}
        function = {"name": "move_joints", "arguments": json.dumps(call)}
        message = {
            "role": "assistant",
            "content": "",
            "tool_calls": [{"id": "1", "type": "function", "function": function}],
        }
        return 200, {"choices": [{"index": 0, "message": message, "finish_reason": "tool_calls"}]}

    with ScriptedProvider(reply) as provider:
        agent = inspect_robots.resolve(
            "policy", "agent", model="m", base_url=provider.url, api_key_env="SCRIPTED_KEY", wire_capture=False
        )
        log = example.evaluate(agent, body, 1, str(tmp_path))
        agent._client.close()  # the policy has no close()
    assert log.results.metrics == {"success_at_end": 1.0}
    assert body.trials[0].actions == ("revolute-right", "slider-2", "slider-1", "revolute-left")
    assert len(provider.requests) == 4
    said = json.dumps(provider.requests[0]["messages"])
    assert "There are 20 attempts." in said
    assert "joint_4" in said


def test_the_program_prints_chance_next_to_what_was_played(example, capsys, monkeypatch):
    monkeypatch.setattr("sys.argv", ["x", "--trials", "3"])
    example.main()
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["truth", "flip?p=0.4", "chance"]
    assert "success 0.39 (exact, random joints)" in lines[-1]

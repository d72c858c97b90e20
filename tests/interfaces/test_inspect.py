"""A trial inside an eval of Inspect AI is the trial that our own loop plays; an error is no failure to solve."""

import gc
import json
from importlib.metadata import entry_points
from typing import ClassVar

import pytest

from lockprobe import run_trial
from lockprobe.foundation.errors import UserMistake
from lockprobe.interfaces.episodes.reading import read_episodes
from lockprobe.trial.record import Decision
from lockprobe.trial.trial_json import trial_from_json

pytestmark = pytest.mark.filterwarnings("ignore:(?i)unclosed:ResourceWarning")  # inspect-ai leaves streams open

SMALL = {"p": 0.4, "trials": 1, "repetitions": 1, "max_steps": 6}


@pytest.fixture(scope="module")
def tasks():
    """Takes seconds to import, of the worker alone that plays here."""
    return pytest.importorskip("lockprobe.interfaces.inspect")


def evaluated(tmp_path, task, reply, **options):
    from inspect_ai import eval as inspect_eval
    from inspect_ai.model import ModelOutput, ModelUsage, get_model

    def output(messages, *more):
        made = ModelOutput.from_content("mockllm", reply(messages))
        made.usage = ModelUsage(total_tokens=1)  # else they are counted with a file from the network
        return made

    model = get_model("mockllm/model", custom_outputs=output, memoize=False)
    quiet = {"display": "none", "log_realtime": False, "ctl_server": False, "log_dir": str(tmp_path)}
    (log,) = inspect_eval(task, model=model, **{**quiet, **options})
    gc.collect()  # what is left open is found in the test that left it
    return log


def stubborn(messages):
    """The first joint, whatever is told."""
    last = {} if len(messages) == 1 else {"last_action": "moved"}
    return json.dumps({"last_action": "none", **last, "hypothesis": "", "joint": "A"})


class Stubborn:
    facts: ClassVar = {}

    async def decide(self, situation, rng):
        return Decision(joint="A", claimed="moved" if situation.past else None)


def test_inspect_finds_a_task_for_every_study(tasks):
    (found,) = (entry for entry in entry_points(group="inspect_ai") if entry.name == "lockprobe")
    assert found.load() is tasks
    names = (None, "modalities", "why")
    assert all(len(tasks.study(study=name, trials=1, repetitions=1).dataset) >= 3 for name in names)


def test_a_trial_has_the_luck_of_every_other_agent(tmp_path, tasks):
    log = evaluated(tmp_path, tasks.study(**SMALL), stubborn, epochs=2)
    assert log.status == "success"
    for sample in log.samples:
        (score,) = sample.scores.values()
        trial = trial_from_json(score.metadata["trial"])
        number = {"repetition": sample.epoch, "trial": sample.metadata["trial"]}
        p = 0.4 if "p=0.4" in sample.id else 0.0
        here = run_trial(agent=Stubborn(), p=p, max_steps=6, seed=trial.seed, **number)
        assert (trial.labels, trial.actions, [step.told for step in trial.steps]) == (
            here.labels, here.actions, [step.told for step in here.steps],
        )  # fmt: skip
        assert score.value == {"solved": int(here.solved), "steps": len(here.steps) if here.solved else 6, "loops": 1}
        assert [message.role for message in sample.messages] == ["user", "assistant"] * len(trial.steps)


def test_a_reply_that_stays_unusable_is_unscored_and_what_breaks_a_model_is_the_error_of_its_sample(tmp_path, tasks):
    def breaks(messages):
        raise ConnectionError("gone")

    for sample in evaluated(tmp_path, tasks.study(**SMALL), lambda messages: "?").samples:
        (score,) = sample.scores.values()
        assert (score.reason, trial_from_json(score.metadata["trial"]).ending) == ("reply", "error")
    log = evaluated(tmp_path, tasks.study(**SMALL), breaks)
    assert all("gone" in sample.error.message and not sample.scores for sample in log.samples)


@pytest.mark.parametrize(
    ("given", "said"), [({"p": "0,x"}, "0,x"), ({"until": "decided"}, "until"), ({"smell": 1}, "smell")]
)
def test_a_mistake_is_said_before_the_first_call(tasks, given, said):
    with pytest.raises(UserMistake, match=said):
        tasks.study(**given)


def test_logs_are_read_as_episodes_and_an_error_is_no_failure(tmp_path, tasks):
    from inspect_ai import Task
    from inspect_ai.dataset import Sample
    from inspect_ai.scorer import includes

    samples = [Sample(id=f"s{i}", input=f"s{i}", target=str(i)) for i in range(3)]
    task = Task(dataset=samples, scorer=includes(), name="quiz", fail_on_error=False)
    evaluated(tmp_path, task, lambda messages: f"{1 // (messages[-1].text != 's2')}", epochs=2)
    found = read_episodes(sorted(tmp_path.glob("*.eval")), "inspect")
    assert (found.agents, found.conditions) == (["mockllm/model"], ["quiz"])
    ended = sorted((found.tasks[i], str(end)) for i, end in zip(found.task, found.solved, strict=True))
    assert ended == [("s0", "0.0"), ("s0", "0.0"), ("s1", "1.0"), ("s1", "1.0"), ("s2", "nan"), ("s2", "nan")]

"""Plans, and the names by which joints go in a trial."""

from dataclasses import replace

import pytest
from seen import PhotographedPlant

from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.trial.plan import Fork, Names, Plan
from lockprobe.trial.trial_name import ForkName

PLAN = Plan(
    study="test", agent="fake", box=box("chain-5"), condition=flips((0.0,), modalities=("rgb",))[0],
    repetition=1, trial=3, seed=1,
)  # fmt: skip


def test_names_agree_with_each_other():
    names = Names(PLAN)
    task = names.task(PLAN)
    assert sorted(names.order) == list(range(5))
    assert names.order != tuple(range(5))
    assert task.joints == names.listing == tuple(names.labels[i] for i in names.order)
    assert [names.index(label) for label in task.joints] == list(names.order)
    assert task.target == names.labels[PLAN.box.target_index]
    assert task.places == tuple(PLAN.box.joints[i].place for i in names.order)


def test_what_is_seen_has_its_handles_in_the_order_of_the_listing():
    names = Names(PLAN)
    percept = names.percept(PhotographedPlant(PLAN.box).attempt(2))
    frame = percept.look()
    assert [int(x) for x in frame.handles[:, 0, 0]] == list(names.order)
    assert percept.joint == names.labels[2]
    assert names.percept(PhotographedPlant(PLAN.box).observe()).joint is None


def test_without_shuffling_labels_run_along_the_panel():
    names = Names(replace(PLAN, shuffle="never"))
    assert names.labels == names.listing == tuple("ABCDE")
    assert names.told_state(names.percept(PhotographedPlant(PLAN.box).observe()).positions) == "00000"


@pytest.mark.parametrize(
    ("agent", "name", "key"),
    [
        ("fake", "", "test/fake/rgb/rep=1/trial=3"),
        ("llm:a/b?host=http://c", "d/e", "test/llm:a%2Fb?host=http:%2F%2Fc/d%2Fe/rep=1/trial=3"),
        ("participant:3f9a01bc", "x", "test/participant/x/rep=1/trial=3"),
    ],
)
def test_a_key_has_five_parts_whatever_is_called_how(agent, name, key):
    assert replace(PLAN, agent=agent, condition=replace(PLAN.condition, name=name)).key == key


def test_the_key_of_a_fork_is_that_of_its_parent_and_what_was_changed():
    name = ForkName(parent=PLAN.key, at=2, arm="lie", truthful=True, time=3)
    fork = Fork(name=name, condition=PLAN.label, acting=(), recorded=())
    forked = replace(PLAN, fork=fork, condition=replace(PLAN.condition, name="fork: lie"))
    assert forked.key == "test/fake/rgb/rep=1/trial=3/at=2/lie/then=truth/time=3"
    assert (forked.name, forked.label) == (PLAN.name, PLAN.label)

"""Plans, and the names by which joints go in a trial."""

from dataclasses import replace

from seen import PhotographedPlant

from lockprobe.interventions.condition import flips
from lockprobe.lockbox.families import box
from lockprobe.plan import Names, Plan

PLAN = Plan(
    key="test", study="test", agent="fake", box=box("chain-5"), condition=flips((0.0,), modalities=("rgb",))[0],
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
    names = Names(replace(PLAN, shuffle=False))
    assert names.labels == names.listing == tuple("ABCDE")
    assert names.told_state(names.percept(PhotographedPlant(PLAN.box).observe()).positions) == "00000"

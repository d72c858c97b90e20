"""A scene holds what is told and nothing else, and an act is what can be done and nothing else."""

import asyncio
import json
from dataclasses import replace

import pytest
from pydantic import TypeAdapter, ValidationError
from seated import opened, people_study, short, to_first

from lockprobe.boxes.families import box
from lockprobe.people.responses import Act, Attempt
from lockprobe.people.scenes import Box
from lockprobe.studies.records.read_records import load
from lockprobe.trial.plan import Names


def everything_sent(directory, study, joints) -> list[str]:
    """All that a page is sent while somebody attempts these joints, by their place in the listing."""

    async def heard() -> list[str]:
        async with opened(directory, study, short()) as reception:
            shown = await to_first(Box, reception, await reception.enter(None, {}))
            sent = [shown]
            for joint in joints:
                panel, asked = shown.scene.panel, shown.scene.ask
                act = Attempt(joint=panel.joints[joint].label, claimed="moved" if asked else None, rt=1.0)
                sent.append(shown := await reception.act(shown.token, shown.lease, shown.turn, act, {}))
            return [json.dumps([one.turn, one.scene.model_dump(mode="json")]) for one in sent]

    return asyncio.run(heard())


def test_the_page_is_sent_nothing_but_what_is_told(tmp_path):
    """Every joint is free and all reports are true, or nothing can move and all are false: the same is told and sent."""
    chain = box("chain-4")
    free = replace(chain, name="any", interlock={})
    around = dict(zip(chain.names, (*chain.names[1:], chain.names[0]), strict=True))
    stuck = replace(chain, name="any", interlock={one: ({other: True},) for one, other in around.items()})
    settings = {"flip": "integrated", "trials": 2, "max_steps": 3}
    true = people_study(box=free, p=(0.0,), name="free", **settings)
    false = people_study(box=stuck, p=(1.0,), name="stuck", **settings)
    labels = Names(plan := true.plan("participant", true.conditions[0], 1, 1)).listing
    target = Names(plan).task(plan).target
    others = [place for place, label in enumerate(labels) if label != target]
    sent = [everything_sent(tmp_path / study.name, study, others) for study in (true, false)]
    assert len(sent[0]) == 4
    assert sent[0] == sent[1]
    assert [step.moved for step in load(tmp_path / "free")[0].steps] == [True] * 3
    assert [step.moved for step in load(tmp_path / "stuck")[0].steps] == [False] * 3


def test_no_scene_names_a_joint_a_box_or_a_trial_as_only_the_study_does(tmp_path):
    study = people_study(p=(0.4,), trials=1)
    sent = " ".join(everything_sent(tmp_path, study, [0, 1, 2]))
    assert not [name for name in (*study.box.names, study.box.name, "0.4", "flips", "seed") if name in sent]


ATTEMPT = {"kind": "attempt", "joint": "A", "rt": 1.5}


@pytest.mark.parametrize(
    "act",
    [
        {}, [], "next", {"kind": "open"}, {"kind": "next", "rt": 1.0}, {"kind": "agree", "agreed": 1},
        {"kind": "answer", "answer": "a" * 10_001, "rt": 1.0}, {"kind": "answer", "answer": "\ud800", "rt": 1.0},
        {"kind": "attempt", "joint": "A"}, ATTEMPT | {"joint": ""}, ATTEMPT | {"joint": "A" * 9},
        ATTEMPT | {"joint": 1}, ATTEMPT | {"rt": -1.0}, ATTEMPT | {"rt": 1e10}, ATTEMPT | {"rt": "1"},
        ATTEMPT | {"claimed": "opened"}, ATTEMPT | {"moved": True}, ATTEMPT | {"box": 2},
    ],
)  # fmt: skip
def test_what_is_no_act_is_none(act):
    adapter = TypeAdapter(Act)
    assert adapter.validate_json(json.dumps(ATTEMPT)) == Attempt(joint="A", rt=1.5)
    for text in (json.dumps(act), json.dumps(act).replace("1.0", "NaN") + " "):
        with pytest.raises(ValidationError):
            adapter.validate_json(text)

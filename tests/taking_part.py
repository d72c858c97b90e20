"""People for tests: strategies decide in their place, and a diary is written as the server writes it."""

import asyncio
from dataclasses import replace
from itertools import count

from lockprobe.agents.catalogue import resolve
from lockprobe.people.diary import Answers, Attempt, Diary, Did, Joined, Slot, write_entry
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.trial_setup import play_timed

READ = Answers(answers=(), rt=700.0)

START = 1_790_000_000.25
"""When the first participant joins, seconds since 1970."""


def take_part(
    directory,
    study,
    identity,
    slots,
    *,
    left_after=None,
    check=True,
    answers=None,
    platform=None,
    joined=START,
    shown=None,
):
    """Somebody takes part in a study that is on disk; the trials.

    Args:
        slots: Flip probability, repetition and trial of each box.
        left_after: After how many steps of the last box the person leaves for good; None for not at all.
        check: Whether the attention check after the boxes is answered rightly.
        answers: Answers to questions, by name.
        platform: What the recruitment platform said.
        joined: When, seconds since 1970.
        shown: The modality; the first of the study if not given.
    """
    label = {one.p: one.label for one in study.conditions if one.modality == (shown or study.modalities[0])}
    places = tuple(Slot(condition=label[p], repetition=r, trial=t) for p, r, t in slots)
    finished, turns, words = [], count(2), "en 3f9a01bc22d1"  # to agree is the first
    with Journal.open(directory, study) as journal:
        known = {"token": "f" * 64, "at": joined, "platform": platform or {}, "slots": places, "words": words}
        diary = Diary(Joined(identity=identity, **known), [])
        write_entry(journal.store, identity, 1, diary.joined)

        def did(scene, act, **more):
            turn = next(turns)
            line = Did(at=joined + 1.5 * turn, turn=turn, scene=scene, act=act, **more)
            write_entry(journal.store, identity, turn, line)

        did("page", READ, item="1")
        did("box", Attempt(joint="A", rt=900.5), box=0, step=1, told="A moved.", ended="solved")
        did("over", READ, box=0)
        for box, _ in enumerate(places, 1):
            trial, _ = asyncio.run(play_timed(diary.plan(study, box), resolve("human-inspired").make()))
            facts = {"view": "panel", "words": words, "page": "1", "position": box, "design": "within"}
            trial, leaves = replace(trial, facts=facts), left_after if box == len(places) else None
            for step in trial.steps[:leaves]:
                said = step.decision
                claimed_rt = None if said.claimed is None else 300.25
                act = Attempt(joint=said.joint, claimed=said.claimed, rt=1000.5 + step.step, claimed_rt=claimed_rt)
                ended = trial.ending if step is trial.steps[-1] else None
                did("box", act, box=box, step=step.step, told=step.told, ended=ended)
            if leaves is None:
                journal.append(trial, 1.5)
                finished.append(trial)
                did("over", READ, box=box)
        if left_after is None:
            did("check", Answers(answers=("blue" if check else "red",), rt=2000.0), item="1", right=check)
            for name, answer in (answers or {}).items():
                did("ask", Answers(answers=(answer,), rt=5000.0), item=name)
    return finished

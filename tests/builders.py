"""Makes trials for tests: by hand, step by step, or by playing strategies."""

import asyncio
from collections import deque
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.box import bits
from lockprobe.boxes.families import box
from lockprobe.foundation.errors import Boundary
from lockprobe.foundation.spec import group_of
from lockprobe.interventions.conditions import flips
from lockprobe.interventions.flip import FlipKind
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import STATES, Decision, Fact, Outcome, Step, Trial, TrialError, TrialName

SOLUTION = (3, 2, 1, 0)
"""Joints of chain-4 by place, in the order that solves it."""


def make_trial(
    joints: Sequence[int],
    *,
    agent: str = "random",
    p: float = 0.0,
    repetition: int = 1,
    trial: int = 1,
    budget: int = 20,
    false_at: Iterable[int] = (),
    claims: Sequence[Outcome | None] = (),
    hypothesis: str = "",
    broken: Boundary | None = None,
    facts: dict[str, str] | None = None,
    modality: str | None = None,
    study: str = "flips",
    verdicts: Sequence[str] = (),
    readings: Sequence[str] = (),
    pictures: Sequence[dict[str, str]] = (),
) -> Trial:
    """A trial on chain-4 that attempts these joints (by place in panel order), as the box really reacts.

    Args:
        false_at: Steps, from 1, of which the report is inverted.
        claims: What each decision says of the step before; the first is about nothing.
        broken: Boundary at which it broke after these steps, if it did.
        modality: How the box was shown, as in a study of flips if not given; the name of a study that has several is
            ``modalities``.
        verdicts: What a robot took each step for.
        readings: What a camera read before the first step and after each.
        pictures: Names of the pictures before the first step and after each, by kind.
    """
    lockbox = box("chain-4")
    configuration, steps, solved = lockbox.initial, [], False
    for i, joint in enumerate(joints):
        before = configuration
        configuration, moved = lockbox.attempt(before, joint)
        decision = Decision(joint="ABCD"[joint], claimed=claims[i] if i < len(claims) else None, hypothesis=hypothesis)
        steps.append(
            Step(
                step=i + 1,
                state=bits(before),
                joint=lockbox.names[joint],
                moved=moved,
                told_moved=moved != (i + 1 in set(false_at)),
                told_state=None,
                told="",
                decision=decision,
                sensed=({"verdict": verdicts[i]} if i < len(verdicts) else {})
                | ({"camera": readings[i + 1]} if i + 1 < len(readings) else {}),
                pictures=pictures[i + 1] if i + 1 < len(pictures) else {},
            )
        )
        solved = moved and joint == lockbox.target_index
        if solved:
            break
    shown = modality or ("symbolic" if study == "modalities" else STATES)
    error = TrialError(boundary=broken, message="it broke", step=len(steps) + 1) if broken else None
    (condition,) = flips((p,), modalities=(shown,))
    place = {"condition": condition.label, "repetition": repetition, "trial": trial}
    return Trial(
        key=str(TrialName(study=study, agent=group_of(agent), **place)),
        study=study,
        agent=agent,
        facts=facts or {},
        box="chain-4",
        condition=condition.label,
        specs=condition.specs,
        doses=condition.doses,
        modality=shown,
        channels=(),
        repetition=repetition,
        trial=trial,
        seed=1,
        budget=budget,
        joints=lockbox.names,
        labels=tuple("ABCD"),
        listing=tuple("ABCD"),
        target=lockbox.target,
        opening="",
        steps=tuple(steps),
        ending="error" if broken else "solved" if solved else "budget",
        error=error,
        opening_pictures=pictures[0] if pictures else {},
        opening_sensed={"camera": readings[0]} if readings else {},
    )


def call_of(trial: Trial | Plan, step: int = 1, reply: str | None = "said", **more: Any) -> Call:
    """A call of a trial, as the log of calls holds it."""
    asked = {"turn": 1, "request": "r"} | more
    return Call(key=trial.key, agent=trial.agent, step=step, reply=reply, **asked)


def study_of(p: Sequence[float] = (0.0, 0.4), flip: FlipKind = "re-observed", **settings: Any) -> Study:
    """A study of flip rates, shown as ``modalities`` say, of chain-4 if of no other boxes."""
    usual = {"boxes": (box("chain-4"),), "conditions": flips(p, flip, settings.pop("modalities", None))}
    return Study(**usual | settings)


def modality_study(
    agents: Sequence[str] = ("viewer", "human-inspired"),
    modalities: Sequence[str] = ("rgb", "rgbd", "symbolic"),
    trials: int = 10,
    plant: str = "fast-twin",
    **settings: Any,
) -> Study:
    """A modality study on chain-4, at p = 0 and one repetition."""
    shown = {"modalities": modalities, "repetitions": 1, "trials": trials, "plant": plant}
    return study_of((0.0,), name="modalities", agents=tuple(agents), **shown, **settings)


def small_study(
    agents: Sequence[str] = ("random", "human-inspired"),
    p: Sequence[float] = (0.0, 0.3, 0.6),
    repetitions: int = 2,
    trials: int = 4,
) -> Study:
    """A flip study of strategies on chain-4."""
    return study_of(p, name="flips", agents=tuple(agents), repetitions=repetitions, trials=trials)


def play_study(study: Study) -> list[Trial]:
    """All trials of a study, really played."""
    return [trial for trial, _ in _played(study)]


def write_study(directory: Path, study: Study, trials: Iterable[Trial] | None = None) -> Path:
    """A study directory with these trials, or with all of the study, really played."""
    played = _played(study) if trials is None else [(t, 1.0) for t in trials]
    with Journal.open(directory, study) as journal:
        for trial, seconds in played:
            journal.append(trial, seconds)
    return directory


def _played(study: Study) -> list[tuple[Trial, float]]:
    async def play_all() -> list[tuple[Trial, float]]:
        return [await play_timed(plan, resolve(agent).make()) for agent in study.agents for plan in study.plans(agent)]

    return asyncio.run(play_all())


def played_by_people(study: Study, boxes_each: int = 4, **facts: Fact) -> list[Trial]:
    """All trials of people in a study, played by a strategy in their place.

    Everybody has so many boxes, at most one at each p, and meets no luck twice. With facts as the page writes them.
    """
    lucks = [(r, t) for r in range(1, study.repetitions + 1) for t in range(1, study.trials + 1)]
    slots = []
    for row in range(len(lucks)):
        conditions = deque(enumerate(study.p))
        conditions.rotate(row)  # which p comes first is balanced
        for i, (at, p) in enumerate(conditions):
            identity, position = f"{row:04d}{i // boxes_each:02d}", 1 + i % boxes_each
            slots.append((identity, position, p, lucks[(row + at) % len(lucks)]))

    under, agent, found = {one.p: one for one in study.conditions}, resolve("human-inspired").make(), []
    for identity, position, p, luck in slots:
        trial, _ = asyncio.run(play_timed(study.plan(f"participant:{identity}", under[p], *luck), agent))
        seen = {"view": "panel", "history": True, "feedback": False, "design": "within", "position": position}
        found.append(replace(trial, facts=seen | facts))
    return found

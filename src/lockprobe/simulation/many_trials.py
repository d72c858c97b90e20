"""Trials of strategies with their records, many at once on the kernel.

A record is that of the loop (:mod:`lockprobe.trial.loop`), byte by byte, in a fraction of the time.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from lockprobe.agents.policy import Policy
from lockprobe.boxes.box import bits
from lockprobe.boxes.solve import space_of
from lockprobe.interventions.modality import interventions_for, places_in, shown
from lockprobe.interventions.words import TextChannel
from lockprobe.simulation.kernel import Minds, World, flip_alone, played
from lockprobe.trial.loop import record_of
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import Agent
from lockprobe.trial.record import Decision, Outcome, Snapshot, Step, Trial, facts_of


def minds_of(agent: Agent, plan: Plan) -> Minds | None:
    """What :func:`play_many` plays all trials of an agent under a plan's condition and on its box with.

    None for trials that only the loop plays: of agents of other packages, of others than policies, of forks, and where
    anything but a flip acts on words.
    """
    channel, flip = shown(plan.modality), flip_alone(interventions_for(plan.condition), plan.plant)
    ours = type(agent).__module__.startswith("lockprobe.agents.")
    if not (ours and isinstance(agent, Policy) and isinstance(channel, TextChannel)) or flip is None or plan.fork:
        return None
    world = World(box=plan.box, space=space_of(plan.box), flip=flip, budget=plan.budget, tell=channel.tell)
    return Minds(agent, world)


def play_many(plans: Sequence[Plan], minds: Minds) -> list[Trial]:
    """Play trials that differ in nothing but repetition and trial; what is equal in their records is one object."""
    world, channel, named = minds.world, shown(plans[0].modality), [plan.names for plan in plans]
    assert isinstance(channel, TextChannel)
    places, facts = places_in(plans[0].condition), facts_of(minds.policy.facts)
    joints, orders = np.arange(world.space.joints), np.array([names.order for names in named])
    positions = [tuple((at >> joints & 1).astype(bool).tolist()) for at in range(1 << len(joints))]
    states, first_look = [*map(bits, positions)], Snapshot(configuration=world.box.initial)
    state, steps, decisions = [world.space.start] * len(plans), [list[Step]() for _ in plans], dict[Any, Decision]()
    before: list[tuple[int, int, bool, int] | None] = [None] * len(plans)  # the last report, and the mind that got it
    changed, falsely, solved = np.zeros((3, len(plans)), int)
    repetitions, numbers = np.array([(plan.repetition, plan.trial) for plan in plans]).T
    for number, many in enumerate(played(minds, orders, plans[0].seed, repetitions, numbers), 1):
        changed[many.rows] += falsely[many.rows]  # a report counts for the step that follows it
        falsely[many.rows], solved[many.rows] = many.falsely, many.done
        panels = ((many.told[:, None] >> joints & 1) << orders[many.rows]).sum(axis=1)
        columns = (many.rows, many.minds, many.places, many.joints, many.moved, many.said, many.told, many.away, panels)
        alone = zip(*(column.tolist() for column in columns), strict=True)
        for row, mind, place, joint, moved, said, told, away, panel in alone:
            task, last = named[row].task, before[row]
            label = task.joints[place]
            if (decision := decisions.get((mind, label, last))) is None:
                decision = decisions[mind, label, last] = Decision(
                    joint=label,
                    claimed=minds.claim(*last) if last and task.assessment else None,
                    probabilities=tuple(minds.chances(np.array([mind]))[0].tolist()) if minds.policy.exact else None,
                )
            outcome: Outcome | None = None if world.states_only else "moved" if said else "blocked"
            where = None if world.tell == "outcome" else positions[told]
            steps[row].append(
                Step.of(
                    step=number,
                    state=states[state[row]],
                    joint=world.box.joints[joint].name,
                    moved=moved,
                    told_moved=said,
                    told_state=None if where is None else states[panel],
                    told=channel.written(label, outcome, where, task, first=False),
                    decision=decision,
                    sensed={},
                    pictures={},
                    chosen=None,
                    remark="",
                )
            )
            before[row] = mind, place, said, away
            state[row] ^= moved << joint
    return [
        record_of(
            plan,
            "solved" if solved[row] else "budget",
            None,
            tuple(steps[row]),
            facts=facts,
            channels=places.channel_facts,
            interventions=places.other_facts,
            opening=channel.perceive(plan.names.percept(first_look), (), plan.names.task, plan.luck.generator).text,
            changed={spec: int(changed[row]) for spec in places.specs if spec},
            changed_steps=int(changed[row]),
        )
        for row, plan in enumerate(plans)
    ]

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
from lockprobe.interventions.modality import interventions_for, shown
from lockprobe.interventions.words import TextChannel
from lockprobe.simulation.kernel import Minds, World, courses, flip_alone
from lockprobe.trial.loop import record_of
from lockprobe.trial.places import Places
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
    policy, world, facts = minds.policy, minds.world, facts_of(minds.policy.facts)
    box, tell, channel = world.box, world.tell, shown(plans[0].modality)
    places = Places(interventions_for(plans[0].condition))
    assert isinstance(channel, TextChannel)
    orders = np.array([plan.names.order for plan in plans])
    repetitions, numbers = np.array([(plan.repetition, plan.trial) for plan in plans]).T
    found = courses(minds, orders, plans[0].seed, repetitions, numbers)
    changed = found.falsely.sum(axis=1) - found.falsely[np.arange(len(plans)), found.steps - 1]  # nobody reads the last
    joints = np.arange(world.space.joints)
    positions = [tuple((at >> joints & 1).astype(bool).tolist()) for at in range(1 << len(joints))]
    states = [*map(bits, positions)]
    starts = (world.space.start >> orders & 1) @ (1 << joints)
    on_panel = ((found.told[..., None] >> joints & 1) << orders[:, None]).sum(axis=-1)
    columns = (found.actions, found.moved, found.told_moved, found.minds, found.told, on_panel)
    decisions, trials, first_look = dict[Any, Decision](), list[Trial](), Snapshot(configuration=box.initial)
    for row, plan in enumerate(plans):
        names, task, start, state, before = plan.names, plan.names.task, int(starts[row]), world.space.start, None
        steps, played = list[Step](), (column[row, : found.steps[row]].tolist() for column in columns)
        for number, (joint, moved, said, mind, told, panel) in enumerate(zip(*played, strict=True), 1):
            label = names.labels[joint]
            if (decision := decisions.get(about := (mind, label, before))) is None:
                decision = decisions[about] = Decision(
                    joint=label,
                    claimed=minds.claim(*before) if before and task.assessment else None,
                    probabilities=tuple(minds.chances(np.array([mind]))[0].tolist()) if policy.exact else None,
                )
            outcome: Outcome | None = None if tell == "state" else "moved" if said else "blocked"
            where = None if tell == "outcome" else positions[told]
            steps.append(
                Step.of(
                    step=number,
                    state=states[state],
                    joint=box.joints[joint].name,
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
            before = mind, task.joints.index(label), said, told ^ start
            state ^= moved << joint
        trials.append(
            record_of(
                plan,
                "solved" if found.solved[row] else "budget",
                None,
                tuple(steps),
                facts=facts,
                channels=places.channel_facts,
                interventions=places.other_facts,
                opening=channel.perceive(names.percept(first_look), (), task, plan.luck.generator).text,
                changed={spec: int(changed[row]) for spec in places.specs if spec},
                changed_steps=int(changed[row]),
            )
        )
    return trials

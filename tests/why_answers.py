"""Answers of a study of controls, made by hand."""

from dataclasses import fields

from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.proportions import proportion
from lockprobe.analysis.why import ArmEffect, Why


def mean(value, half=0.05):
    found = abs(value) > half
    return BlockMean(
        value=value, low=value - half, high=value + half, p_value=0.001 if found else 0.6, pairs=150, blocks=150
    )


def answer(says, disturbs, *, equivalence=0.5, half=0.05, others=(), agents=1):
    arms = {"truth": 30, "lie": 30 + round(150 * (says + disturbs)), "retracted": 30 + round(150 * disturbs)}
    return Why(
        agent="cognitive:insistent",
        modality="symbolic?tell=state",
        p=0.4,
        arms=(
            *(ArmEffect(arm=arm, condition=arm, success=proportion(n, 150)) for arm, n in arms.items()),
            *(ArmEffect(arm=arm, condition=arm, success=proportion(60, 150), change=mean(0.2)) for arm in others),
        ),
        change=mean(says + disturbs, half),
        says=mean(says, half),
        disturbs=mean(disturbs, half),
        falsity=None,
        disturbance=None,
        interaction=None,
        equivalence=equivalence,
        needed=230,
        agents=agents,
    )


def with_arms(found, arms):
    """The same answer with other arms."""
    return Why(**{part.name: getattr(found, part.name) for part in fields(found) if part.init} | {"arms": arms})

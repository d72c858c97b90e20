"""Arms and answers of a study of controls, made by hand."""

from lockprobe.foundation.spec import Spec
from lockprobe.interventions.conditions import read_condition
from lockprobe.statistics.agent_comparison.paired import BlockMean
from lockprobe.statistics.conditions.series import SeriesArm
from lockprobe.statistics.proportions import proportion
from lockprobe.statistics.why.arms import ARMS, ON_REQUEST, PARTS
from lockprobe.statistics.why.contrasts import ArmEffect, Why
from lockprobe.statistics.why.mechanism import CONTRASTS, Decision

TRUTH = {"truth": 30, "truth-truth": 30, "lie-truth": 30, "truth-lie": 30, "lie-lie": 30, "remark": 30}


def mean(value, half=0.05):
    found = abs(value) > half
    return BlockMean(
        value=value, low=value - half, high=value + half, p_value=0.001 if found else 0.6, pairs=150, blocks=150
    )


def answer(verdict, *claims, lie=60, equivalence=0.5, others=(), agents=1):
    """The answer with this verdict and these claims; others are arms with which success is 20 points higher."""
    counts = TRUTH | {"lie": lie}
    detected = verdict not in ("no change", "inconclusive")
    way = 1 if lie > 30 else -1
    form = {} if verdict in ("form", "both", "blurred") else {"true correction": mean(0.0), "remark": mean(0.0)}
    return Why(
        agent="cognitive:insistent",
        modality="symbolic?tell=state",
        p=0.4,
        arms=(
            *(ArmEffect(arm=arm, condition=arm, success=proportion(n, 150)) for arm, n in counts.items()),
            *(ArmEffect(arm=arm, condition=arm, success=proportion(60, 150), change=mean(0.2)) for arm in others),
        ),
        decision=Decision(
            total=mean((lie - 30) / 150),
            contrasts={name: mean(way * 0.2) for name in CONTRASTS} | form if detected else {},
            claims=claims,
            equivalence=equivalence,
            verdict=verdict,
        ),
        needed=230,
        agents=agents,
    )


def as_arms(arms=ARMS, p=0.4, reading=""):
    """These arms at a rate, as an analysis sees them."""
    every = {**ARMS, **PARTS, **ON_REQUEST}
    found = [read_condition(every[arm].format(p=p, reading=reading), arm) for arm in arms]
    return [
        SeriesArm(label=one.label, specs=tuple(map(Spec.parse, one.specs)), doses=one.dose_names, modality=one.modality)
        for one in found
    ]

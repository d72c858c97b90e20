"""The analysis of the study ``why``: do false reports act by their content, or because they disturb?

The arms hit the same steps of the same trials. A lie that is retracted at once disturbs like a lie and leaves nothing
false. So the effect of lies is the sum of two paired differences:

    lie - truth = (lie - retracted) + (retracted - truth)
                  what lies say       that they disturb

The paper compares success curves and loop rates only (Sec. 3.2 and 3.3), which cannot tell the two apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from lockprobe.analysis.agent_comparison.paired import Array, BlockMean, block_mean, sheets
from lockprobe.analysis.inference.logrank import holm
from lockprobe.analysis.outcomes import Outcomes, outcomes
from lockprobe.analysis.paired_proportions import equivalence
from lockprobe.analysis.proportions import ALPHA, Proportion, proportion
from lockprobe.analysis.series import SeriesArm
from lockprobe.analysis.why_arms import ARMS, ON_REQUEST
from lockprobe.record import Trial
from lockprobe.spec import Spec, split_specs

__all__ = ["MARGIN", "ArmEffect", "Verdict", "Why", "arms_of", "verdict", "verdict_of", "why"]

_Acting = tuple[tuple[str, tuple[tuple[str, str], ...]], ...]
"""Interventions, each as its name and its options by name."""

MARGIN = 0.1
"""Equivalence margin: changes of success up to 10 percentage points count as none. The value is a convention."""

Verdict = Literal["says", "disturbs", "both", "unexplained", "no change", "not detectable"]
"""Lies change success because of what they say, because they disturb, or both; they change it, and neither part is
detectable; they change it by less than the margin; or no change is detectable."""

_POWER = 0.8
"""The power for which the needed blocks are computed."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmEffect:
    """Success in one arm, and its change from the arm with true reports.

    Attributes:
        arm: As in :data:`~lockprobe.analysis.why_arms.ARMS` and :data:`~lockprobe.analysis.why_arms.ON_REQUEST`.
        condition: The name of the condition in the study.
        success: Share solved.
        change: Success minus success under true reports, over blocks, [-1, 1]; None for the arm of true reports. Its
            P value is corrected for the number of arms (Holm); its interval is not. Both are for that of agents.
    """

    arm: str
    condition: str
    success: Proportion
    change: BlockMean | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Why:
    """The effect of false reports on one agent, decomposed into content and disturbance.

    All intervals and P values are corrected for the agents that are judged together (Bonferroni), so that a verdict on
    some of them is wrong in at most 5 % of studies.

    Attributes:
        agent: Its name, or its spec if it has none.
        modality: How the box was shown.
        p: The rate at which reports were hit, (0, 1].
        arms: Success in each arm.
        change: Lie minus truth: the total effect of lies.
        says: Lie minus retracted lie: the effect of the false content ("debunking effect").
        disturbs: Retracted lie minus truth: the effect of the disturbance alone.
        falsity: Main effect of falsity, over the arms with and without a remark; None without these arms.
        disturbance: Main effect of a remark, over true and false reports; None without these arms.
        interaction: The effect of a lie with a remark minus that without; None without these arms.
        contingent: Lies in loops minus equally many lies at random steps; None without these arms.
        equivalence: P value of the equivalence test (TOST) against changes of the margin or more, [0, 1].
        margin: The equivalence margin, (0, 1).
        verdict: The conclusion.
        needed: Blocks needed to detect a change of the margin with a power of 80 %, given the variance of these blocks.
        agents: Number of agents (and ways of showing the box) that are judged together.
    """

    agent: str
    modality: str
    p: float
    arms: tuple[ArmEffect, ...]
    change: BlockMean
    says: BlockMean
    disturbs: BlockMean
    falsity: BlockMean | None
    disturbance: BlockMean | None
    interaction: BlockMean | None
    equivalence: float
    contingent: BlockMean | None = None
    margin: float = MARGIN
    verdict: Verdict = field(init=False)
    needed: int
    agents: int = 1

    def __post_init__(self) -> None:
        concluded = verdict(self.change, self.says, self.disturbs, self.equivalence)
        object.__setattr__(self, "verdict", concluded)


def arms_of(conditions: Sequence[SeriesArm]) -> tuple[float, dict[str, str]] | None:
    """The flip rate of a study of controls, and its conditions by arm, recognised by their specs.

    Args:
        conditions: Conditions of one modality.

    Returns:
        None unless true reports, lies and retracted lies at one flip rate are among them.
    """
    found = {_acting_interventions(one.specs): one.label for one in conditions}
    for one in conditions:
        if len(one.specs) == 1 and (spec := one.specs[0]).full_name == "flip":
            rate = float(spec.options["p"])
            wanted = {arm: _at_rate(template, rate) for arm, template in _TEMPLATES.items()}
            there = {arm: found[acting] for arm, acting in wanted.items() if acting in found}
            if rate > 0 and there.keys() >= {"truth", "lie", "retracted"}:
                return rate, there
    return None


def _acting_interventions(specs: Iterable[Spec]) -> _Acting:
    """Specs in a form that does not depend on the order of options, without those of dose 0."""
    return tuple((one.full_name, tuple(sorted(one.options.items()))) for one in specs if one.options.get("p") != "0")


_TEMPLATES = {
    arm: _acting_interventions(map(Spec.parse, split_specs(text)) if text != "truth" else ())
    for arm, text in {**ARMS, **ON_REQUEST}.items()
}


def _at_rate(template: _Acting, rate: float) -> _Acting:
    """The interventions of an arm at a rate."""
    return tuple(
        (name, tuple((option, value.format(p=rate)) for option, value in options)) for name, options in template
    )


def why(
    trials: Mapping[str, Sequence[Trial]],
    conditions: Sequence[SeriesArm],
    *,
    margin: float = MARGIN,
    agents: int = 1,
) -> Why | None:
    """Analyse why lies change the success of one agent in one modality.

    Args:
        trials: Condition -> the agent's trials.
        conditions: The conditions with their specs.
        margin: Equivalence margin: smaller changes count as none, (0, 1).
        agents: Number of agents (and ways of showing the box) that are judged together.

    Returns:
        None unless two blocks or more have true reports, lies and retracted lies.
    """
    if (found := arms_of(conditions)) is None:
        return None
    p, names = found
    counted = {arm: outcomes(trials.get(name, ())) for arm, name in names.items()}
    counted = {arm: one for arm, one in counted.items() if len(one)}
    if not counted.keys() >= {"truth", "lie", "retracted"}:
        return None
    solved = _by_block(counted)
    truth, lie, retracted = solved["truth"], solved["lie"], solved["retracted"]
    change = lie - truth
    if int((~np.isnan(change + retracted)).sum()) < 2:
        return None
    first = trials[names["truth"]][0]
    four = [solved[arm] for arm in ("truth", "lie", "remark", "lie + remark") if arm in solved]
    return Why(
        agent=first.group,
        modality=first.modality,
        p=p,
        arms=_arms(names, counted, solved, agents),
        change=_mean(change, agents=agents),
        says=_mean(lie - retracted, agents=agents),
        disturbs=_mean(retracted - truth, agents=agents),
        **_crossed(*four, agents=agents)
        if len(four) == 4
        else {"falsity": None, "disturbance": None, "interaction": None},
        equivalence=_equivalence(change, margin, agents),
        contingent=_mean(solved["lie in loops"] - solved["self-yoked"], agents=agents)
        if solved.keys() >= ON_REQUEST.keys()
        else None,
        margin=margin,
        needed=_needed(change, margin, agents),
        agents=agents,
    )


def _by_block(counted: Mapping[str, Outcomes]) -> dict[str, Array]:
    """Arm -> 1 if solved, 0 if not, one row per block; NaN where no trial has ended."""
    _, made = sheets([replace(one, dose=np.zeros(len(one))) for one in counted.values()])
    return {arm: sheet.solved[:, 0] for arm, sheet in zip(counted, made, strict=True)}


def _mean(*differences: Array, unit: float = 1.0, agents: int = 1) -> BlockMean:
    """A mean over blocks; its interval and P value are corrected for the agents that are judged together."""
    found = block_mean(np.column_stack(differences), unit=unit, choices=agents)
    return found if found.p_value is None else replace(found, p_value=min(1.0, agents * found.p_value))


def _crossed(truth: Array, lie: Array, remark: Array, both: Array, *, agents: int) -> dict[str, BlockMean]:
    """Main effects and interaction of falsity and disturbance (2 x 2), over blocks with a trial in all four arms."""
    kept = ~np.isnan(truth + lie + remark + both)
    truth, lie, remark, both = (one[kept] for one in (truth, lie, remark, both))
    return {
        "falsity": _mean(lie - truth, both - remark, agents=agents),
        "disturbance": _mean(remark - truth, both - lie, agents=agents),
        "interaction": _mean((both - remark) - (lie - truth), unit=2.0, agents=agents),
    }


def _arms(
    names: Mapping[str, str], counted: Mapping[str, Outcomes], solved: Mapping[str, Array], agents: int
) -> tuple[ArmEffect, ...]:
    shares = {arm: proportion(int(one.solved.sum()), len(one)) for arm, one in counted.items()}
    changes = {arm: _mean(one - solved["truth"], agents=agents) for arm, one in solved.items() if arm != "truth"}
    corrected = dict(zip(changes, holm([one.p_value for one in changes.values()]), strict=True))
    return tuple(
        ArmEffect(
            arm=arm,
            condition=names[arm],
            success=share,
            change=replace(changes[arm], p_value=corrected[arm]) if arm in changes else None,
        )
        for arm, share in shares.items()
    )


def verdict(change: BlockMean, says: BlockMean, disturbs: BlockMean, equivalence: float) -> Verdict:
    """The conclusion, with a familywise error rate of at most 5 %.

    The two parts are tested only if lies change success. Then at most one part is zero, because they add up, and each
    is tested at 5 % without correction (closed testing of three hypotheses, two of which imply the third).
    """
    if not _detectable(change):
        return "no change" if equivalence < ALPHA else "not detectable"
    said, disturbed = _detectable(says), _detectable(disturbs)
    if said and disturbed:
        return "both"
    return "says" if said else "disturbs" if disturbed else "unexplained"


def verdict_of(truth: Array, lie: Array, retracted: Array, margin: float = MARGIN, agents: int = 1) -> Verdict:
    """The conclusion from three arms alone.

    Args:
        truth: 1 where the block was solved under true reports, 0 where not, shape (blocks,).
        lie: The same under false reports.
        retracted: The same under false reports that are retracted at once.
        margin: As for :func:`why`.
        agents: As for :func:`why`.
    """
    total, says, disturbs = (_mean(one, agents=agents) for one in (lie - truth, lie - retracted, retracted - truth))
    return verdict(total, says, disturbs, _equivalence(lie - truth, margin, agents))


def _detectable(found: BlockMean) -> bool:
    """Whether the test rejects and the interval excludes 0."""
    return found.p_value is not None and found.p_value < ALPHA and found.clear


def _standard_error(differences: Array) -> tuple[float, float, int]:
    """Mean, standard error and number of differences, after adding one differing pair (Agresti and Min 2005)."""
    kept = differences[~np.isnan(differences)]
    n, mean = len(kept), float(kept.mean())
    return mean, math.sqrt((float(np.sum((kept - mean) ** 2)) + 1) / (n - 1) / n), n


def _equivalence(differences: Array, margin: float, agents: int) -> float:
    """P value of two one-sided tests that the change is at most -margin, or at least margin (Schuirmann 1987)."""
    kept = differences[~np.isnan(differences)]
    return min(1.0, agents * equivalence(int(np.sum(kept < 0)), int(np.sum(kept > 0)), len(kept), margin))


def _needed(differences: Array, effect: float, agents: int) -> int:
    """Sample size: blocks at which a two-sided test at 5 % / agents detects an effect with a power of 80 %."""
    from scipy.stats import norm

    _, error, n = _standard_error(differences)
    reach = float(norm.ppf(1 - ALPHA / 2 / agents) + norm.ppf(_POWER))
    return math.ceil(n * (reach * error / effect) ** 2)

"""The paper's claims about modalities (Sec. 3.1), compared with what a study of several measured.

Each is about all three modalities: an agent that was not shown the box in all of them can contradict such a claim, and
cannot bear it out.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from itertools import pairwise

from lockprobe.foundation.spec import spec_kind, spec_name
from lockprobe.report.claims.claim_tests import (
    NOT_MEASURED,
    ClaimFinding,
    ClaimPattern,
    borne_out,
    pattern,
    same_share,
    same_step,
    verdict_of,
)
from lockprobe.statistics.agent_summary import AgentSummary
from lockprobe.statistics.conditions.modalities import ModalityEffect, spoken
from lockprobe.statistics.curves import SuccessCurve
from lockprobe.statistics.inference.logrank import holm
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.published import MODALITY, STEPS_TO_80
from lockprobe.statistics.summary import StudySummary
from lockprobe.trial.record import PLAIN_WORDS, STATES

Shown = Mapping[str, AgentSummary]
"""One agent by the modality in which it was shown the box."""

_DECILES = tuple(i / 10 for i in range(1, 11))


def agents_shown(summary: StudySummary) -> Iterator[tuple[ModalityEffect, Shown]]:
    """The agents that the study is about and that were shown the box in several ways, at p = 0."""
    for effect in summary.modalities:
        shown = {
            agent.modality: agent
            for agent in summary.subjects
            if agent.agent == effect.agent and agent.conditions[0].success.n and agent.conditions[0].dose == 0
        }
        if shown:
            yield effect, shown


def _three(shown: Shown) -> tuple[str, str, str]:
    """The paper's modalities. Its ground truth is a state; a report that tells outcomes too stands for it if alone."""
    return "rgb", "rgbd", next((one for one in PLAIN_WORDS if one in shown), STATES)


def _curve(shown: Shown, modality: str) -> SuccessCurve:
    return shown[modality].conditions[0].curve


def _whole(found: ClaimPattern, shown: Shown) -> ClaimPattern:
    """Only all three modalities can show what is said of three."""
    return "open" if found == "shown" and not set(_three(shown)) <= shown.keys() else found


def _final(summary: StudySummary, effect: ModalityEffect, shown: Shown) -> ClaimFinding:
    """As many trials are solved as in the paper, in every modality."""
    shares = [(modality, shown[modality].conditions[0].success) for modality in effect.modalities]
    found = [same_share(share, MODALITY) for _, share in shares]
    p_value = min((p for p in holm([p for *_, p in found]) if p is not None), default=None)
    here = "; ".join(f"{said} with {spoken(m)}" for (m, _), (said, *_) in zip(shares, found, strict=True))
    test = f"Fisher, against {MODALITY.count}/{MODALITY.n} in each modality, corrected for their number"
    return here, verdict_of(p_value, _whole("shown", shown)), test, p_value


def _sooner(effect: ModalityEffect, first: str, second: str) -> tuple[ClaimPattern, float | None]:
    """Whether the box is solved sooner in the first of two modalities, log-rank, corrected for the pairs."""
    for pair in effect.pairs:
        if (pair.first, pair.second) == (first, second) and pair.hazard_ratio is not None:
            return pattern(pair.p_adjusted, 1 - pair.hazard_ratio), pair.p_adjusted
    return "open", None


def _order(summary: StudySummary, effect: ModalityEffect, shown: Shown) -> ClaimFinding:
    """The box is solved sooner the lower the fidelity is, with RGB-D in between."""
    if effect.p_value is None:
        return NOT_MEASURED
    means = [(modality, _curve(shown, modality).restricted_mean_steps) for modality in effect.modalities]
    steps = [mean for _, mean in means if mean is not None]
    trend = pattern(effect.p_value, -effect.direction)
    pairs = [_sooner(effect, *pair)[0] for pair in pairwise(_three(shown))]
    if trend == "shown" and ("opposite" in pairs or steps != sorted(steps)):
        trend = "opposite" if "opposite" in pairs else "open"
    here = "mean steps " + ", ".join(f"{mean:.1f} with {spoken(m)}" for m, mean in means if mean is not None)
    test = "log-rank test for a trend over fidelity, and the order of the mean steps"
    return here, borne_out(_whole(trend, shown)), test, effect.p_value


def _steps(summary: StudySummary, effect: ModalityEffect, shown: Shown) -> ClaimFinding:
    """80 % are solved by the paper's steps, and sooner with RGB than with ground truth."""
    lowest, _, highest = _three(shown)
    steps = {lowest: STEPS_TO_80["rgb"], highest: STEPS_TO_80["symbolic"]}
    found = {m: same_step(shown[m].conditions[0], step) for m, step in steps.items() if m in shown}
    if not found:
        return NOT_MEASURED
    shows, p_value = _sooner(effect, lowest, highest)
    outside = any(verdict == "not compatible" for _, verdict, *_ in found.values())
    here = "; ".join(f"{said} with {spoken(modality)}" for modality, (said, *_) in found.items())
    test = "95 % intervals of the steps, from the bands, and log-rank of RGB against positions in words"
    return here, "not compatible" if outside else verdict_of(None, shows), test, p_value


def _depth(summary: StudySummary, effect: ModalityEffect, shown: Shown) -> ClaimFinding:
    """The box is solved sooner with RGB than with RGB-D, however its depth is shown."""
    for pair in effect.pairs:
        kinds = spec_name(pair.first), spec_name(pair.second)
        if kinds == ("rgb", "rgbd") and pair.hazard_ratio is not None:
            here = f"hazard ratio of solving, {spoken(pair.second)} over {spoken(pair.first)}: {pair.hazard_ratio:.2f}"
            found = borne_out(pattern(pair.p_adjusted, 1 - pair.hazard_ratio))
            return here, found, "log-rank, corrected for the pairs of modalities", pair.p_adjusted
    return NOT_MEASURED


def _outpaces(summary: StudySummary, effect: ModalityEffect, shown: Shown) -> ClaimFinding:
    """RGB reaches most shares of success before RGB-D, and RGB-D before ground truth."""
    pairs = [pair for pair in pairwise(_three(shown)) if set(pair) <= shown.keys()]
    if not pairs:
        return NOT_MEASURED
    tests = [_sooner(effect, *pair) for pair in pairs]
    here = "; ".join(_thresholds(shown, *pair) for pair in pairs)
    known = [p for _, p in tests if p is not None]
    parts = {found for found, _ in tests}
    every: ClaimPattern = "opposite" if "opposite" in parts else "shown" if parts == {"shown"} else "open"
    return (
        here,
        borne_out(_whole(every, shown)),
        "log-rank of the two pairs, corrected; the larger P value",
        max(known, default=None),
    )


def _thresholds(shown: Shown, first: str, second: str) -> str:
    """How many tenths of success one modality reaches first, of those that either reaches."""
    steps = [tuple(_curve(shown, m).steps_to(share) or 10**9 for m in (first, second)) for share in _DECILES]
    reached = [(one, two) for one, two in steps if min(one, two) < 10**9]
    sooner, later = sum(one < two for one, two in reached), sum(one > two for one, two in reached)
    of = f"{sooner} of {len(reached)} tenths of success"
    return f"{spoken(first)} reaches {of} before {spoken(second)}, {later} after it"


def _faster(summary: StudySummary, effect: ModalityEffect, shown: Shown) -> ClaimFinding:
    """The human-inspired strategy, told the state, is faster than an agent in every modality."""
    found: dict[str, tuple[float, float]] = {}
    inspired = {one.agent for one in summary.agents if spec_kind(one.spec) == "human-inspired"}
    for pace in summary.paces:
        sides = (pace.first, pace.second) if _is_baseline(pace.first, inspired) else (pace.second, pace.first)
        reference, other = sides
        if not _is_baseline(reference, inspired) or other[0] != effect.agent or other[1] not in shown:
            continue
        if pace.p_value is not None and pace.hazard_ratio:
            hazard = pace.hazard_ratio if reference == pace.second else 1 / pace.hazard_ratio
            found[other[1]] = hazard, pace.p_value
    if not found:
        return NOT_MEASURED
    parts = [pattern(p, hazard - 1) for hazard, p in found.values()]
    slower = [p for hazard, p in found.values() if hazard < 1]
    refuted = any(p is not None and p < ALPHA for p in holm(slower))
    complete = set(found) >= shown.keys()
    shows: ClaimPattern = "opposite" if refuted else "shown" if complete and set(parts) == {"shown"} else "open"
    ratios = ", ".join(f"{hazard:.2f} with {spoken(modality)}" for modality, (hazard, _) in found.items())
    here = f"hazard ratio of solving, human-inspired over this agent: {ratios}"
    test = "log-rank, clustered by block; the largest P value"
    return here, borne_out(_whole(shows, shown)), test, max(p for _, p in found.values())


def _is_baseline(both: tuple[str, str], inspired: Collection[str]) -> bool:
    return both[0] in inspired and both[1] in PLAIN_WORDS


MODALITY_MEASURES: Mapping[str, Callable[[StudySummary, ModalityEffect, Shown], ClaimFinding]] = {
    "modalities": _final,
    "modality-order": _order,
    "modality-outpaces": _outpaces,
    "modality-steps": _steps,
    "depth": _depth,
    "reference-faster": _faster,
}
"""What measures a claim over modalities."""

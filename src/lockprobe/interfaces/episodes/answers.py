"""What episodes say, as the rows of results. The P values of each question are corrected together (Bonferroni)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from itertools import combinations, count
from typing import Any

import numpy as np

from lockprobe.interfaces.episodes.frame import Codes, Episodes, Sides, compare, means_of, sides
from lockprobe.interfaces.episodes.loops import NULLS, chance, sooner
from lockprobe.report.rows import Condition, Curve, Design, Estimate, Player, Progress, Results, Row, measured_row
from lockprobe.statistics.clustered import clustered_difference, share_of
from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.statistics.how_soon import incidence
from lockprobe.statistics.loops import onset
from lockprobe.statistics.proportions import ALPHA, proportion

CONDITIONS, EACH_AGENT, AGENTS, LOOKS = "conditions", "conditions by agent", "agents", "every look"
SOON, EARLY, BY_STEP = "how soon", "loops in first steps", "loops by step"
"""Families: what their differences are of."""

SCORE, CONTROL = ", score", "the control"
"""What families of score end in; the part of a mean in what is compared that is subtracted."""

_STEPS, _CLUSTERS = 200, 7
"""Steps of a curve, beyond which they are grouped; the fewest tasks that are clusters of a test over steps, with fewer
of which these are blocks of luck."""

Columns = dict[str, Any]

Compared = Mapping[str, Sequence[tuple[Columns, Sides]]]
"""By family: the columns of each difference's rows, and what is compared."""


def results_of(of: Episodes, k: int, *, name: str, digest: str) -> Results:
    """All rows of the episodes of a file with this name and hash; loops are compared in the first k steps."""
    control, *others = of.conditions
    under = [({"condition": name, "control": control}, of.condition == c) for c, name in enumerate(others, 1)]
    compared = {
        CONDITIONS: [(names, sides(of, of.condition == 0, at, of.agent)) for names, at in under],
        EACH_AGENT: [
            ({"agent": name, **names}, sides(of, (of.agent == a) & (of.condition == 0), (of.agent == a) & at, of.agent))
            for a, name in enumerate(of.agents)
            for names, at in under
        ],
        AGENTS: [
            ({"agent": of.agents[b], "versus": of.agents[a]}, sides(of, of.agent == a, of.agent == b, of.condition))
            for a, b in combinations(range(len(of.agents)), 2)
        ],
    }
    compared = {family: [one for one in several if len(one[1].first)] for family, several in compared.items()}
    rows = [*_shares(of), *_differences(of, compared), *_speed(of, compared[EACH_AGENT])]
    rows += _loops(of, k) if any(of.actions) else ()
    conditions = tuple(Condition(name=name, modality="", control=control * (name != control)) for name in of.conditions)
    return Results(
        lockprobe=version("lockprobe"), study={"name": name, "first": k}, settings_hash="", results_hash=digest,
        progress=Progress(planned=len(of), finished=len(of)),
        design=Design(conditions=conditions, players=tuple(Player(agent=one, modality="") for one in of.agents)),
    ).with_rows(rows)  # fmt: skip


def _shares(of: Episodes) -> Iterator[Row]:
    """Episodes, success and score of each agent and condition; every task counts alike."""
    for names, own in of.cells:
        yield measured_row("trials", None, value=int(own.sum()), unit="trials", **names)
        if not np.isnan(of.solved[own]).all():
            yield measured_row("success", share_of(of.solved[own], (), (), of.task[own].astype(np.str_)), **names)
        if known := int((~np.isnan(of.score[own])).sum()):
            mean = float(np.nanmean(means_of(of.score[own], of.task[own])))
            yield measured_row("score", None, value=mean, n=known, unit="", **names)


def _differences(of: Episodes, compared: Compared) -> Iterator[Row]:
    """Every condition against the control, of all agents, also at every look, and agent by agent; every two agents."""
    for measure, values in (("success", of.solved), ("score", of.score)):
        score = measure == "score"
        unit: Columns = {"unit": "" if score else "points"}
        for family, several in compared.items():
            for names, own in several if family != EACH_AGENT or len(of.agents) > 1 else ():
                choices = len(several)
                first, second, change = compare(of, own, values, choices=choices)
                if not change.n:
                    continue
                pairs = f"larger P of t over tasks, from five on, and {'t' if score else 'sign flips'}"
                how = f"{pairs if own.by == 'pairs' else 't'} of {own.by}"
                test: Columns = {"family": family + SCORE * score, "corrected_for": choices, "test": how}
                yield measured_row(f"{measure}_difference", change, **names, **unit, **test)
                for part, mean in ((CONTROL, first), ("", second)):
                    share: Columns = {"value": mean, "unit": "" if score else "share", "of": part}
                    yield Estimate(quantity=f"{measure}_in_pairs", **share, **names)
                if family == CONDITIONS and own.by == "pairs" and not score:
                    *_, ever = compare(of, own, values, choices=choices, every_look=True)
                    test |= {"of": LOOKS, "family": LOOKS, "test": E_PROCESS}
                    yield measured_row(f"{measure}_difference", ever, **names, **unit, **test)


def _tested(quantity: str, found: Any, family: str, choices: int, cluster: Codes, columns: Columns) -> Estimate:
    """The row of a test over clusters, with its P value corrected; without one where too few can never let it reject.

    Statistics over steps are at most the square root of their number; that of first loops has two degrees less.
    """
    enough = next(k for k in count(3) if family == EARLY or choices * student_tails(k**0.5, k - 1) < ALPHA)
    few = f"Too few tasks for {choices} comparisons: it takes {enough} or more" * (len(np.unique(cluster)) < enough)
    p_value = None if few or found.p_value is None else min(1.0, choices * found.p_value)
    columns = {"of": family, "family": family, "corrected_for": choices, "p_value": p_value, "note": few} | columns
    return measured_row(quantity, found, **columns)


def _speed(of: Episodes, changes: Sequence[tuple[Columns, Sides]]) -> Iterator[Row]:
    """Success by step of every agent and condition, and how soon beside the control."""
    known, solved = ~np.isnan(of.steps + of.solved), of.solved > 0
    if not (horizon := int(of.steps[known].max(initial=0))):
        return
    wide = -(-horizon // _STEPS)
    last = np.ceil(np.where(known & solved, of.steps, horizon) / wide).astype(np.int64)
    for names, own in of.cells:
        if (here := own & known).any():
            found = incidence(last[here], solved[here], -(-horizon // wide))
            lines: Columns = {"value": found.share, "low": found.low, "high": found.high, "n": found.n}
            lines["x"] = tuple(float(i * wide) for i in range(len(found.share)))
            yield Curve(quantity="success_by_step", axis="step", **lines, **names)
    for names, both in changes:
        at, since = np.r_[both.first, both.second], np.repeat([np.inf, 0], [len(both.first), len(both.second)])
        at, since = at[known[at]], since[known[at]]
        if len(np.unique(since)) > 1:
            cluster = of.cluster(at, _CLUSTERS)
            hazard = sooner(np.where(solved[at], of.steps[at], np.inf), solved[at], since, cluster)
            columns = names | {"unit": "ratio", "test": "log-rank", "n": len(at)}
            yield _tested("hazard_ratio", hazard, SOON, len(changes), cluster, columns)


def _loops(of: Episodes, k: int) -> Iterator[Row]:
    """Loops in the first k steps beside chance, and in whole episodes; whether who looped fails."""
    length, begun = (np.array([count(did) for did in of.actions]) for count in (len, onset))
    first, reach, early = f"first {k}", length >= k, (begun > 0) & (begun <= k)
    cells, kinds = of.cells, len({one for did in of.actions for one in did})
    for names, own in cells:
        if len(here := np.flatnonzero(own & reach)):
            task, did = of.task[here], [of.actions[i][:k] for i in here.tolist()]
            yield measured_row("loop_rate", share_of(early[here], (), (), task.astype(np.str_)), of=first, **names)
            for null in NULLS:
                level = means_of(chance(did, null, kinds), task)
                yield measured_row("loop_rate", None, value=float(np.nanmean(level)), of=null, **names)
        here = np.flatnonzero(own & reach & ~np.isnan(of.solved))
        if 0 < early[here].sum() < len(here):
            cluster = of.task[here] if len(of.tasks) > 1 else here
            gap = replace(clustered_difference(of.solved[here], early[here], cluster, here), n=len(here))
            columns = names | {"unit": "points", "test": "t, clustered by task"}
            yield _tested("loop_success", gap, EARLY, len(cells), cluster, columns)
        here = np.flatnonzero(own & (length > 0) & (of.steps >= length) & ~np.isnan(of.solved))
        if len(here):
            cluster, since = of.cluster(here, _CLUSTERS), np.where(begun > 0, begun, np.inf)[here]
            hazard = sooner(of.steps[here], of.solved[here] > 0, since, cluster)
            columns = names | {"unit": "ratio", "test": "Mantel-Haenszel by step", "n": len(here)}
            yield _tested("loop_success", hazard, BY_STEP, len(cells), cluster, columns)
    for part, looped, among in (("whole", begun > 0, length > 0), (first, early, reach)):
        for end, value in (("unsolved", 0), ("solved", 1)):
            if len(ends := looped[among & (of.solved == value)]):
                yield measured_row("loop_rate", proportion(int(ends.sum()), len(ends)), of=f"{part}, {end}")

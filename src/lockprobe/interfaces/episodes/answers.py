"""What episodes say, as the rows of results. The P values of each question are corrected together (Bonferroni)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from importlib.metadata import version
from itertools import combinations, count
from typing import Any

import numpy as np

from lockprobe.interfaces.episodes.frame import Codes, Episodes, Sides, combined, compare, sides
from lockprobe.interfaces.episodes.loops import NULLS, Played, looped_before
from lockprobe.report.rows import Condition, Curve, Design, Estimate, Player, Progress, Results, Row, measured_row
from lockprobe.statistics.clustered import clustered_difference, share_of
from lockprobe.statistics.distributions import student_tails
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.statistics.how_soon import incidence, log_rank
from lockprobe.statistics.proportions import ALPHA, proportion

CONDITIONS, EACH_AGENT, AGENTS, LOOKS = "conditions", "conditions by agent", "agents", "every look"
SOON, EARLY, BY_STEP = "how soon", "loops in first steps", "loops by step"
"""Families: what their differences are of."""

SCORE, CONTROL = ", score", "the control"
"""What families of score end in; the part of a mean in what is compared that is subtracted."""

_STEPS, _AT_ONCE, _CLUSTERS = 200, 20_000_000, 7
"""Steps of a curve and its test, and these times episodes, beyond which steps are grouped; the fewest tasks that are
clusters of a test over steps, with fewer of which these are blocks of luck."""

Columns = dict[str, Any]

Changes = Sequence[tuple[Columns, Sides]]
"""Every agent under every condition beside the control: the columns of its rows, and what is compared."""


def results_of(of: Episodes, k: int, *, name: str, digest: str) -> Results:
    """All rows of the episodes of a file with this name and hash; loops are compared in the first k steps."""
    controls = {names["agent"]: own for names, own in of.cells if names["condition"] == of.conditions[0]}
    changes = [
        (names | {"control": of.conditions[0]}, sides(of, controls[names["agent"]], own, of.agent))
        for names, own in of.cells
        if names["condition"] != of.conditions[0] and names["agent"] in controls
    ]
    rows = [*_shares(of), *_changes(of, changes), *_agents(of), *_speed(of, changes)]
    rows += _loops(of, Played(of, k)) if any(of.actions) else ()
    named = [(one, of.conditions[0] * (i > 0)) for i, one in enumerate(of.conditions)]
    conditions = tuple(Condition(name=one, modality="", control=control) for one, control in named)
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
        if (known := own & ~np.isnan(of.score)).any():
            task = combined(of.task[known])
            mean = np.mean(np.bincount(task, of.score[known]) / np.bincount(task))
            yield measured_row("score", None, value=float(mean), n=int(known.sum()), unit="", **names)


def _difference(of: Episodes, measure: str, own: Sides, family: str, choices: int, names: Columns) -> Iterator[Row]:
    """The rows of a difference; none where nothing can be compared."""
    first, second, change = compare(of, own, of.measures[measure], choices=choices)
    if change.n:
        score = measure == "score"
        pairs = f"larger P of t over tasks, from five on, and {'t' if score else 'sign flips'}"
        how = pairs if own.by == "pairs" else "t"
        test: Columns = {"family": family + SCORE * score, "corrected_for": choices, "test": f"{how} of {own.by}"}
        yield measured_row(f"{measure}_difference", change, unit="" if score else "points", **names, **test)
        for part, mean in ((CONTROL, first), ("", second)):
            share: Columns = {"value": mean, "unit": "" if score else "share", "of": part}
            yield Estimate(quantity=f"{measure}_in_pairs", **share, **names)


def _changes(of: Episodes, changes: Changes) -> Iterator[Row]:
    """Every condition against the control: of all agents, also at every look, and agent by agent."""
    many = len(of.conditions) - 1
    for measure in of.measures:
        for c in range(1, many + 1):
            own = sides(of, of.condition == 0, of.condition == c, of.agent)
            names: Columns = {"condition": of.conditions[c], "control": of.conditions[0]}
            yield from _difference(of, measure, own, CONDITIONS, many, names)
            if measure == "success" and own.by == "pairs":
                *_, ever = compare(of, own, of.solved, choices=many, every_look=True)
                test: Columns = {"of": LOOKS, "family": LOOKS, "corrected_for": many, "test": E_PROCESS}
                yield measured_row("success_difference", ever, unit="points", **names, **test)
        for names, own in changes if len(of.agents) > 1 else ():
            yield from _difference(of, measure, own, EACH_AGENT, len(changes), names)


def _agents(of: Episodes) -> Iterator[Row]:
    """Every two agents, over all conditions."""
    pairs = [*combinations(range(len(of.agents)), 2)]
    for measure in of.measures:
        for one, two in pairs:
            own = sides(of, of.agent == one, of.agent == two, of.condition)
            names = {"agent": of.agents[two], "versus": of.agents[one]}
            yield from _difference(of, measure, own, AGENTS, len(pairs), names)


def _tested(quantity: str, found: Any, family: str, choices: int, cluster: Codes, columns: Columns) -> Estimate:
    """The row of a test over clusters, with its P value corrected; without one where too few can never let it reject.

    Statistics over steps are at most the square root of their number; that of first loops has two degrees less.
    """
    enough = next(k for k in count(3) if family == EARLY or choices * student_tails(k**0.5, k - 1) < ALPHA)
    few = f"Too few tasks for {choices} comparisons: it takes {enough} or more" * (len(np.unique(cluster)) < enough)
    p_value = None if few or found.p_value is None else min(1.0, choices * found.p_value)
    columns = {"of": family, "family": family, "corrected_for": choices, "p_value": p_value, "note": few} | columns
    return measured_row(quantity, found, **columns)


def _speed(of: Episodes, changes: Changes) -> Iterator[Row]:
    """Success by step of every agent and condition, and how soon beside the control."""
    known, solved = ~np.isnan(of.steps + of.solved), of.solved > 0
    if not (horizon := int(of.steps[known].max(initial=0))):
        return
    wide = -(-horizon // max(1, min(_STEPS, _AT_ONCE // len(of))))
    last = np.ceil(np.where(known, np.where(solved, of.steps, horizon), 0) / wide).astype(np.int64)
    for names, own in of.cells:
        if (here := own & known).any():
            found = incidence(last[here], solved[here], -(-horizon // wide))
            lines: Columns = {"value": found.share, "low": found.low, "high": found.high, "n": found.n}
            lines["x"] = tuple(float(i * wide) for i in range(len(found.share)))
            yield Curve(quantity="success_by_step", axis="step", **lines, **names)
    for columns, both in changes:
        at, later = np.r_[both.first, both.second], np.repeat([False, True], [len(both.first), len(both.second)])
        at, later = at[known[at]], later[known[at]]
        if 0 < later.sum() < len(later):
            cluster = of.cluster(at, _CLUSTERS)
            hazard = log_rank(last[at], solved[at], later, cluster)
            test = {"unit": "ratio", "test": "log-rank", "n": len(at)}
            yield _tested("hazard_ratio", hazard, SOON, len(changes), cluster, columns | test)


def _loops(of: Episodes, played: Played) -> Iterator[Row]:
    """Loops in the first k steps beside chance, and in whole episodes; whether who looped fails."""
    first, onset, early, cells = f"first {played.k}", played.onset, played.early, of.cells
    for names, own in cells:
        if (reach := own & played.reach).any():
            share = share_of(early[reach], (), (), of.task[reach].astype(np.str_))
            yield measured_row("loop_rate", share, of=first, **names)
            for null in NULLS:
                yield measured_row("loop_rate", None, value=played.chance(reach, null), of=null, **names)
        here = np.flatnonzero(reach & ~np.isnan(of.solved))
        if 0 < early[here].sum() < len(here):
            cluster = of.task[here] if len(of.tasks) > 1 else here
            gap = replace(clustered_difference(of.solved[here], early[here], cluster, here), n=len(here))
            columns: Columns = names | {"unit": "points", "test": "t, clustered by task"}
            yield _tested("loop_success", gap, EARLY, len(cells), cluster, columns)
        here = np.flatnonzero(own & (played.length > 0) & (of.steps >= played.length) & ~np.isnan(of.solved))
        if len(here):
            cluster = of.cluster(here, _CLUSTERS)
            hazard = looped_before(of, here, onset[here], cluster)
            columns = names | {"unit": "ratio", "test": "Mantel-Haenszel by step", "n": len(here)}
            yield _tested("loop_success", hazard, BY_STEP, len(cells), cluster, columns)
    for part, looped, among in (("whole", onset > 0, played.length > 0), (first, early, played.reach)):
        for end, value in (("unsolved", 0), ("solved", 1)):
            if len(ends := looped[among & (of.solved == value)]):
                yield measured_row("loop_rate", proportion(int(ends.sum()), len(ends)), of=f"{part}, {end}")

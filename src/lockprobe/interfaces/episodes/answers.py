"""What episodes say, as the rows of results. Each question has a family of P values, which are corrected together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from itertools import combinations
from typing import Any

import numpy as np

from lockprobe.interfaces.episodes.compared import Sides, compare, mean_of, sides
from lockprobe.interfaces.episodes.frame import Array, Episodes, Flags
from lockprobe.interfaces.episodes.loops import NULLS, Played, grouped_steps, looped_before
from lockprobe.report.rows import Condition, Curve, Design, Estimate, Player, Progress, Results, Row, measured_row
from lockprobe.statistics.clustered import clustered_difference, share_of
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.statistics.how_soon import incidence, log_rank
from lockprobe.statistics.multiple_testing import holm
from lockprobe.statistics.proportions import proportion

CONDITIONS, EACH_AGENT, AGENTS, LOOKS = "conditions", "conditions by agent", "agents", "every look"
"""Families of differences of success, or of score; each row says for how many it is corrected (Bonferroni)."""

SOON, EARLY, BY_STEP, FIRST = "how soon", "loops in first steps", "loops by step", "first loops"
"""Families that are corrected when all of their rows are there (Holm)."""

CONTROL = "the control"
"""Part of a mean in what is compared: that of the side that is subtracted."""

SCORE = ", score"
"""What the families of differences of score end in."""

TESTS = {"pairs": "over blocks", "tasks": "over tasks", "episodes": "of independent episodes"}
"""What is compared -> the test, by sign flips or Student's t; its interval has to exclude 0 too."""

_MOST, _CLUSTERS = 200, 7
"""Steps of a curve; the fewest tasks that are clusters of a test over steps: with fewer these are blocks of luck."""

Columns = dict[str, Any]
"""The columns that say what a row is of."""


def results_of(episodes: Episodes, k: int, *, name: str, digest: str) -> Results:
    """All rows of the episodes of a file with this name and hash; loops are compared in the first k steps."""
    changes, (control, *others) = [*_beside_control(episodes)], episodes.conditions
    rows = [*_shares(episodes), *_changes(episodes, changes), *_agents(episodes), *_speed(episodes, changes)]
    if any(episodes.actions):
        rows += _loops(episodes, changes, Played(episodes, k))
    conditions = [Condition(name=one, modality="", control=control * (one != control)) for one in (control, *others)]
    return Results(
        lockprobe=version("lockprobe"),
        study={"name": name, "first": k},
        settings_hash="",
        results_hash=digest,
        progress=Progress(planned=len(episodes), finished=len(episodes)),
        design=Design(
            conditions=tuple(conditions), players=tuple(Player(agent=one, modality="") for one in episodes.agents)
        ),
    ).with_rows(map(_corrected(rows), rows))


def _corrected(rows: Sequence[Row]) -> Any:
    """What gives a row with its P value corrected for the others of its family, in the families that need it."""
    judged = [row for row in rows if isinstance(row, Estimate) and row.family in (SOON, EARLY, BY_STEP, FIRST)]
    sizes = Counter(row.family for row in judged if row.p_value is not None)
    found = holm([row.p_value for row in judged], [row.family for row in judged])
    new = {
        id(row): row.model_copy(update={"p_value": p, "corrected_for": max(1, sizes[row.family])})
        for row, p in zip(judged, found, strict=True)
    }
    return lambda row: new.get(id(row), row)


def _named(of: Episodes, agent: int, condition: int) -> Columns:
    return {"agent": of.agents[agent], "condition": of.conditions[condition]}


def _beside_control(of: Episodes) -> Iterator[tuple[Columns, Sides]]:
    """Every agent under every condition beside the control."""
    for (a, c), own in (cells := of.cells).items():
        if c and (a, 0) in cells:
            yield _named(of, a, c) | {"control": of.conditions[0]}, sides(of, cells[a, 0], own, of.agent)


def _shares(of: Episodes) -> Iterator[Row]:
    """Episodes, success and score of each agent and condition."""
    for at, own in of.cells.items():
        columns = _named(of, *at)
        yield Estimate(quantity="trials", value=int(own.sum()), unit="trials", **columns)
        for name, values in of.measures.items():
            if not np.isnan(values[own]).all():
                task = of.task[own].astype(np.str_)
                found = share_of(values[own], (), (), task) if name == "success" else mean_of(of, own, values)
                yield measured_row(name, found, unit="share" if name == "success" else "", **columns)


def _difference(
    of: Episodes, measure: str, own: Sides, family: str, choices: int, columns: Columns
) -> Iterator[Estimate]:
    """The rows of a difference; none where nothing can be compared."""
    first, second, change = compare(of, own, of.measures[measure], choices=choices)
    if change.n:
        score = measure == "score"
        how = "sign flips" if own.by == "pairs" and not score else "t"
        test: Columns = {"family": family + SCORE * score, "corrected_for": choices, "test": f"{how} {TESTS[own.by]}"}
        yield measured_row(f"{measure}_difference", change, unit="" if score else "points", **columns, **test)
        for part, mean in ((CONTROL, first), ("", second)):
            unit = "" if score else "share"
            yield Estimate(quantity=f"{measure}_in_pairs", value=mean, of=part, unit=unit, **columns)


def _changes(of: Episodes, changes: Sequence[tuple[Columns, Sides]]) -> Iterator[Row]:
    """Every condition against the control: of all agents, also at every look, and agent by agent."""
    others = list(enumerate(of.conditions))[1:]
    for measure in of.measures:
        for c, name in others:
            own = sides(of, of.condition == 0, of.condition == c, of.agent)
            columns: Columns = {"condition": name, "control": of.conditions[0]}
            yield from _difference(of, measure, own, CONDITIONS, len(others), columns)
            if measure == "success" and own.by == "pairs":
                *_, ever = compare(of, own, of.solved, choices=len(others), every_look=True)
                columns |= {"of": LOOKS, "family": LOOKS, "corrected_for": len(others), "test": E_PROCESS}
                yield measured_row("success_difference", ever, unit="points", **columns)
        for columns, own in changes if len(of.agents) > 1 else ():
            yield from _difference(of, measure, own, EACH_AGENT, len(changes), columns)


def _agents(of: Episodes) -> Iterator[Row]:
    """Every two agents, over all conditions."""
    pairs = [*combinations(range(len(of.agents)), 2)]
    for measure in of.measures:
        for one, two in pairs:
            own = sides(of, of.agent == one, of.agent == two, of.condition)
            columns = {"agent": of.agents[two], "versus": of.agents[one]}
            yield from _difference(of, measure, own, AGENTS, len(pairs), columns)


def _hazards(
    of: Episodes, changes: Sequence[tuple[Columns, Sides]], last: Array, happened: Flags, family: str
) -> Iterator[Estimate]:
    """How soon something comes under each condition beside the control; its step, or the last one, NaN if unknown."""
    for columns, own in changes:
        at, later = np.r_[own.first, own.second], np.repeat([False, True], [len(own.first), len(own.second)])
        there = ~np.isnan(last[at])
        if own.by == "pairs":  # both or neither
            there = np.tile(~np.isnan(last[own.first] + last[own.second]), 2)
        at, later = at[there], later[there]
        if 0 < later.sum() < len(later):
            found = log_rank(grouped_steps(last[at]), happened[at], later, of.cluster(at, _CLUSTERS))
            test: Columns = {"unit": "ratio", "family": family, "test": "log-rank", "of": family, "n": len(at)}
            yield measured_row("hazard_ratio", found, **columns, **test)


def _speed(of: Episodes, changes: Sequence[tuple[Columns, Sides]]) -> Iterator[Row]:
    """Success by step of every agent and condition, and how soon beside the control."""
    known = ~np.isnan(of.steps + of.solved)
    horizon = int(of.steps[known].max(initial=0))
    last, wide = np.where(known, np.where(of.solved > 0, of.steps, horizon), np.nan), max(1, -(-horizon // _MOST))
    for at, own in of.cells.items() if horizon else ():
        if (here := own & known).any():
            found = incidence(np.ceil(last[here] / wide).astype(int), of.solved[here] > 0, -(-horizon // wide))
            lines: Columns = {"x": tuple(float(i * wide) for i in range(len(found.share))), "n": found.n}
            lines |= {"value": found.share, "low": found.low, "high": found.high}
            yield Curve(quantity="success_by_step", axis="step", **lines, **_named(of, *at))
    if horizon:
        yield from _hazards(of, changes, last, of.solved > 0, SOON)


def _loops(of: Episodes, changes: Sequence[tuple[Columns, Sides]], played: Played) -> Iterator[Row]:
    """Loops in the first k steps beside chance, and in whole episodes; how soon they come; whether who looped fails."""
    first, onset, early = f"first {played.k}", played.onset, played.early
    for at, own in of.cells.items():
        columns, reach = _named(of, *at), own & played.reach
        for null in NULLS if reach.any() else ():
            yield Estimate(quantity="loop_rate", value=played.chance(reach, null), of=null, **columns)
        if reach.any():
            share = share_of(early[reach], (), (), of.task[reach].astype(np.str_))
            yield measured_row("loop_rate", share, of=first, **columns)
        here = np.flatnonzero(reach & ~np.isnan(of.solved))
        if 0 < early[here].sum() < len(here):
            gap = clustered_difference(of.solved[here], early[here], of.task[here] if len(of.tasks) > 1 else here, here)
            test: Columns = {"family": EARLY, "unit": "points", "test": "t, clustered by task", "n": len(here)}
            yield measured_row("loop_success", gap, **columns | test, of=first)
        here = np.flatnonzero(own & (played.length > 0) & (of.steps >= played.length) & ~np.isnan(of.solved))
        if len(here):
            hazard = looped_before(of, here, onset[here], of.cluster(here, _CLUSTERS))
            test = {"family": BY_STEP, "unit": "ratio", "test": "Mantel-Haenszel by step", "n": len(here)}
            yield measured_row("loop_success", hazard, **columns | test, of=BY_STEP)
    for part, looped, among in (("whole", onset > 0, played.length > 0), (first, early, played.reach)):
        for end, value in (("unsolved", 0), ("solved", 1)):
            if len(ends := looped[among & (of.solved == value)]):
                yield measured_row("loop_rate", proportion(int(ends.sum()), len(ends)), of=f"{part}, {end}")
    last = np.where(onset > 0, onset, np.where(played.length > 0, played.length, np.nan))
    yield from _hazards(of, changes, last, onset > 0, FIRST)

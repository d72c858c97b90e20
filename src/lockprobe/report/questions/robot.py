"""A robot: what arm and camera took attempts for, against the truth; and attempts against the rules of the box."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from lockprobe.foundation.grouping import grouped
from lockprobe.report.format import Entry, count_of
from lockprobe.report.opened import OpenedStudy
from lockprobe.report.rows import Estimate, Results, Row, share_rows
from lockprobe.report.section import Lines, Note, Part, Section, Table
from lockprobe.statistics.clustered import clustered_proportion
from lockprobe.statistics.rules import Judged
from lockprobe.trial.source import CAMERA, VERDICT, outcomes_by

_JUDGES = {
    "verdicts": (VERDICT, "the verdict of the arm"),
    "readings": (CAMERA, "the reading of the camera"),
}
"""What judges whether a joint moved -> its name in ``sensed``, and what it is."""


def _sensed(numbers: OpenedStudy) -> Iterator[Row]:
    """Attempts as arm and camera judged them, also in trials that broke later."""
    joints = dict.fromkeys(joint for trial in numbers.analysed for joint in trial.joints)
    for judge, (name, _) in _JUDGES.items():
        attempts = [
            ((trial.repetition, trial.trial), step.joint, step.moved, said)
            for trial in numbers.analysed
            if any(name in step.sensed for step in trial.steps)
            for step, said in zip(trial.steps, outcomes_by(name, trial), strict=True)
            if name in step.sensed
        ]
        for joint in ("", *joints) if attempts else ():
            own = [one for one in attempts if joint in ("", one[1])]
            at, decided, n = f", {joint}" * bool(joint), [one for one in own if one[3] is not None], len(own)
            blocks = list(grouped(decided, lambda one: one[0]).values())
            for what, right in (("right", True), ("wrong", False))[: 1 if joint else 2]:
                counts = [sum((moved == said) == right for *_, moved, said in block) for block in blocks]
                yield from share_rows(judge, clustered_proportion(counts, list(map(len, blocks))), of=what + at)
            count = n - len(decided)
            if n:
                yield Estimate(quantity=judge, of=f"undecided{at}", value=count / n, count=count, n=n)


def _joints(found: Results) -> Lines:
    """One row per joint, and one of all."""
    judges = [judge for judge in _JUDGES if found.where(judge)]
    yield ["joint", *(head for judge in judges for head in (f"right {judge}", "of", "undecided"))]
    at = dict.fromkeys(row.of.partition("undecided, ")[2] for judge in judges for row in found.where(judge))
    for joint in [*filter(None, at), ""] if judges else ():
        row: list[Entry] = [joint or "all"]
        for judge in judges:
            right, undecided = (
                found.get(judge, of=what + f", {joint}" * bool(joint)) for what in ("right", "undecided")
            )
            row += [right, str(right.n if right else 0), str(undecided.count if undecided else 0)]
        yield row


_JOINTS = Table("robot", _joints, 1)

_SENSED = Note(
    "Attempts at each joint, over all conditions, as the arm or the camera judged them. Undecided: the arm had no grip "
    "or no conclusion, or the camera could not read the joint.",
    "Intervals (95 %) are clustered by trial; trials of equal number are one cluster.",
)


def _show_sensed(found: Results) -> Iterator[Part]:
    wrong = [(what, found.get(judge, of="wrong")) for judge, (_, what) in _JUDGES.items() if found.where(judge)]
    said = ", ".join(f"{what} at {count_of(row)} attempts" for what, row in wrong if row)
    if wrong:
        yield Part("Robot and truth", f"Wrong: {said}." if said else "", [_JOINTS, _SENSED])


def _rules(numbers: OpenedStudy) -> Iterator[Row]:
    """How often attempts broke the rules, and how the plant did it."""
    for cell in numbers.cells:
        count, n = numbers.broken_rules[cell.agent, cell.condition]
        if not n:
            continue
        yield cell.estimate("against_rules", count / n, count=count, n=n)
        if not numbers.broken_rules_said:
            continue
        yield cell.estimate("against_rules", n, of="attempts", unit="attempts")
        judged = [*map(numbers.rules.judged, cell.trials)]
        player, luck = zip(*((one.player, f"{one.repetition}/{one.trial}") for one in cell.trials), strict=True)
        for kind, (among, happened) in _BREAKS.items():
            of = [list(filter(among, trial)) for trial in judged]
            counts, sizes = [sum(map(happened, trial)) for trial in of], list(map(len, of))
            found = clustered_proportion(counts, sizes, *([player, luck] if any(player) else []))
            yield from cell.share("against_rules", found, of=kind, note="clustered by trial")


_BREAKS: dict[str, tuple[Callable[[Judged], bool], Callable[[Judged], bool]]] = {
    "missed": (lambda one: one.free, lambda one: not one.moved),
    "forced": (lambda one: not one.free, lambda one: one.moved),
    "moved another": (lambda one: True, lambda one: one.other),
}
"""Shares of attempts against the rules -> of which attempts, and which of them."""


def _conditions(found: Results) -> Lines:
    """How often attempts broke the rules, beside success."""
    head = ["agent", "condition", "at free joints", "missed", "at locked joints", "forced"]
    yield [*head, "another joint moved", "success"]
    for cell in found.cells:
        if cell.get("against_rules", "attempts"):
            missed, forced, another = (cell.get("against_rules", kind) for kind in _BREAKS)
            sizes = [str(one.n if one else 0) for one in (missed, forced)]
            yield [cell.label, cell.condition, sizes[0], missed, sizes[1], forced, another, cell.get("success")]


_CONDITIONS = Table("rules", _conditions)

_MISSED = Note(
    "Missed: a free joint did not move. Forced: a locked joint moved.",
    "Intervals (95 %) of attempts are clustered by trial.",
)


def _show_rules(found: Results) -> Iterator[Part]:
    if rows := found.where("against_rules", of="missed"):
        missed, n = sum(row.count or 0 for row in rows), sum(row.n or 0 for row in rows)
        said = f"{missed} of {n} attempts at free joints missed."
        yield Part("Attempts against the rules", said, [_CONDITIONS, _MISSED])


SECTIONS = (
    Section("robot", "Robot and truth", _sensed, _show_sensed, (_JOINTS,)),
    Section("rules", "Attempts against the rules", _rules, _show_rules, (_CONDITIONS,)),
)

"""Truth, verdict and camera: what a robot took its attempts for, against the truth and each other, joint by joint."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.report.format import TextTable
from lockprobe.report.rows import Estimate, Results, Row
from lockprobe.report.section import Note, Part, Section, Table
from lockprobe.report.study_numbers import StudyNumbers, share_rows
from lockprobe.report.table_rows import count_of, share_of_row
from lockprobe.statistics.robot import Judged, SensedAttempts

_JUDGES = {"verdict": ("right_verdicts", "undecided_verdicts"), "camera": ("right_readings", "unclear_readings")}
"""What judges outcomes -> the shares of right outcomes, and of attempts without an outcome."""

_AGREE = "verdict_camera_agreement"


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    if (robot := numbers.robot) is None:
        return
    for quantity, judged in (("wrong_verdicts", robot.all.verdict), ("wrong_readings", robot.all.camera)):
        if judged is not None:
            yield from _wrong(quantity, judged)
    yield from _of(robot.all)
    for joint, sensed in robot.joints.items():
        yield from _of(sensed, joint)


def _wrong(quantity: str, judged: Judged) -> Iterator[Estimate]:
    wrong = judged.wrong
    yield from share_rows(quantity, wrong)
    yield Estimate(quantity=quantity, of="blocked for moved", count=judged.blocked_for_moved, n=wrong.n)
    yield Estimate(quantity=quantity, of="moved for blocked", count=judged.moved_for_blocked, n=wrong.n)


def _of(sensed: SensedAttempts, joint: str = "") -> Iterator[Estimate]:
    """The rows of the attempts at one joint, or at all."""
    attempts, moved = sensed.attempts, sensed.moved
    yield Estimate(quantity="moved_attempts", of=joint, value=moved / attempts, count=moved, n=attempts)
    for judge, judged in (("verdict", sensed.verdict), ("camera", sensed.camera)):
        if judged is not None:
            right, without = _JUDGES[judge]
            yield from share_rows(right, judged.right, of=joint)
            count, n = judged.undecided, judged.attempts
            yield Estimate(quantity=without, of=joint, value=count / n, count=count, n=n)
    if sensed.agree is not None:
        yield from share_rows(_AGREE, sensed.agree, of=joint)


def _table(found: Results) -> TextTable:
    """One row per joint, and one of all; what no attempt has is left out."""
    attempts = {row.of: row for row in found.where("moved_attempts")}
    if not attempts:
        return []
    judges = [judge for judge, (_, without) in _JUDGES.items() if found.where(without)]
    head = ["joint", "attempts", "moved", "blocked"]
    for judge in judges:
        head += [f"{judge} right", "failed" if judge == "verdict" else "unclear"]
    both = bool(found.where(_AGREE))
    table = [[*head, *(["verdict and camera agree"] if both else [])]]
    for joint in [*filter(None, attempts), ""]:
        row = attempts[joint]
        cells = [joint or "all", str(row.n), str(row.count), str((row.n or 0) - (row.count or 0))]
        for judge in judges:
            right, without = (found.get(quantity, of=joint) for quantity in _JUDGES[judge])
            cells += [share_of_row(right), str(without.count if without else 0)]
        table.append(cells + ([share_of_row(found.get(_AGREE, of=joint))] if both else []))
    return table


_ROBOT = Table("robot", _table, numeric_from=1)


def _show(found: Results) -> Iterator[Part]:
    if not found.where("moved_attempts"):
        return
    arm, camera = (bool(found.where(without)) for _, without in _JUDGES.values())
    explained = []
    if arm:
        explained.append("Failed: the arm had no grip or no conclusion; a report made from it says that nothing moved.")
    if camera:
        explained.append("The camera sees a move if its reading of the joint changes. Unclear: it could not read it.")
    yield Part(
        "Truth, verdict and camera" if arm and camera else f"Truth and {'verdict' if arm else 'camera'}",
        _answer(found),
        [
            Note(
                "Every attempt as arm and camera judged it, by joint, over all conditions. Moved and blocked count the "
                "truth; right and agree leave out attempts without an outcome.",
                "Intervals (95 %) are clustered by trial; trials of equal number in all conditions are one cluster.",
                " ".join(explained),
                lead=True,
            ),
            _ROBOT,
        ],
    )


def _answer(found: Results) -> str:
    """How often each of the two was wrong, without its interval."""
    verdict, camera = found.get("wrong_verdicts"), found.get("wrong_readings")
    said = [f"the {what} at {count_of(row)}" for what, row in (("verdict", verdict), ("camera", camera)) if row]
    return f"Wrong outcomes: {' attempts, '.join(said)} attempts." if said else ""


SECTIONS = (Section(name="robot", title="Truth, verdict and camera", rows=_rows, show=_show, tables=(_ROBOT,)),)

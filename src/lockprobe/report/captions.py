"""What captions say of things that only some figures and tables have: stars, fits, kinds of intervals."""

from __future__ import annotations

from collections.abc import Iterable

from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.rows import Course
from lockprobe.statistics.clustered import FEWEST_BOXES
from lockprobe.statistics.published import PEAK


def paper_rates(courses: Iterable[Course]) -> list[float]:
    """The flip rates of the paper's values, 0 and 0.4, that lie on the axis of these agents; none with one rate."""
    played = {cell.dose for course in courses for cell in course.cells if cell.dose is not None}
    return [rate for rate in (0.0, PEAK) if len(played) > 1 and min(played) <= rate <= max(played)]


def interval_kind(every_look: object) -> str:
    """What intervals of shares of solved trials are, those of people aside: for one look if ``every_look`` is false."""
    return "confidence sequences, which hold at every look" if every_look else "Wilson intervals"


def share_intervals_said(
    agents: Iterable[str], of: str = "Intervals", *, every_look: bool = False, boxes: int = 1
) -> str:
    """What intervals of shares are, as a sentence: those of people are clustered by person.

    Args:
        agents: The agents whose shares are shown.
        of: What the intervals are of.
        every_look: Whether they hold at every look; those of success do where differences in success do.
        boxes: Boxes of the study, each of which counts alike.

    >>> share_intervals_said(["random"]), share_intervals_said(["participant"])
    ('Intervals are 95 % Wilson intervals.', 'Intervals are 95 % intervals clustered by person.')
    >>> share_intervals_said(["random"], every_look=True)
    'Intervals are 95 % confidence sequences, which hold at every look.'
    """
    people = {agent == PEOPLE for agent in agents}
    if people == {True}:
        return f"{of} are 95 % intervals clustered by person."
    kind = "intervals over boxes" if boxes >= FEWEST_BOXES else interval_kind(every_look)
    return f"{of} are 95 % {kind}{', clustered by person for people' * (True in people)}."


def success_and_loops_said(
    agents: Iterable[str], of: str = "Intervals", *, every_look: bool = False, boxes: int = 1
) -> str:
    """The same where shares of solved trials stand beside loop rates, whose intervals hold for one look.

    >>> success_and_loops_said(["random"], every_look=True).partition(" Intervals of loop")[2]
    ' rates are 95 % Wilson intervals.'
    """
    shown = [*agents]
    if not every_look:
        return share_intervals_said(shown, of, boxes=boxes)
    success = share_intervals_said(shown, "Intervals of success", every_look=True)
    loops = share_intervals_said(shown, "Intervals of loop rates")
    return success if set(shown) == {PEOPLE} else f"{success} {loops}"

"""``compare.html``: studies side by side on one self-contained page without scripts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.formatting import NONE, bracketed, p_cell, percent
from lockprobe.foundation.left_out import LeftOutSection, leaving_out, section
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.report.compare.studies import Comparison
from lockprobe.report.format import DETECTED, TextTable, share_cell
from lockprobe.report.prose.study_comparison import leading
from lockprobe.report.rendering import rendered
from lockprobe.report.section import Caption
from lockprobe.report.svg import image
from lockprobe.statistics.agent_comparison.across_studies import Side, StudyDifference

_CAPTION = Caption(
    "Difference in success between two agents, one row for each condition; filled marks were detected. Circles: pairs "
    "of trials with common random numbers; squares: independent samples.",
    "Bars are 95 % intervals and are not corrected. A difference is detected if the corrected test rejects and the "
    "interval excludes 0.",
)


def write_comparison(
    comparison: Comparison, out: Path, *, left_out: Callable[[LeftOutSection], None] = lambda section: None
) -> Path:
    """Write the page in one step. A table or figure that cannot be made is left out and named.

    Args:
        comparison: What it shows.
        out: The file.
        left_out: Told every table and figure that could not be made.

    Returns:
        Where it is.

    Raises:
        BadFile: If it cannot be written.
    """
    with leaving_out() as failed:
        page = _page(comparison, ())
        if failed:
            page = _page(comparison, failed)
    for one in failed:
        left_out(one)
    try:
        write_file(out, page)
    except OSError as error:
        raise BadFile(out, f"cannot be written ({error.strerror})") from error
    return out


def _page(comparison: Comparison, missing: Sequence[LeftOutSection]) -> str:
    first = leading(comparison.differences)
    rest = comparison.differences[len(first) :]
    picture = section(
        "Figure differences",
        lambda: _picture(first, comparison.names) if first else {},
        dict[str, bytes],
    )
    tables: dict[str, Callable[[], TextTable]] = {
        "studies": lambda: study_table(comparison),
        "success": lambda: success_table(comparison),
        "differences": lambda: difference_table(comparison, first),
        "rest": lambda: difference_table(comparison, rest),
    }
    return rendered(
        "compare",
        content=comparison,
        lockprobe=version("lockprobe"),
        images={"differences": image(picture["svg"])} if picture else {},
        caption=_CAPTION,
        tables={
            name: section(f"Table {name}", make, lambda: [["This table could not be made."]])
            for name, make in tables.items()
        },
        sections_left_out=missing,
    )


def _picture(found: Sequence[StudyDifference], names: Mapping[Side, str]) -> dict[str, bytes]:
    """The figure of differences between studies as PNG and SVG."""
    from lockprobe.report import figures
    from lockprobe.report.figures.differences import comparison_drawing

    return figures.files(comparison_drawing(found, names))


def study_table(comparison: Comparison) -> TextTable:
    """The studies: their seeds and their finished trials."""
    people = any(one.people_trials for one in comparison.studies)
    head = ["study", "name", "seed", "trials finished", *["of these, people's"] * people]
    rows = [[*head, "conditions in no other study"]]
    for one in comparison.studies:
        finished = f"{one.finished} of {one.planned}" + (" (partial)" if one.partial else "")
        by_people = [str(one.people_trials)] * people
        left = ", ".join(one.not_shared) or NONE
        rows.append([one.name, one.study, str(one.seed), finished, *by_people, left])
    return rows


def success_table(comparison: Comparison) -> TextTable:
    """Success by condition, study and agent; broken trials where there are any."""
    broken = any(one.success.broken for one in comparison.success)
    rows = [["condition", "study", "agent", "solved", "success", *["broken"] * broken]]
    for one in comparison.success:
        share = one.success
        study = comparison.studies[one.side.study].name
        agent = one.side.agent + (f" with {one.side.prompt}" if one.side.prompt else "")
        solved = f"{share.count}/{share.n}"
        rows.append([one.condition, study, agent, solved, share_cell(share), *[str(share.broken)] * broken])
    return rows


def difference_table(comparison: Comparison, found: Sequence[StudyDifference]) -> TextTable:
    """The differences, the first agent minus the second."""
    names = comparison.names
    rows = [["agent", "compared with", "condition", "trials", "success", "success of the other", "difference, points"]]
    rows[0] += ["P", "corrected P", "conclusion"]
    for one in found:
        first, second = one.first_success, one.second_success
        compared = f"{first.n} pairs" if one.paired else f"{second.n} and {first.n} trials"
        shares = [percent(share.value) for share in (second, first)]
        points = bracketed(one.value, one.low, one.high)
        numbers = [
            *shares,
            points,
            p_cell(one.p_value),
            p_cell(one.p_adjusted),
            DETECTED[bool(one.verdict)],
        ]
        rows.append([names[one.second], names[one.first], one.condition, compared, *numbers])
    return rows

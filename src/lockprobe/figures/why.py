"""Why false reports change success: success in every arm, and the two parts of the effect as bars."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.figures.compose import sheet
from lockprobe.figures.frame import FAINT, INK, safe_name, share_axis, title
from lockprobe.figures.palette import ACCENT, SUBJECTS, Style
from lockprobe.figures.primitives import estimates
from lockprobe.figures.settings import own_settings
from lockprobe.formatting import bracketed, percent, points
from lockprobe.prose.subject import Subject
from lockprobe.rows import Estimate, Results

__all__ = ["change_axis", "why"]

_LONGEST = 38
"""Characters of the agent's name."""

_PARTS = {"total": INK, "content": SUBJECTS[0], "disturbance": ACCENT}
"""The effect of false reports and its parts -> their colours."""

_ARMS = {"truth": INK, "lie": SUBJECTS[0], "retracted": ACCENT}
"""The arms that give these parts -> their colours."""


@own_settings()
def why(found: Results) -> Figure | None:
    """Arms at the top and parts below, a panel for each agent."""
    asked = found.where("false_report_effect", of="total")
    return sheet(asked, partial(_draw_ladder, found), partial(_draw_parts, found))


def _draw_ladder(found: Results, axes: Axes, total: Estimate) -> None:
    """Success in each arm with its interval, from the top in the order of the study; true reports as a line down."""
    arms = {one.of: one for one in found.where("success_in_arm", agent=total.agent, modality=total.modality)}
    axes.axvline(arms["truth"].value or 0.0, color=FAINT, linewidth=0.8, linestyle=":", zorder=1)
    for place, (arm, share) in enumerate(arms.items()):
        style = Style(colour=_ARMS.get(arm, FAINT), lead=arm in _ARMS)
        estimates(axes, [place], [share], style, across=True, markersize=6, elinewidth=1.6)
        axes.text(1.04, place, percent(share.value), va="center", clip_on=False)
    axes.set(xlim=(-0.02, 1.02), ylim=(len(arms) - 0.5, -0.5), xlabel="trials solved")
    axes.set_xticks([0, 0.5, 1], ["0", "50 %", "100 %"])
    axes.set_yticks(range(len(arms)), list(arms))
    axes.spines["left"].set_visible(False)
    axes.tick_params(axis="y", length=0)
    rate = f"intervention rate {total.doses['flip.p']:g}; n = {arms['truth'].n} per arm"
    title(axes, safe_name(Subject.of(total.agent).name, _LONGEST), rate)


def _draw_parts(found: Results, axes: Axes, total: Estimate) -> None:
    """The total effect of false reports, and its parts by content and by disturbance, in points."""
    own = {"agent": total.agent, "modality": total.modality}
    parts = [found.one("false_report_effect", **own, of=of) for of in _PARTS]
    heights = [part.value or 0.0 for part in parts]
    axes.bar(range(3), heights, width=0.6, color=list(_PARTS.values()), alpha=0.85, zorder=2)
    estimates(axes, range(3), parts, Style(colour=INK, marker=""))
    change_axis(axes, parts)
    axes.axhline(0, color=INK, linewidth=0.8)
    axes.set_xlim(-0.6, 2.6)
    axes.set_xticks(range(3), list(_PARTS))
    axes.tick_params(axis="x", length=0)
    title(axes, "Effect of false reports", bracketed(total.value or 0.0, total.low, total.high))


def change_axis(axes: Axes, changes: Iterable[Estimate]) -> None:
    """An upright axis for changes of success in points, as far in both directions as they and their intervals need."""
    reach = max(0.2, *(1.1 * abs(end or 0) for one in changes for end in (one.low, one.high, one.value)))
    share_axis(axes, "change of success, points")
    axes.set_ylim(-reach, reach)
    step = 0.5 if reach > 0.6 else 0.2 if reach > 0.3 else 0.1
    ticks = [i * step for i in range(-int(reach / step), int(reach / step) + 1)]
    axes.set_yticks(ticks, [points(tick) if tick else "0" for tick in ticks])

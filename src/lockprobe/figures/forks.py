"""The effect of one report by the step at which it was given: forks of recorded trials."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.axes import Axes

from lockprobe.analysis.branch import BranchEffect
from lockprobe.figures.frame import FAINT, INK, SMALL, safe_name, share_axis, shortened, title
from lockprobe.figures.palette import ACCENT, SUBJECTS
from lockprobe.formatting import points

__all__ = ["draw_forks", "fork_panels"]

_LONGEST = 38
"""Characters of the agent's name."""

_APART = 0.16
"""Steps between two arms at one step."""

_LOOKS = {
    "lie": (SUBJECTS[0], "o"),
    "retracted": (ACCENT, "s"),
    "confirmed": (FAINT, "D"),
    "remark": (FAINT, "P"),
    "withheld": (FAINT, "X"),
    "tremble": (FAINT, "v"),
    "random": (FAINT, "^"),
}
"""Arm -> colour and marker."""

_FORCED = (FAINT, ">")
"""The same where the next joint is forced."""


def fork_panels(effects: Sequence[BranchEffect]) -> list[list[BranchEffect]]:
    """The changes of success at numbered steps, a panel for each agent, condition and way to go on."""
    panels: dict[tuple[str, str, bool], list[BranchEffect]] = {}
    for one in effects:
        if one.outcome == "solved" and one.where.isdecimal():
            panels.setdefault((one.agent, one.condition, one.truthful), []).append(one)
    return list(panels.values())


def draw_forks(axes: Axes, found: Sequence[BranchEffect]) -> None:
    """The change of success by every arm at every step, with its interval; a true report is the line at 0."""
    steps = sorted({int(one.where) for one in found})
    arms = list(dict.fromkeys(one.arm for one in found))
    axes.axhline(0, color=INK, linewidth=0.8)
    for place, arm in enumerate(arms):
        colour, marker = _LOOKS.get(arm, _FORCED)
        own = sorted((one for one in found if one.arm == arm), key=lambda one: int(one.where))
        across = [int(one.where) + _APART * (place - (len(arms) - 1) / 2) for one in own]
        for x, one in zip(across, own, strict=True):
            if one.change.low is not None and one.change.high is not None:
                axes.plot([x, x], [one.change.low, one.change.high], color=colour, linewidth=1.4, zorder=2)
        heights = [one.change.value for one in own]
        axes.plot(across, heights, color=colour, linewidth=0.8, marker=marker, markersize=5, label=arm, zorder=3)
    ends = [end for one in found for end in (one.change.low or 0, one.change.high or 0, one.change.value)]
    reach = max(0.2, 1.1 * max(map(abs, ends), default=0))
    share_axis(axes, "change of success, points")
    axes.set_ylim(-reach, reach)
    step = 0.5 if reach > 0.6 else 0.2 if reach > 0.3 else 0.1
    ticks = [i * step for i in range(-int(reach / step), int(reach / step) + 1)]
    axes.set_yticks(ticks, [points(tick) if tick else "0" for tick in ticks])
    axes.set_xticks(steps)
    axes.set_xlim(steps[0] - 1, steps[-1] + 1)
    axes.set_xlabel("step whose report is changed", fontsize=SMALL, color=INK)
    axes.tick_params(labelsize=SMALL)
    numbers = sorted({one.change.blocks for one in found})
    said = f"n = {numbers[0]}" if len(numbers) == 1 else f"n = {numbers[0]} to {numbers[-1]}"
    first = found[0]
    later = ", later reports true" if first.truthful else ""
    title(axes, safe_name(shortened(first.agent, _LONGEST)), safe_name(f"{first.condition}{later}; {said} trials"))

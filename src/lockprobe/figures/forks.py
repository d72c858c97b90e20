"""The effect of one report by the step at which it was given: forks of recorded trials."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.figures.compose import sheet
from lockprobe.figures.frame import FAINT, INK, SMALL, safe_name, shortened, title
from lockprobe.figures.palette import ACCENT, SUBJECTS
from lockprobe.figures.settings import own_settings
from lockprobe.figures.why import change_axis
from lockprobe.rows import Estimate, Results

__all__ = ["forks"]

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

_Effects = dict[tuple[str, int], Estimate]
"""The changes of success by arm and step."""


@own_settings()
def forks(found: Results) -> Figure | None:
    """The changes of success at numbered steps, a panel for each agent, condition and way to go on."""
    panels: dict[tuple[str, str, str], _Effects] = {}
    for one in found.where("success_change_by_fork"):
        arm, where, later = one.of.rsplit(", ", 2)
        if where.isdecimal():
            panels.setdefault((one.agent, one.condition, later), {})[arm, int(where)] = one
    return sheet(list(panels.values()), _draw) if panels else None


def _draw(axes: Axes, found: _Effects) -> None:
    """The change of success by every arm at every step, with its interval; a true report is the line at 0."""
    steps = sorted({step for _, step in found})
    arms = list(dict.fromkeys(arm for arm, _ in found))
    axes.axhline(0, color=INK, linewidth=0.8)
    for place, arm in enumerate(arms):
        colour, marker = _LOOKS.get(arm, _FORCED)
        own = {step: found[arm, step] for step in steps if (arm, step) in found}
        across = [step + _APART * (place - (len(arms) - 1) / 2) for step in own]
        for x, one in zip(across, own.values(), strict=True):
            if one.low is not None and one.high is not None:
                axes.plot([x, x], [one.low, one.high], color=colour, linewidth=1.4, zorder=2)
        heights = [one.value or 0.0 for one in own.values()]
        axes.plot(across, heights, color=colour, linewidth=0.8, marker=marker, markersize=5, label=arm, zorder=3)
    change_axis(axes, found.values())
    axes.set_xticks(steps)
    axes.set_xlim(steps[0] - 1, steps[-1] + 1)
    axes.set_xlabel("step whose report is changed", fontsize=SMALL, color=INK)
    axes.tick_params(labelsize=SMALL)
    numbers = sorted({one.clusters or 0 for one in found.values()})
    said = f"n = {numbers[0]}" if len(numbers) == 1 else f"n = {numbers[0]} to {numbers[-1]}"
    first = next(iter(found.values()))
    later = ", later reports true" if first.of.endswith(", later reports true") else ""
    title(axes, safe_name(shortened(first.agent, _LONGEST)), safe_name(f"{first.condition}{later}; {said} trials"))

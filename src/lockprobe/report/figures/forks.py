"""The effect of one report by the step at which it was given: forks of recorded trials."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.frame import from_to, safe_name, share_axis, title
from lockprobe.report.figures.palette import ACCENT, SUBJECTS, Style
from lockprobe.report.figures.primitives import estimates
from lockprobe.report.figures.settings import FAINT, INK, own_settings
from lockprobe.report.figures.why import change_ticks
from lockprobe.report.rows import Estimate, Results

_LONGEST = 38
"""Characters of the agent's name."""

_APART = 0.16
"""Steps between two arms at one step."""

_LOOKS = {
    "lie": Style(colour=SUBJECTS[0]),
    "truth-truth": Style(colour=FAINT, marker="D"),
    "lie-truth": Style(colour=ACCENT, marker="s"),
    "truth-lie": Style(colour=ACCENT, marker="D"),
    "lie-lie": Style(colour=SUBJECTS[0], marker="s"),
    "remark": Style(colour=FAINT, marker="P"),
    "withheld": Style(colour=FAINT, marker="X"),
    "tremble": Style(colour=FAINT, marker="v"),
    "random": Style(colour=FAINT, marker="^"),
}
"""How each arm is drawn."""

_FORCED = Style(colour=FAINT, marker=">")
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
    return sheet(list(panels.values()), _draw)


def _draw(axes: Axes, found: _Effects) -> None:
    """The change of success by every arm at every step, with its interval; a true report is the line at 0."""
    steps = sorted({step for _, step in found})
    arms = list(dict.fromkeys(arm for arm, _ in found))
    axes.axhline(0, color=INK, linewidth=0.8)
    for place, arm in enumerate(arms):
        style = _LOOKS.get(arm, _FORCED)
        own = {step: found[arm, step] for step in steps if (arm, step) in found}
        across = [step + _APART * (place - (len(arms) - 1) / 2) for step in own]
        estimates(axes, across, list(own.values()), style, linestyle="-", linewidth=0.8, label=arm)
    share_axis(axes, "change of success, points")
    change_ticks(axes.yaxis, found.values())
    axes.set(xticks=steps, xlim=(steps[0] - 1, steps[-1] + 1), xlabel="step whose report is changed")
    first, n = next(iter(found.values())), from_to(one.clusters for one in found.values())
    later = ", later reports true" if first.of.endswith(", later reports true") else ""
    title(axes, safe_name(first.agent, _LONGEST), safe_name(f"{first.condition}{later}; n = {n} trials"))

"""Why false reports change success: success in every arm, and the two parts of the effect as bars."""

from __future__ import annotations

from matplotlib.axes import Axes

from lockprobe.analysis.agent_comparison.paired import BlockMean
from lockprobe.analysis.why import Why
from lockprobe.figures.forest import interval
from lockprobe.figures.frame import FAINT, INK, SMALL, safe_name, share_axis, shortened, title
from lockprobe.figures.palette import ACCENT, SUBJECTS
from lockprobe.formatting import percent, points

__all__ = ["draw_ladder", "draw_parts"]

_LONGEST = 38
"""Characters of the agent's name."""


def draw_ladder(axes: Axes, found: Why) -> None:
    """Success in each arm with its interval, from the top in the order of the study; true reports as a line down."""
    truth = next(one for one in found.arms if one.arm == "truth")
    assert truth.success.value is not None
    axes.axvline(truth.success.value, color=FAINT, linewidth=0.8, linestyle=":", zorder=1)
    for place, one in enumerate(found.arms):
        share, colour = one.success, _colour(one.arm)
        if share.value is None or share.low is None or share.high is None:
            continue
        axes.plot([share.low, share.high], [place, place], color=colour, linewidth=1.6, zorder=2)
        face = colour if one.arm in ("truth", "lie", "retracted") else "white"
        axes.plot(share.value, place, "o", color=colour, markerfacecolor=face, markersize=6, zorder=3)
        axes.text(1.04, place, percent(share.value), va="center", fontsize=SMALL, color=INK, clip_on=False)
    axes.set_ylim(len(found.arms) - 0.5, -0.5)
    axes.set_yticks(range(len(found.arms)), [one.arm for one in found.arms], fontsize=SMALL, color=INK)
    axes.set_xlim(-0.02, 1.02)
    axes.set_xticks([0, 0.5, 1], ["0", "50 %", "100 %"])
    axes.set_xlabel("trials solved", fontsize=SMALL, color=INK)
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.spines["bottom"].set(color="#888888", linewidth=0.7)
    axes.tick_params(color="#888888", labelcolor=INK, labelsize=SMALL, width=0.7, length=3)
    axes.tick_params(axis="y", length=0)
    title(
        axes,
        safe_name(shortened(found.agent, _LONGEST)),
        f"intervention rate {found.p:g}; n = {truth.success.n} per arm",
    )


def _colour(arm: str) -> str:
    return {"truth": INK, "lie": SUBJECTS[0], "retracted": ACCENT}.get(arm, FAINT)


def draw_parts(axes: Axes, found: Why) -> None:
    """The total effect of false reports, and its parts by content and by disturbance, in points."""
    parts: list[tuple[str, BlockMean, str]] = [
        ("total", found.change, INK),
        ("content", found.says, SUBJECTS[0]),
        ("disturbance", found.disturbs, ACCENT),
    ]
    for place, (_, part, colour) in enumerate(parts):
        axes.bar(place, part.value, width=0.6, color=colour, alpha=0.85, zorder=2)
        if part.low is not None and part.high is not None:
            axes.plot([place, place], [part.low, part.high], color="#222222", linewidth=1.2, zorder=3)
    ends = [end for _, one, _ in parts for end in (one.low or 0, one.high or 0, one.value)]
    reach = max(0.2, 1.1 * max(map(abs, ends)))
    share_axis(axes, "change of success, points")
    axes.set_ylim(-reach, reach)
    step = 0.5 if reach > 0.6 else 0.2 if reach > 0.3 else 0.1
    ticks = [i * step for i in range(-int(reach / step), int(reach / step) + 1)]
    axes.set_yticks(ticks, [points(tick) if tick else "0" for tick in ticks])
    axes.axhline(0, color=INK, linewidth=0.8)
    axes.set_xlim(-0.6, 2.6)
    axes.set_xticks(range(3), [name for name, _, _ in parts], fontsize=SMALL, color=INK)
    axes.tick_params(axis="x", length=0)
    title(axes, "Effect of false reports", interval(found.change.value, found.change.low, found.change.high))

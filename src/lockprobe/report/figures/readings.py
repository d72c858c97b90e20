"""What a false report is: success by flip rate under each reading, above the shares of reports that were false.

The shares of a reading stand below its line and its name, and so the figure needs no legend of readings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lockprobe.foundation.formatting import percent
from lockprobe.report.figures.compose import sheet
from lockprobe.report.figures.frame import agent_label, counts, p_axis, share_axis, title
from lockprobe.report.figures.palette import Dash, Marker, Style, of_agent
from lockprobe.report.figures.primitives import by_dose, published, published_by_p
from lockprobe.report.figures.settings import INK, own_settings
from lockprobe.report.prose.readings import reading_name
from lockprobe.report.rows import Course, Results
from lockprobe.statistics.published import SOLVED_AT_0, SOLVED_AT_40

_LOOKS: tuple[tuple[Marker, Dash], ...] = (
    ("o", "-"),
    ("s", (0, (5, 1.5))),
    ("^", (0, (4, 1.2, 1, 1.2))),
    ("D", (0, (1, 1.2))),
)
"""Mark and dash of the readings, in the order of the study."""

_SHARES = {"outcomes": ("false_report", "steps"), "positions": ("false_positions", "")}
"""What the strip holds: false outcomes of all steps, and reports with a false position."""

_ROW = 0.18
"""Height of a row of the strip, in inches."""

_BLOCK = len(_SHARES) + 1.4
"""Rows of a reading in the strip: its name, its shares and what stands between it and the next."""


@dataclass(frozen=True, slots=True)
class _Panel:
    """An agent under several readings: what each is, how it looks, and the agent's course."""

    own: Sequence[tuple[str, Style, Course]]

    @property
    def first(self) -> Course:
        """The course under the first reading."""
        return self.own[0][2]


@own_settings()
def readings(found: Results) -> Figure | None:
    """A panel for each agent that heeds reports and was played under several readings; None without any."""
    panels = [panel for panel in _panels(found) if len(panel.own) > 1]
    panels.sort(key=lambda panel: not panel.first.subject)
    rows = _BLOCK * max((len(panel.own) for panel in panels), default=0)
    return sheet(panels, _success, _strip, heights=(2.3, _ROW * rows + 0.2))


def _panels(found: Results) -> list[_Panel]:
    own: dict[tuple[str, str], list[tuple[str, Style, Course]]] = {}
    for i, (axis, options) in enumerate(found.readings):
        marker, dash = _LOOKS[i % len(_LOOKS)]
        style, white = Style(colour=INK, marker=marker, dash=dash), 0.6 * (i % len(_LOOKS)) / len(_LOOKS)
        for course in found.courses(axis):
            if len(course.played) > 1 and not course.blind:
                own.setdefault((course.agent, course.modality), []).append(
                    (reading_name(options), of_agent(course, style, white), course)
                )
    return [_Panel(tuple(one)) for one in own.values()]


def _success(axes: Axes, panel: _Panel) -> None:
    every_look = panel.first.found.progress.every_look
    kind = "confidence sequences" if every_look else "Wilson intervals"
    for _, style, course in panel.own:
        by_dose(axes, course.played, "success", style, linestyle=style.dash)
    cells = [cell for _, _, course in panel.own for cell in course.played]
    if panel.first.subject:
        published(axes, published_by_p(cells, SOLVED_AT_0, SOLVED_AT_40))
    share_axis(axes, "success rate")
    p_axis(axes, cells)
    title(axes, agent_label(panel.first), f"{counts(panel.first.played)} per flip rate; 95 % {kind}")


def _strip(axes: Axes, panel: _Panel) -> None:
    """The shares as numbers below the flip rates, those of each reading below its name and its line."""
    across, names = axes.get_yaxis_transform(), {}
    for i, (words, style, course) in enumerate(panel.own):
        top = i * _BLOCK
        axes.plot([-0.3, -0.2, -0.1], [top] * 3, markevery=[1], transform=across, clip_on=False, **style.line)
        axes.text(-0.06, top, words, transform=across, color=INK, ha="left", va="center")
        for below, (name, (quantity, of)) in enumerate(_SHARES.items(), start=1):
            names[top + below] = name
            for cell in course.played:
                if (share := cell.value(quantity, of)) is not None:
                    axes.text(cell.dose or 0.0, top + below, percent(share), color=INK, ha="center", va="center")
    p_axis(axes, [cell for _, _, course in panel.own for cell in course.played])
    axes.set(ylim=(len(panel.own) * _BLOCK - 0.9, -0.5), xticks=[], xlabel="share of reports that were false")
    axes.set_yticks(list(names), list(names.values()))
    axes.tick_params(length=0, pad=7)
    axes.spines[:].set_visible(False)
    axes.grid(visible=False)

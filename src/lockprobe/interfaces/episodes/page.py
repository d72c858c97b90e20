"""The report of episodes: results.json, tables, a figure, and a page with one answer and the questions below it.

What the page says of each question, and which tables it has, stands in ``questions.toml``.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterator, Sequence
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.formatting import NONE, capital, listed, p_cell, p_value, percent
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import make_directory, write_file
from lockprobe.interfaces.episodes.answers import AGENTS, CONDITIONS, CONTROL, SCORE, TESTS, results_of
from lockprobe.interfaces.episodes.columns import ColumnMap
from lockprobe.interfaces.episodes.frame import Episodes
from lockprobe.interfaces.episodes.loops import NULLS
from lockprobe.interfaces.episodes.reading import read_episodes
from lockprobe.report.format import DETECTED, as_csv, beside, entry_text
from lockprobe.report.page import Page, drawn_figure, image, results_text
from lockprobe.report.rendering import rendered
from lockprobe.report.rows import Estimate, Fact, Results, clearness
from lockprobe.report.section import Figure, Lines, Note, Part, Table
from lockprobe.statistics.proportions import ALPHA
from lockprobe.studies import PAGE, RESULTS, SETTINGS

_TEXTS: dict[str, Any] = tomllib.loads(files(__package__).joinpath("questions.toml").read_text("utf-8"))

_GAP = "difference, points"

NOTES = "notes"
"""What facts are about that qualify the answer."""


def write_episodes(paths: Sequence[Path], columns: ColumnMap, *, first: int, out: Path) -> Results:
    """Write the report of the episodes of several files into a directory.

    Loops are compared in so many ``first`` steps, 6 at least. What qualifies the answer are facts of what is found.

    Raises:
        BadFile: If a file is not what it should be, or the directory holds a study.
    """
    if (out / SETTINGS).exists():
        raise BadFile(out, "holds a study, whose report would be replaced: give another --out")
    episodes = read_episodes(paths, columns)
    digest = hashlib.sha256(b"".join(hashlib.sha256(read_input(path)).digest() for path in paths)).hexdigest()
    found = results_of(episodes, first, name=listed([path.name for path in paths], named=3), digest=digest)
    row = _primary(found)
    notes = [Fact(about=NOTES, name=f"{i}", text=said) for i, said in enumerate(_notes(episodes, found, row))]
    found = found.changed(answer=_answer(found, row), facts=tuple(notes))
    page, written = Page(found=found), {RESULTS: results_text(found)}
    parts = [*_parts(page)]
    for block in (block for part in parts for block in part.blocks):
        if isinstance(block, Table):
            written[f"tables/{block.name}.csv"] = as_csv(page.cells(block))
        elif isinstance(block, Figure) and (svg := drawn_figure(found, block)):
            page.drawn = {block.name: image(svg)}
            written[f"figures/{block.name}.svg"] = svg.decode()
    sides = dict(zip(_names(row), _both(found, row), strict=True)) if row else {}
    written[PAGE] = rendered("questions", found=found, page=page, parts=parts, row=row, sides=sides, of=episodes)
    for name, content in written.items():
        make_directory((out / name).parent)
        write_file(out / name, content)
    return found


def _notes(of: Episodes, found: Results, row: Estimate | None) -> Iterator[str]:
    """What qualifies the answer: how many match, how many have no end, and what cannot be asked."""
    if row is not None and row.test.endswith(TESTS["pairs"]):
        own = [one for one in found.where("trials") if (one.agent if row.versus else one.condition) in _names(row)]
        used, many = 2 * (row.n or 0), sum(int(one.value or 0) for one in own)
        rest = "; the others count in success by condition and in loops" * (used < many)
        what = "condition" if row.versus else "agent"
        yield f"{row.n} pairs match in {what}, task and seed: {used} of {many} episodes{rest}."
    elif row is not None:
        over = f"each of {row.clusters} tasks is a difference of means" if row.clusters else "all are independent"
        yield f"Fewer than seven blocks of task and seed match, so that {over}."
    if unknown := int(np.isnan(of.solved).sum()) % len(of):
        yield f"Nobody says how {unknown} episodes ended; success and its changes hold whatever it was."
    there = {
        "condition": len(of.conditions) > 1,
        "agent": len(of.agents) > 1,
        "task": len(of.tasks) > 1,
        "seed": of.luck.max() >= 0,
        "solved": found.where("success"),
        "steps": found.curves,
        "actions": found.where("loop_rate"),
    }
    if missing := [f"{what} ({name})" for name, what in _TEXTS["missing"].items() if not there[name]]:
        yield f"Not asked, for want of values in a column: {', '.join(missing)}."


def _parts(page: Page) -> Iterator[Part]:
    """The questions that have an answer."""
    for name, text in _TEXTS["questions"].items():
        families, columns = text.get("families", ()), text.get("columns")
        tables = [Table(name, partial(_listed, columns=columns), 2, rare=_RARE)] if columns else []
        for family in families:
            lines = partial(_judged, family=family)
            tables.append(Table(family.replace(" ", "_"), lines, 3, drawn=_GAP, rare=_RARE))
        if shown := [table for table in tables if page.cells(table)]:
            rows = [row for row in page.found.rows if row.family in families]
            said = _beyond_chance(page.found) if name == "loops" else text.get("said") or _said(rows)
            before = [_reason(page.found)] * (name == "failure") + [_FIGURE] * (name == "soon")
            note = Note(text["shown"], text["computed"], text.get("more", ""))
            yield Part(text["heading"], said, [*before, *shown, note], name)


def _primary(found: Results) -> Estimate | None:
    """The clearest change by a condition, else the clearest difference between agents; corrected for that choice."""
    for family in (CONDITIONS, AGENTS, CONDITIONS + SCORE, AGENTS + SCORE):
        if rows := [row for row in found.rows if row.family == family]:
            return min(rows, key=clearness)
    return None


def _names(row: Estimate) -> tuple[str, str]:
    """What is subtracted in a difference, and from what."""
    return (row.versus, row.agent) if row.versus else (row.control, row.condition)


def _both(found: Results, row: Estimate) -> list[Estimate]:
    """The means of the two sides of a difference; none of one that has none."""
    of = {name: getattr(row, name) for name in ("agent", "condition", "control", "versus")}
    name = row.quantity.replace("_difference", "_in_pairs")
    both = [] if row.of else [found.get(name, **of, of=part) for part in (CONTROL, "")]
    return [one for one in both if one]


def _answer(found: Results, row: Estimate | None) -> str:
    """What was found, in one sentence."""
    if row is None:
        only = next((one for name in ("success", "score") for one in found.where(name, of="")), None)
        return (
            f"{capital(only.quantity)}: {entry_text(only)}. Nothing can be compared." if only else "Nothing is known."
        )
    measure, (first, second), gap = row.quantity.removesuffix("_difference"), _names(row), row.value or 0.0
    size = f"{entry_text(row).replace(' [', ' points [' if row.unit else ' [')}, {p_value(row.p_value)}"
    if not row.detected:
        return f"No difference of {measure} between {first} and {second} was shown: {size}."
    if row.versus:
        return f"{second} has {'more' if gap > 0 else 'less'} {measure} than {first}: {size}."
    return f"{capital(second)} {'raises' if gap > 0 else 'lowers'} {measure}: {size}."


def _detected(row: Estimate) -> bool:
    """Whether a test rejects; the interval of a difference has to leave out 0 too."""
    return row.detected if row.unit != "ratio" else row.p_value is not None and row.p_value < ALPHA


def _said(rows: Sequence[Estimate]) -> str:
    """How many differences were detected, and the clearest."""
    judged = [row for row in rows if row.p_value is not None]
    clear = sorted(filter(_detected, judged), key=clearness)
    where = [", ".join(filter(None, (row.agent, row.versus or row.condition))) for row in clear[:1]]
    most = f", most clearly {where[0]}: {entry_text(clear[0])}" if clear else ""
    return f"{len(clear)} of {len(judged)} differences were detected{most}." if judged else "Nothing was tested."


_RARE = ("agent", "condition", "compared with", "both", "success", "score")
"""Columns that are left out where they say nothing."""


def _judged(found: Results, family: str) -> Lines:
    """The differences of a family, with what is concluded from each."""
    rows = [row for row in found.rows if row.family == family]
    unit = {"points": _GAP, "ratio": "ratio of rates"}.get(rows[0].unit if rows else "", "difference")
    yield ["agent", "condition", "compared with", "n", "both", unit, "P", "conclusion"]
    for row in rows:
        both, said = _both(found, row), DETECTED if _detected(row) else f"not {DETECTED}"
        who = [name or None for name in (row.agent, row.condition, row.control or row.versus)]
        shares = ", ".join(map(entry_text, both)) or None
        yield [*who, str(row.n), shares, beside(row, *both) if both else row, p_cell(row.p_value), said]


def _listed(found: Results, columns: dict[str, Sequence[str]]) -> Lines:
    """Numbers of each agent and condition: heading -> quantity and part."""
    first = f"first {found.study['first']}"
    yield ["agent", "condition", "episodes", *(name.replace("first k", first) for name in columns)]
    for row in found.where("trials"):
        of = {"agent": row.agent, "condition": row.condition}
        parts = [(quantity, part.replace("first k", first)) for quantity, part in columns.values()]
        cells = [found.get(quantity, **of, of=part) for quantity, part in parts]
        size = next((one.n for one in cells if one and one.n), None)
        if size:
            yield [row.agent or None, row.condition or None, str(size), *cells]


def _beyond_chance(found: Results) -> str:
    """For how many agents and conditions the interval of loops in the first steps lies above each level of chance."""
    rows, said = found.where("loop_rate", of=f"first {found.study['first']}"), list[str]()
    for null, name in zip(NULLS, ("uniform choices", "own actions shuffled", "own Markov chains"), strict=True):
        levels = [found.one("loop_rate", agent=row.agent, condition=row.condition, of=null) for row in rows]
        above = sum((row.low or 0.0) > (level.value or 0.0) for row, level in zip(rows, levels, strict=True))
        said.append(f"{name} in {above}")
    return f"Intervals lie above the chance of {listed(said)} of {len(rows)}."


def _reason(found: Results) -> str:
    """Why loops are compared at equal length, with what whole episodes would say."""
    k = found.study["first"]
    shares = [
        percent(row.value) if (row := found.get("loop_rate", agent="", condition="", of=f"{part}, {end}")) else NONE
        for part in ("whole", f"first {k}")
        for end in ("unsolved", "solved")
    ]
    return (
        "Length confounds loops, because long episodes have more time to loop and failures are long: of whole episodes "
        f"{shares[0]} of the unsolved and {shares[1]} of the solved hold a loop, in the first {k} steps of those that "
        f"reach {k} {shares[2]} and {shares[3]}."
    )


def _draw(found: Results) -> Any:
    from lockprobe.report.figures import drawing

    conditions = [one.name for one in found.design.conditions]

    def panel(axes: Any, agent: str) -> None:
        curves = [curve for curve in found.curves if curve.agent == agent]
        for curve in curves:
            place = conditions.index(curve.condition)
            colour = drawing.COLOURS[(place - 1) % len(drawing.COLOURS)] if place else drawing.INK
            name = drawing.safe_name(curve.condition or "all", 30)
            axes.step(curve.x, drawing.numbers(curve.value), where="post", color=colour, linewidth=1.4, label=name)
            ends = map(drawing.numbers, (curve.low, curve.high))
            axes.fill_between(curve.x, *ends, step="post", color=colour, alpha=0.12, linewidth=0)
        drawing.share_axis(axes, "solved")
        drawing.whole_axis(axes, curves[0].x[-1], "step")
        drawing.title(axes, drawing.safe_name(agent, 30))

    return drawing.sheet([*dict.fromkeys(curve.agent for curve in found.curves)], panel)


_FIGURE = Figure(
    "solved_by_step",
    "Share of episodes solved by step, for each agent and condition",
    lambda found: Note("Share of episodes solved by each step.", "Bands: pointwise 95 % intervals."),
    _draw,
)

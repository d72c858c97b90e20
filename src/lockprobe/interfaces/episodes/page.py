"""The report of episodes: results.json, tables, a figure, and a page with one answer and the questions below it.

What the page says of each question, and which tables it has, stands in ``questions.toml``.
"""

from __future__ import annotations

import hashlib
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from importlib.resources import files
from itertools import cycle
from operator import attrgetter
from pathlib import Path
from typing import Any

import numpy as np

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.formatting import capital, listed, p_cell, p_value
from lockprobe.foundation.grouping import grouped
from lockprobe.foundation.inputs import read_input
from lockprobe.interfaces.episodes.answers import AGENTS, CONDITIONS, CONTROL, SCORE, results_of
from lockprobe.interfaces.episodes.frame import Episodes
from lockprobe.interfaces.episodes.reading import read_episodes
from lockprobe.report.format import DETECTED, Entry, alone, as_csv, beside, entry_text
from lockprobe.report.page import Page, drawn_figure, image, results_text, write_files
from lockprobe.report.rendering import rendered
from lockprobe.report.rows import Curve, Estimate, Fact, Results, clearness
from lockprobe.report.section import Figure, Lines, Note, Part, Table
from lockprobe.statistics.proportions import ALPHA
from lockprobe.studies import PAGE, RESULTS, SETTINGS

_TEXTS: dict[str, Any] = tomllib.loads(files(__package__).joinpath("questions.toml").read_text("utf-8"))

_RARE = ("agent", "condition", "compared with", "both", "success", "score")
"""Columns that are left out where they say nothing."""

_LABELS = {"points": "difference, points", "ratio": "ratio of rates"}


def write_episodes(paths: Sequence[Path], columns: str, *, first: int, out: Path) -> Results:
    """Write the report of the episodes of several files into a directory.

    ``columns`` says which is which (:func:`read_episodes`). Loops are compared in so many ``first`` steps, 6 at least.
    What qualifies the answer are facts of what is found.

    Raises:
        BadFile: If a file is not what it should be, or the directory holds a report of something else.
    """
    ours = (out / RESULTS).exists() and b'\n "settings_hash": "",' in read_input(out / RESULTS)
    for name in (SETTINGS, RESULTS, PAGE):
        if (out / name).exists() and (name == SETTINGS or not ours):
            raise BadFile(out / name, "is not of a report of episodes, and would be replaced: give another --out")
    episodes = read_episodes(paths, columns)
    digest = hashlib.sha256(b"".join(hashlib.sha256(read_input(path)).digest() for path in paths)).hexdigest()
    found = results_of(episodes, first, name=listed([path.name for path in paths], named=3), digest=digest)
    order = (CONDITIONS, AGENTS, CONDITIONS + SCORE, AGENTS + SCORE)  # the first that there is, and its clearest
    judged = [row for row in found.rows if row.family in order]
    row = min(judged, key=lambda row: (order.index(row.family), clearness(row)), default=None)
    notes = [Fact(about="notes", name=f"{i}", text=said) for i, said in enumerate(_notes(episodes, found, row))]
    found = found.changed(answer=_answer(found, row), facts=tuple(notes))
    page, svg = Page(found=found), drawn_figure(found, _FIGURE)
    page.drawn = {_FIGURE.name: image(svg)} if svg else {}
    questions = [_question(page, name, text) for name, text in _TEXTS["questions"].items()]
    tables = {one.name: page.cells(one) for own, _ in questions for one in own}
    written: dict[str, str | bytes | None] = {RESULTS: results_text(found), f"figures/{_FIGURE.name}.svg": svg or None}
    written |= {f"tables/{name}.csv": as_csv(cells) if cells else None for name, cells in tables.items()}
    parts = [part for _, part in questions if part]
    values = {"row": row, "both": _both(found, row) if row else [], "parts": parts, "of": episodes}
    written[PAGE] = rendered("questions", found=found, page=page, **values)
    write_files(out, written.items())
    return found


def _question(page: Page, name: str, text: Mapping[str, Any]) -> tuple[list[Table], Part | None]:
    """The tables of a question, and its part of the page if one of them has a row."""
    families = text.get("families", {})
    tables = [Table(name, partial(_listed, columns=text["columns"]), rare=_RARE)] if "columns" in text else []
    for family in families:
        lines = partial(_judged, family=family)
        tables.append(Table(family.replace(" ", "_"), lines, 3, drawn=_LABELS["points"], rare=_RARE))
    if not (shown := [table for table in tables if page.cells(table)]):
        return tables, None
    rows = [row for row in page.found.rows if row.family in families]
    said = capital("; ".join(_said(rows, families, page.cells(shown[0])))) + "."
    first = page.found.study["first"]
    parts = [f"{part}, {end}" for part in ("whole", f"first {first}") for end in ("unsolved", "solved")]
    rates = [entry_text(alone(page.found.get("loop_rate", agent="", condition="", of=part))) for part in parts]
    before = [text["reason"].format(*rates, k=first)] if "reason" in text else []
    few = "".join(f" {one}." for one in dict.fromkeys(row.note for row in rows) if one)
    note = Note(text["shown"], text["computed"] + few, text.get("more", ""))
    return tables, Part(text["heading"], said, [*before, *[_FIGURE] * ("figure" in text), *shown, note], name)


def _notes(of: Episodes, found: Results, row: Estimate | None) -> Iterator[str]:
    """What qualifies the answer: how many match, how many have no end, and what cannot be asked."""
    said, unknown = _TEXTS["notes"], int(np.isnan(of.solved).sum()) % len(of)
    if row is not None and row.test.endswith("pairs"):
        names = (row.agent, row.versus) if row.versus else (row.condition, row.control)
        own = [one for one in found.where("trials") if (one.agent if row.versus else one.condition) in names]
        used, many = 2 * (row.n or 0), sum(int(one.value or 0) for one in own)
        pairs = said["pairs"].format(row.n, "condition" if row.versus else "agent", used, many)
        yield f"{pairs}{said['rest'] * (used < many)}."
    elif row is not None:
        yield said[row.test.rpartition(" ")[2]]
    if unknown:
        yield said["unknown"].format(unknown)
    texts = (len(names) > 1 for names in (of.conditions, of.agents, of.tasks))
    asked = (*texts, of.luck.max() >= 0, found.where("success"), found.curves, found.where("loop_rate"))
    if missing := [what for what, there in zip(_TEXTS["missing"], asked, strict=True) if not there]:
        yield said["missing"].format(", ".join(missing))


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
        return f"Nothing can be compared: {f'{only.quantity} {entry_text(only)}' if only else 'nothing is known'}."
    way = "up" if (row.value or 0.0) > 0 else "down"
    text = _TEXTS["answer"][f"agents {way}" if row.versus else way] if row.detected else _TEXTS["answer"]["open"]
    size = f"{entry_text(row).replace(' [', ' points [' if row.unit else ' [')}, {p_value(row.p_value)}"
    names = row.control or row.versus, row.condition or row.agent
    return capital(text.format(*names, row.quantity.removesuffix("_difference"), size))


def _detected(row: Estimate) -> bool:
    """Whether a test rejects; the interval of a difference has to leave out 0 too."""
    return row.detected if row.unit != "ratio" else row.p_value is not None and row.p_value < ALPHA


def _said(rows: Sequence[Estimate], families: dict[str, str], table: Sequence[Sequence[Entry]]) -> Iterator[str]:
    """How many differences of each family were detected, and who is above whom; without any, each column's range."""
    for family in dict.fromkeys(row.family for row in rows):
        judged = [row for row in rows if row.family == family and row.p_value is not None]
        clear, most = sorted(filter(_detected, judged), key=clearness), ""
        for row in clear[:1]:  # a ratio without a value is of a control that solves nothing
            who, other = ", ".join(filter(None, (row.agent, row.condition))), row.versus or row.control
            way = "below" if row.value is not None and row.value < (row.unit == "ratio") else "above"
            most = f", most clearly {who}{f' {way} {other}' * bool(other)}: {entry_text(row)}"
        one = "a difference" if clear else "no difference"
        many = f"{len(clear) or 'none'} of {len(judged)} differences" if len(judged) > 1 else one
        yield f"{families[family]}: {f'{many} detected{most}' if judged else 'too few tasks'}"
    for heading, *cells in () if rows else zip(*table, strict=True):
        numbers = sorted((one for one in cells if isinstance(one, Estimate)), key=lambda one: one.value or 0.0)
        if ends := dict.fromkeys(entry_text(alone(one)) for one in (*numbers[:1], *numbers[-1:])):
            yield f"{heading}: {' to '.join(ends)}"


def _judged(found: Results, family: str) -> Lines:
    """The differences of a family, with what is concluded from each."""
    rows = [row for row in found.rows if row.family == family]
    label = _LABELS.get(rows[0].unit if rows else "", "difference")
    yield ["agent", "condition", "compared with", "n", "both", label, "P", "conclusion"]
    for row in rows:
        both, few = _both(found, row), "too few tasks" if row.p_value is None else f"not {DETECTED}"
        who = [name or None for name in (row.agent, row.condition, row.control or row.versus)]
        shares, gap = ", ".join(map(entry_text, both)) or None, beside(row, *both) if both else row
        yield [*who, str(row.n), shares, gap, p_cell(row.p_value), DETECTED if _detected(row) else few]


def _listed(found: Results, columns: dict[str, Sequence[str]]) -> Lines:
    """Numbers of each agent and condition: heading -> quantity and part."""
    first = f"first {found.study['first']}"
    yield ["agent", "condition", "episodes", *(name.replace("first k", first) for name in columns)]
    for row in found.where("trials"):
        of = {"agent": row.agent, "condition": row.condition}
        cells = [found.get(name, **of, of=part.replace("first k", first)) for name, part in columns.values()]
        if size := next((one.n for one in cells if one and one.n), None):
            yield [row.agent or None, row.condition or None, str(size), *cells]


def _draw(found: Results) -> Any:
    from lockprobe.report.figures import drawing

    colours = dict(zip([one.name for one in found.design.conditions], cycle((drawing.INK, *drawing.COLOURS))))

    def panel(axes: Any, curves: Sequence[Curve]) -> None:
        for curve in curves:
            style = drawing.Style(colour=colours[curve.condition], marker="", lead=True)
            drawing.staircase(axes, curve, style, 0, drawing.safe_name(curve.condition or "all", 30))
        drawing.share_axis(axes, "solved")
        drawing.whole_axis(axes, curves[0].x[-1], "step")
        drawing.title(axes, drawing.safe_name(curves[0].agent, 30))

    return drawing.sheet([*grouped(found.curves, attrgetter("agent")).values()], panel)


_CAPTION = Note("Share of episodes solved by each step.", "Bands: pointwise 95 % intervals.")
_FIGURE = Figure("solved_by_step", "Share solved by step of each agent and condition", lambda found: _CAPTION, _draw)

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
from lockprobe.foundation.formatting import capital, listed, p_cell, p_value
from lockprobe.foundation.inputs import read_input
from lockprobe.foundation.storage.atomic_file import make_directory, write_file
from lockprobe.interfaces.episodes.answers import AGENTS, CONDITIONS, CONTROL, SCORE, results_of
from lockprobe.interfaces.episodes.frame import Episodes
from lockprobe.interfaces.episodes.reading import read_episodes
from lockprobe.report.format import DETECTED, Entry, alone, as_csv, beside, entry_text
from lockprobe.report.page import Page, drawn_figure, image, results_text
from lockprobe.report.rendering import rendered
from lockprobe.report.rows import Estimate, Fact, Results, clearness
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
        BadFile: If a file is not what it should be, or the directory holds a study.
    """
    if (out / SETTINGS).exists():
        raise BadFile(out, "holds a study, whose report would be replaced: give another --out")
    old = [name for name in (RESULTS, PAGE) if (out / name).exists()]
    if old and (old[0] == PAGE or b'\n "settings_hash": "",' not in read_input(out / RESULTS)):
        raise BadFile(out / old[0], "is not of a report of episodes, and would be replaced: give another --out")
    episodes = read_episodes(paths, columns)
    digest = hashlib.sha256(b"".join(hashlib.sha256(read_input(path)).digest() for path in paths)).hexdigest()
    found = results_of(episodes, first, name=listed([path.name for path in paths], named=3), digest=digest)
    order = (CONDITIONS, AGENTS, CONDITIONS + SCORE, AGENTS + SCORE)  # the first that there is, and its clearest
    judged = [row for row in found.rows if row.family in order]
    row = min(judged, key=lambda row: (order.index(row.family), clearness(row)), default=None)
    notes = [Fact(about="notes", name=f"{i}", text=said) for i, said in enumerate(_notes(episodes, found, row))]
    found = found.changed(answer=_answer(found, row), facts=tuple(notes))
    page, written = Page(found=found), {RESULTS: results_text(found)}
    parts = [*_parts(page)]
    for block in (block for part in parts for block in part.blocks):
        if isinstance(block, Table):
            written[f"tables/{block.name}.csv"] = as_csv(page.cells(block))
        elif isinstance(block, Figure) and (svg := drawn_figure(found, block)):
            page.drawn = {block.name: image(svg)}
            written[f"figures/{block.name}.svg"] = svg.decode()
    values = {"row": row, "both": _both(found, row) if row else [], "parts": parts, "of": episodes}
    written[PAGE] = rendered("questions", found=found, page=page, **values)
    for name, content in written.items():
        make_directory((out / name).parent)
        write_file(out / name, content)
    asked = _TEXTS["questions"].items()
    could = [f"tables/{one.replace(' ', '_')}.csv" for key, text in asked for one in (key, *text.get("families", ()))]
    for name in {*could, f"figures/{_FIGURE.name}.svg"} - written.keys() if old else ():
        (out / name).unlink(missing_ok=True)  # of a question that is not asked now
    return found


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


def _parts(page: Page) -> Iterator[Part]:
    """The questions that have an answer."""
    for name, text in _TEXTS["questions"].items():
        families, columns = text.get("families", {}), text.get("columns")
        tables = [Table(name, partial(_listed, columns=columns), 2, rare=_RARE)] if columns else []
        for family in families:
            lines = partial(_judged, family=family)
            tables.append(Table(family.replace(" ", "_"), lines, 3, drawn=_LABELS["points"], rare=_RARE))
        if shown := [table for table in tables if page.cells(table)]:
            rows = [row for row in page.found.rows if row.family in families]
            said = capital("; ".join(_said(rows, families, page.cells(shown[0])))) + "."
            k = page.found.study["first"]
            parts = [f"{part}, {end}" for part in ("whole", f"first {k}") for end in ("unsolved", "solved")]
            rates = [page.found.get("loop_rate", agent="", condition="", of=part) for part in parts]
            reason = text.get("reason", "").format(*(entry_text(alone(row)) for row in rates), k=k)
            before = [reason] * bool(reason) + [_FIGURE] * ("figure" in text)
            few = "".join(f" {one}." for one in dict.fromkeys(row.note for row in rows) if one)
            note = Note(text["shown"], text["computed"] + few, text.get("more", ""))
            yield Part(text["heading"], said, [*before, *shown, note], name)


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

    conditions = [one.name for one in found.design.conditions]

    def panel(axes: Any, agent: str) -> None:
        curves = [curve for curve in found.curves if curve.agent == agent]
        for curve in curves:
            place = conditions.index(curve.condition)
            colour = drawing.COLOURS[(place - 1) % len(drawing.COLOURS)] if place else drawing.INK
            share, *ends = map(drawing.numbers, (curve.value, curve.low, curve.high))
            name = drawing.safe_name(curve.condition or "all", 30)
            axes.step(curve.x, share, where="post", color=colour, linewidth=1.4, label=name)
            axes.fill_between(curve.x, *ends, step="post", color=colour, alpha=0.12, linewidth=0)
        drawing.share_axis(axes, "solved")
        drawing.whole_axis(axes, curves[0].x[-1], "step")
        drawing.title(axes, drawing.safe_name(agent, 30))

    return drawing.sheet([*dict.fromkeys(curve.agent for curve in found.curves)], panel)


_CAPTION = Note("Share of episodes solved by each step.", "Bands: pointwise 95 % intervals.")
_FIGURE = Figure("solved_by_step", "Share solved by step of each agent and condition", lambda found: _CAPTION, _draw)

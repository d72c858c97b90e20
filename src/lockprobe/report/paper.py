"""What an article needs of a study: the paper's exhibits under its own names, a narrow table, and the methods.

Every number comes from ``results.json``. The directory ``paper`` of the study holds every figure of the report as PDF
(``fig3.pdf``, ``fig4.pdf``, ``fig5a.pdf`` and ``fig5b.pdf`` are the paper's), ``table1.tex``, ``results.tex``,
``methods.tex``, ``references.bib``, and ``example.tex``, which puts them together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any

from markupsafe import Markup

from lockprobe.foundation.formatting import p_cell
from lockprobe.foundation.left_out import section
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.foundation.storage.links import make_directory
from lockprobe.report.format import tex_text
from lockprobe.report.methods import condition_in_words, methods_tex
from lockprobe.report.page import tables_of
from lockprobe.report.questions import all_sections
from lockprobe.report.rows import Estimate, Results
from lockprobe.report.section import Figure
from lockprobe.report.write import File

PAPER = "paper"
"""The directory, in that of the study."""

_COLUMN = 3.6
"""Inches up to which a figure stands in one column."""

_LINES = 32
"""Rows of a table that fit on a page of an article with their caption."""

_EXAMPLE = r"""\documentclass[twocolumn]{article}
\usepackage{booktabs,graphicx}
\begin{document}
\section*{Methods}
\input{methods}

\section*{Results}
%s
\bibliographystyle{plain}
\bibliography{references}
\end{document}
"""

_CAPTION = (
    "Success with 95 % intervals, and its change from the control in the trials that were finished under both. P values"
    " are corrected within their families; a change is detected if P is below 0.05 and its interval excludes 0."
)

_TABLE1 = "Misinterpretations as in Table 1 of Zenkri and Brock: mean rate per trial with its standard deviation."


def write_paper(found: Results, directory: Path) -> Path:
    """Write the files into the directory of a study, and return the directory that holds them."""
    make_directory(directory / PAPER)
    for name, content in paper_files(found):
        if content is not None:
            write_file(directory / PAPER / name, content)
    return directory / PAPER


def paper_files(found: Results) -> Iterator[File]:
    """Every file, by its name in the directory."""
    from lockprobe.report.figures.drawing import render

    shown = []
    for figure in (one for of in all_sections() for one in of.figures if one.applies(found)):
        made: Any = section(f"Figure {figure.name}", partial(figure.draw, found), lambda: None)
        if made is not None:
            yield f"{figure.name}.pdf", render(made, "pdf")
            shown += [_float(found, figure, wide=bool(made.get_figwidth() > _COLUMN))] * (figure.name != "box")
    tables = {"results.tex": results_tex(found)}
    if table := tables_of(found).get("table1"):
        head, *rows = (" & ".join(map(tex_text, row)) for row in table)
        tables["table1.tex"] = _table("l" * len(table[0]), head, rows, _TABLE1)
    yield from ((name, content) for name, content in tables.items() if content)
    yield "methods.tex", methods_tex(found)
    references = files("lockprobe.report").joinpath("templates/references.bib").read_text(encoding="utf-8")
    yield "references.bib", references.replace("VERSION", found.lockprobe)
    inputs = [rf"\input{{{name.removesuffix('.tex')}}}" for name, content in tables.items() if content]
    yield "example.tex", _EXAMPLE % "\n\n".join([tex_text(found.answer), *shown, *inputs, ""])


def _float(found: Results, figure: Figure, *, wide: bool) -> str:
    said = figure.caption_of(found)
    text = " ".join(one.striptags() if isinstance(one, Markup) else one for one in (said.shown, said.computed))
    lines = (r"\centering", rf"\includegraphics[width=\linewidth]{{{figure.name}}}", rf"\caption{{{tex_text(text)}}}")
    star = "*" * wide
    return "\n".join([rf"\begin{{figure{star}}}", *lines, rf"\end{{figure{star}}}"])


def _table(columns: str, head: str, rows: list[str], caption: str) -> str:
    lines = [r"\centering", rf"\begin{{tabular}}{{{columns}}}", r"\toprule", rf"{head} \\", r"\midrule"]
    end = [r"\bottomrule", r"\end{tabular}", rf"\caption{{{tex_text(caption)}}}"]
    return "\n".join([r"\begin{table*}", *lines, *(rf"{row} \\" for row in rows), *end, r"\end{table*}", ""])


def results_tex(found: Results) -> str:
    """Six columns: who, where, trials, solved, the change, and its P value; a long table in several floats."""
    where = "condition" if found.beside_flips else "flip rate"
    spread = r"\multicolumn{2}{l}"
    head = rf"agent & {where} & trials & {spread}{{solved, \%}} & {spread}{{change, points}} & \emph{{P}}"
    columns = rf"l{'l' if found.beside_flips else 'r'}rr@{{ }}lr@{{ }}lr"
    floats, every = list[str](), [*_rows(found)]
    for part in (every[i : i + _LINES] for i in range(0, len(every), _LINES)):
        both = pairwise([("", ""), *part])  # {} since a bracket would be an option of the row
        rows = [f"{{}}{agent if agent != last else ''} & {cells}" for (last, _), (agent, cells) in both]
        again = "\\addtocounter{table}{-1}\n" * bool(floats)  # a long table is several floats of one number
        floats.append(again + _table(columns, head, rows, _CAPTION))
    return "\n".join(floats)


def _rows(found: Results) -> Iterator[tuple[str, str]]:
    """Every agent under every condition: its label and the other cells; no change of a control."""
    words: Mapping[str, str] = {one.name: condition_in_words(one) for one in found.design.conditions}
    changes = {(row.agent, row.condition): row for row in reversed(found.against_control()) if row.value is not None}
    for cell in found.cells:
        success, change, said = cell.get("success"), changes.get((cell.agent, cell.condition)), " & & "
        if success is not None and success.value is not None:
            at = words[cell.condition] if found.beside_flips or cell.p is None else f"{cell.p:g}"
            solved = f"{success.n} & {100 * success.value:.0f} & {_interval(success, '.0f')}"
            if change is not None and change.value is not None:
                said = f"${_points(change.value, '+.0f')}$ & {_interval(change, '+.0f')} & "
                said += tex_text(p_cell(change.p_value))
            yield tex_text(cell.label), f"{tex_text(at)} & {solved} & {said}"


def _interval(row: Estimate, form: str) -> str:
    return "" if row.low is None or row.high is None else f"$[{_points(row.low, form)}, {_points(row.high, form)}]$"


def _points(value: float, form: str) -> str:
    said = f"{100 * value:{form}}"
    return "0" if said in ("+0", "-0") else said

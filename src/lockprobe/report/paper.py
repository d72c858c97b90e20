"""What an article needs of a study: one figure at the sizes of print, one narrow table, and a paragraph on the methods.

Every number comes from the rows and the settings in ``results.json``. The files stand in the directory ``paper`` of the
study: ``paper.pdf`` has the figure in one column and in two, ``paper.tex`` the table, ``methods.tex`` the paragraph;
``example.tex`` puts them together.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from importlib.resources import files
from pathlib import Path

from lockprobe.foundation.left_out import section
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.foundation.storage.links import make_directory
from lockprobe.report.format import tex_text
from lockprobe.report.methods import methods_tex
from lockprobe.report.paper_table import table_tex
from lockprobe.report.questions import all_sections
from lockprobe.report.report_files import File, made_figure
from lockprobe.report.rows import Results
from lockprobe.report.section import Figure

PAPER = "paper"
"""The directory, in that of the study."""

_CAPTION = (
    "Success of each agent. Bars: 95 % intervals of single shares; changes are tested in pairs. Grey: between random "
    "agents with and without immediate repeats. Stars: what Zenkri and Brock report, of another model and box."
)


def write_paper(found: Results, directory: Path) -> Path:
    """Write the files into the directory of a study, and return the directory that holds them."""
    make_directory(directory / PAPER)
    make_directory(directory / PAPER / "figures")
    for name, content in paper_files(found):
        if content is not None:
            write_file(directory / PAPER / name, content)
    return directory / PAPER


def paper_files(found: Results) -> Iterator[File]:
    """Every file, by its path in the directory: the article's parts, and all figures of the report as PDF."""
    from lockprobe.report.figures import pages_as_pdf
    from lockprobe.report.figures.first_screen import draw_overview

    column, wide = draw_overview(found, "column"), draw_overview(found, "print")
    if column is not None and wide is not None:
        yield "figure-column.pdf", pages_as_pdf([column])
        yield "figure-wide.pdf", pages_as_pdf([wide])
        yield "paper.pdf", pages_as_pdf([column, wide])
    for figure in dict.fromkeys(one for of in all_sections() for one in of.figures):
        drawn = section(f"Figure {figure.name}", partial(_as_pdf, found, figure), lambda: None)
        yield f"figures/{figure.name}.pdf", drawn
    yield "paper.tex", table_tex(found)
    yield "methods.tex", methods_tex(found)
    yield "answer.tex", f"{tex_text(found.answer)}\n"
    yield "references.bib", _template("references.bib").replace("VERSION", found.lockprobe)
    document = _template("example.tex").replace("CAPTION", tex_text(_CAPTION))
    yield "example.tex", document


def _template(name: str) -> str:
    return files("lockprobe.report").joinpath(f"templates/{name}").read_text(encoding="utf-8")


def _as_pdf(found: Results, figure: Figure) -> bytes | None:
    from lockprobe.report.figures import pages_as_pdf

    made = made_figure(found, figure)
    return None if made is None else pages_as_pdf([made])

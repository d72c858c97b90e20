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

from lockprobe.foundation.formatting import listed, p_cell
from lockprobe.foundation.left_out import section
from lockprobe.foundation.storage.atomic_file import write_file
from lockprobe.foundation.storage.links import make_directory
from lockprobe.report.format import tex_text
from lockprobe.report.report_files import File, made_figure
from lockprobe.report.rows import Cell, Estimate, Results
from lockprobe.report.section import Figure
from lockprobe.report.sections import all_sections

__all__ = ["methods_tex", "paper_files", "table_tex", "write_paper"]

PAPER = "paper"
"""The directory, in that of the study."""

_CAPTION = (
    "Success of each agent. Bars: 95 % intervals of single shares; changes are tested in pairs. Grey: between random "
    "agents with and without immediate repeats. Stars: what Zenkri and Brock report, of another model and box."
)

_TABLE = (
    "Success with 95 % intervals, and its change from the control. P values are corrected within their families; a "
    "change is detected if P is below 0.05 and its interval excludes 0."
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
    for figure in dict.fromkeys(one for of in all_sections() if not of.source for one in of.figures):
        drawn = section(f"Figure {figure.name}", partial(_as_pdf, found, figure), lambda: None)
        yield f"figures/{figure.name}.pdf", drawn
    yield "paper.tex", table_tex(found)
    yield "methods.tex", methods_tex(found)
    yield "answer.tex", f"{tex_text(found.answer)}\n"
    yield "references.bib", _template("references.bib").replace("VERSION", found.lockprobe)
    document = _template("example.tex").replace("CAPTION", tex_text(_CAPTION)).replace("TABLE", tex_text(_TABLE))
    yield "example.tex", document


def _template(name: str) -> str:
    return files("lockprobe.report").joinpath(f"templates/{name}").read_text(encoding="utf-8")


def _as_pdf(found: Results, figure: Figure) -> bytes | None:
    from lockprobe.report.figures import pages_as_pdf

    made = made_figure(found.own, figure)
    return None if made is None else pages_as_pdf([made])


def table_tex(found: Results) -> str:
    """Every agent under every condition in six columns: who, where, trials, solved, the change, and its P value."""
    where = "condition" if found.beside_flips else "flip rate"
    head = (
        rf"agent & {where} & trials & \multicolumn{{2}}{{l}}{{solved, \%}} & \multicolumn{{2}}{{l}}{{change, points}}"
    )
    lines = [
        rf"\begin{{tabular}}{{l{'l' if found.beside_flips else 'r'}rr@{{ }}lr@{{ }}lr}}",
        r"\toprule",
        rf"{head} & \emph{{P}} \\",
    ]
    last = ""
    for cell in found.cells:
        success = cell.get("success")
        if success is None or success.value is None:
            continue
        if cell.agent != last:
            lines.append(r"\midrule" if not last else r"\addlinespace")
        named = tex_text(cell.label) if cell.agent != last else ""
        at = f"{cell.p:g}" if cell.p is not None and not found.beside_flips else tex_text(cell.condition)
        lines.append(f"{{}}{named} & {at} & {success.n} & {_share(success)} & {_change(found, cell)} \\\\")
        last = cell.agent
    return "\n".join([*lines, r"\bottomrule", r"\end{tabular}"]) + "\n"


def _share(row: Estimate) -> str:
    """A share in per cent, and its interval."""
    assert row.value is not None
    return f"{100 * row.value:.0f} & {_interval(row)}"


def _change(found: Results, cell: Cell) -> str:
    """The change from the control, its interval and its P value; empty for the control, and where none was tested."""
    for row in found.against_control():
        ours = (row.agent, row.condition) == (cell.agent, cell.condition) and row.modality in ("", cell.modality)
        if ours and row.value is not None:
            return f"${100 * row.value:+.0f}$ & {_interval(row, '+')} & {tex_text(p_cell(row.p_value))}"
    return " & & "


def _interval(row: Estimate, sign: str = "") -> str:
    if row.low is None or row.high is None:
        return ""
    low, high = (f"{100 * end:{sign}.0f}" for end in (row.low, row.high))
    return f"$[{low}, {high}]$"


def methods_tex(found: Results) -> str:
    """One paragraph: the puzzle, the agents, the design, what is left out, intervals and tests, and the hashes."""
    return (
        " ".join(filter(None, (_system(found), _played(found), _left_out(found), _tested(found), _kept(found)))) + "\n"
    )


def _system(found: Results) -> str:
    box, trial = found.study.get("box", {}), next(iter(found.said("overview", "trial")), "")
    joints = f", with {len(box.get('joints', ()))} joints" if box.get("joints") else ""
    reconstructed = box.get("name") == "chain-4" or any(
        "human-inspired" in one for one in found.study.get("agents", ())
    )
    limits = " The interlock of their box and the algorithm of their strategy are not public; ours are reconstructions."
    return (
        rf"We used Lockprobe {tex_text(found.lockprobe)}~\cite{{lockprobe}}, which implements the system of Zenkri and "
        rf"Brock~\cite{{zenkri-brock}}. {tex_text(trial)} The box was {_code(box.get('name', ''))}{joints}."
        f"{limits if reconstructed else ''}"
    )


def _played(found: Results) -> str:
    study, names = found.study, [one.name for one in found.design.conditions]
    agents = [_code(agent) for agent in study.get("agents", ())]
    trials, repetitions = study.get("trials"), study.get("repetitions")
    more = study.get("strategy_trials")
    extent = f"{repetitions} repetitions of {trials} trials" + (f" ({more} of strategies and learners)" if more else "")
    only = set(study.get("strategy_conditions", ()))
    without = (
        f"; {listed([_code(one) for one in names if one in only])} by strategies and learners alone" if only else ""
    )
    conditions = f"{_number(len(names), 'condition')}: {listed([_code(one) for one in names])}{without}"
    return (
        f"It was played by {_number(len(agents), 'agent')} ({listed(agents)}) under {conditions}. The design has "
        f"{extent} under each condition, and a budget of {study.get('max_steps')} steps. Trials of the same number "
        f"share their random numbers across conditions and agents (seed {study.get('seed')})."
    )


def _left_out(found: Results) -> str:
    progress, broken = found.progress, found.get("left_out", of="ended as error")
    errors = int(broken.value) if broken is not None and broken.value else 0
    left = (
        f"; {_number(errors, 'trial')} ended as an error and {'are' if errors != 1 else 'is'} in no number"
        if errors
        else ""
    )
    return f"{progress.finished} of {progress.planned} planned trials were finished{left}."


def _tested(found: Results) -> str:
    if found.progress.every_look:
        return "Intervals and P values hold at every look at the growing data."
    rows = [row for row in found.against_control() if row.p_value is not None]
    tests = list(dict.fromkeys(row.test.removesuffix(", and interval") for row in rows if row.test))
    most = max((row.corrected_for for row in rows), default=1)
    corrected = f", corrected for at most {most} comparisons of a family" if most > 1 else ""
    said = r"Intervals of shares are Wilson's, at 95\,\%~\cite{wilson1927}."
    if not tests:
        return said
    return (
        f"{said} Changes of success were tested by {listed([tex_text(one) for one in tests])}{corrected}; a change "
        r"counts as detected if \emph{P} is below 0.05 and its 95\,\% interval excludes 0."
    )


def _kept(found: Results) -> str:
    return (
        rf"The settings have the hash {_code(found.settings_hash)}, and the records "
        rf"{_code(found.results_hash)}; \texttt{{lockprobe verify}} recomputes every number from the records."
    )


def _number(many: int, what: str) -> str:
    return f"{many} {what}{'s' * (many != 1)}"


def _code(spec: str) -> str:
    """A spec in typewriter type, which may be broken after its parts."""
    return rf"\texttt{{{tex_text(spec).replace(':', ':' + chr(92) + 'allowbreak{}')}}}"

"""What an article needs of a study: the paper's exhibits under its own names, a narrow table, and the methods.

Every number comes from ``results.json``. The directory ``paper`` of the study holds every figure of the report as PDF,
and as PNG for slides (``fig3.pdf``, ``fig4.pdf``, ``fig5a.pdf`` and ``fig5b.pdf`` are the paper's), ``table1.tex``,
``results.tex``, ``methods.tex``, ``references.bib``, and ``example.tex``, which puts them together.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib.resources import files
from pathlib import Path

from markupsafe import Markup

from lockprobe.foundation.formatting import count, listed, p_cell
from lockprobe.foundation.spec import PEOPLE, Spec
from lockprobe.foundation.storage.atomic_file import make_directory, write_file
from lockprobe.report.format import entry_text, tex_text, texts
from lockprobe.report.left_out import section
from lockprobe.report.page import cells_of, figures_of, parts_of
from lockprobe.report.primary import changes_from_control
from lockprobe.report.prose import false_reports, interval_kind
from lockprobe.report.questions.decisions import TABLE1
from lockprobe.report.rows import Condition, Results
from lockprobe.statistics.every_look import E_PROCESS
from lockprobe.statistics.modalities import spoken

PAPER = "paper"
"""The directory, in that of the study."""

_COLUMN = 3.6
"""Inches up to which a figure stands in one column."""

_LINES = 32
"""Rows of a table that fit on a page of an article with their caption."""

_CAPTION = (
    "Success with 95 % intervals, and its change from the control in the trials that were finished under both. P values"
    " are corrected within their families; a change is detected if P is below 0.05 and its interval excludes 0."
)

_TABLE1 = "Misinterpretations as in Table 1 of Zenkri and Brock: mean rate per trial with its standard deviation."


def write_paper(found: Results, directory: Path) -> Path:
    """Write the files into the directory of a study, and return the directory that holds them."""
    from lockprobe.report.figures.drawing import render

    written, shown = dict[str, str | bytes](), list[str]()
    for name, figure in figures_of(parts_of(found)).items():
        made = section(f"Figure {name}", partial(figure.draw, found), lambda: None) if figure.applies(found) else None
        if made is None:
            continue
        written |= {f"{name}.pdf": render(made, "pdf"), f"{name}.png": render(made, "png")}
        said = figure.caption(found)
        text = " ".join(one.striptags() if isinstance(one, Markup) else one for one in (said.shown, said.computed))
        inside = rf"\includegraphics[width=\linewidth]{{{name}.pdf}}"
        shown.append(_float("figure" + "*" * bool(made.get_figwidth() > _COLUMN), inside, text))
    tables = {"results": results_tex(found)}
    if table := texts(cells_of(TABLE1, found)):
        tables["table1"] = _tabular(table, _TABLE1)
    inputs = [rf"\input{{{name}}}" for name in tables]
    results = "\n\n".join([tex_text(found.answer), *shown, *inputs, ""])
    templates = files("lockprobe.report") / "templates"
    for name, kept, value in (("references.bib", "VERSION", found.lockprobe), ("example.tex", "RESULTS", results)):
        written[name] = (templates / name).read_text(encoding="utf-8").replace(kept, value)
    written |= {f"{name}.tex": content for name, content in tables.items()} | {"methods.tex": methods_tex(found)}
    make_directory(directory / PAPER)
    for name, content in written.items():
        write_file(directory / PAPER / name, content)
    return directory / PAPER


def _float(kind: str, inside: str, caption: str) -> str:
    """A figure or a table of TeX."""
    lines = (rf"\begin{{{kind}}}", r"\centering", inside, rf"\caption{{{tex_text(caption)}}}", rf"\end{{{kind}}}", "")
    return "\n".join(lines)


def _tabular(table: Sequence[Sequence[str]], caption: str) -> str:
    """A table of TeX, whose first row has the names of columns; a long one is several floats of one number."""
    head, *rows = (" & ".join(map(tex_text, row)) for row in table)
    begin = [rf"\begin{{tabular}}{{{'l' * len(table[0])}}}", r"\toprule", rf"{head} \\", r"\midrule"]
    parts = [rows[i : i + _LINES] for i in range(0, len(rows), _LINES)] or [rows]
    floats = [
        "\n".join([*begin, *(rf"{{}}{row} \\" for row in part), r"\bottomrule", r"\end{tabular}"]) for part in parts
    ]
    return "\\addtocounter{table}{-1}\n".join(_float("table*", one, caption) for one in floats)


def results_tex(found: Results) -> str:
    """A table of every agent under every condition: trials, success, its change from the control, and P."""
    where = "condition" if found.beside_flips else "flip rate"
    words: Mapping[str, str] = {one.name: condition_in_words(one) for one in found.design.conditions}
    changes = {at: row for at, row in changes_from_control(found).items() if row.value is not None}
    table = [["agent", where, "trials", "solved", "change, points", "P"]]
    for cell in found.cells:
        if (success := cell.get("success")) and success.value is not None:
            at = words[cell.condition] if found.beside_flips or cell.p is None else f"{cell.p:g}"
            change = changes.get((cell.agent, cell.condition))
            said = [entry_text(change), p_cell(change.p_value)] if change else ["", ""]
            table.append([cell.label, at, str(success.n), entry_text(success), *said])
    return _tabular(table, _CAPTION)


_LABELS: Mapping[str, str] = {
    "trial": "Joints had neutral labels, drawn anew in every trial.",
    "study": "Joints had neutral labels, drawn once for the study.",
}
"""How ``shuffle`` names joints; in panel order otherwise."""

_FACTS = (
    *("model", "answered by", "host", "sha256", "runtime", "decoding", "temperature", "top_p"),
    *("effort", "max_tokens", "schema", "images", "detail", "repairs", "prompt"),
)
"""Facts on record of a model that the paragraph says, in this order."""

_WORDS: Mapping[str, str] = {
    "correction": "reports in two statements",
    "delay": "late reports",
    "drop": "missing reports",
    "phantom": "reports of a false position elsewhere",
    "distract": "an irrelevant sentence with the report",
    "nudge": "a sentence against repetition",
    "remark": "a sentence without information",
    "warn": "a warning of false reports",
    "history": "a shortened memory",
    "tremble": "attempts at other joints",
}
"""An intervention -> what it is in an article."""

_DETECTED = r"a change counts as detected if \emph{P} is below 0.05 and its 95\,\% interval excludes 0."


def spec_in_words(spec: str) -> str:
    """A spec as an article can say it.

    >>> spec_in_words("flip?p=0.4&others=kept"), spec_in_words("drop?p=0.3"), spec_in_words("history?last=3")
    ('false reports that stay at rate 0.4', 'missing reports at rate 0.3', 'a shortened memory (last 3)')
    """
    parsed = Spec.parse(spec, "condition")
    rate = f" at rate {parsed.options['p']}" if "p" in parsed.options else ""
    others = parsed.without(["p"]).options.items()
    if parsed.full_name == "flip":
        return f"{false_reports('&'.join(f'{name}={value}' for name, value in others))}{rate}"
    options = ", ".join(f"{name.replace('_', ' ')} {value}" for name, value in others)
    return f"{_WORDS.get(parsed.full_name, parsed.full_name)}{rate}{f' ({options})' * bool(options)}"


def condition_in_words(one: Condition, *, explained: bool = False) -> str:
    """What acts under a condition, or the experimenter's name for it, ``explained`` by what acts."""
    acts = " and ".join(map(spec_in_words, one.specs)) or "truth"
    named = one.specs and not set("?+") & set(one.name) and one.name not in one.specs
    return acts if not named else f"{one.name} ({acts.replace(' (', ', ').replace(')', '')})" if explained else one.name


def methods_tex(found: Results) -> str:
    """Puzzle, agents, models, design, what is left out, intervals and tests, and the hashes."""
    said = (sentence for part in (_system, _agents, _design, _tested) for sentence in part(found) if sentence)
    hashes = (rf"\texttt{{{tex_text(one)}}}" for one in (found.settings_hash, found.results_hash))
    kept = "The settings of the study have the hash {}, its records {}.".format(*hashes)
    return " ".join((*said, kept)) + "\n"


def _system(found: Results) -> Iterator[str]:
    boxes, study = found.boxes, found.study
    yield (
        rf"We used Lockprobe {tex_text(found.lockprobe)}~\cite{{lockprobe}}, which implements the system of Zenkri and "
        r"Brock~\cite{zenkri-brock}."
    )
    yield f"An agent has {count(int(study.get('max_steps', 0)), 'step')} to open a box whose joints lock each other."
    names = [_name(str(box.get("name", ""))) for box in boxes]
    sizes = sorted({len(box.get("joints", ())) for box in boxes})
    of = f"with {' to '.join(map(str, sizes))} joint{'s' * (sizes[-1] != 1)}"
    yield f"The box was {names[0]}, {of}." if len(boxes) == 1 else f"The {len(boxes)} boxes were {listed(names)}, {of}."
    if any(box.get("name") == "chain-4" for box in boxes):
        yield "The interlock of their box is not public; ours is a reconstruction."
    shown = listed(list(dict.fromkeys(spoken(one.modality) for one in found.design.conditions)), "or")
    plant = str(study.get("plant", "symbolic"))
    on = "" if plant == "symbolic" else f", on the plant {spec_in_words(plant)}"
    yield f"After each action it was shown as {tex_text(f'{shown}{on}')}."
    yield _LABELS.get(str(study.get("shuffle")), "")


def _agents(found: Results) -> Iterator[str]:
    """Who played, what is on record of each language model, and what people saw."""
    agents = [str(agent) for agent in found.study.get("agents", ()) if agent != PEOPLE]
    many = found.get("people", agent=PEOPLE, condition="", modality="")
    by = [count(int(many.value or 0), "participant") if many else "people"] * (PEOPLE in found.study.get("agents", ()))
    by += [f"{count(len(agents), 'agent')} ({listed(list(map(_name, agents)))})"] if agents else []
    yield f"The box was played by {listed(by)}."
    said = [f"{_name(one)} reconstructs their strategy, whose algorithm is not public" for one in found.reconstructed]
    played = {one.agent for one in found.design.players}
    others = [_name(agent) for agent in agents if agent in played and agent not in found.subjects]
    said += [f"{listed(others)} {'are baselines' if others[1:] else 'is a baseline'}"] if others else []
    if said:
        yield f"Of these, {'; '.join(said)}."
    for agent in agents:
        facts = found.facts_about(agent)
        if "model" in facts:
            known = [f"{one.replace('_', ' ')} {facts[one]}" for one in _FACTS if one in facts]
            yield f"{_name(agent)}: {tex_text(', '.join(known))}."
            for row in found.where("replies", agent=agent, of="asked again"):
                yield f"{row.count} of its {row.n} replies could not be used and were asked for again."
    facts, shown = found.facts_about(PEOPLE), {"True": "shown", "False": "not shown"}
    names = ("view", "history", "feedback")
    said = [f"{name} {tex_text(shown.get(facts[name], facts[name]))}" for name in names if name in facts]
    yield f"Participants: {', '.join(said)}." if said else ""


def _design(found: Results) -> Iterator[str]:
    study, conditions = found.study, found.design.conditions
    only = set(study.get("strategy_conditions", ()))
    every = [one for one in conditions if one.name not in only]
    further = [one for one in conditions if one.name in only]
    ways = len({one.modality for one in conditions})
    each = ", for each way of showing the box" if ways > 1 and not len(conditions) % ways else ""
    also = f"; strategies also under {len(further)} further: {_conditions(further)}" if further else ""
    yield f"There were {count(len(every), 'condition')}: {_conditions(every)}{each}{also}."
    yield tex_text(found.fact("readings", "what"))
    more = f" ({study['strategy_trials']} of strategies)" if study.get("strategy_trials") else ""
    yield (
        f"The design has {count(int(study.get('repetitions', 0)), 'repetition')} of "
        f"{count(int(study.get('trials', 0)), 'trial')}{more} for each agent and condition. Trials of the same number "
        f"share their random numbers across conditions and agents (seed {study.get('seed')})."
    )
    broken = found.get("left_out", of="ended as error")
    left = f"; {count(int(broken.value), 'trial')} ended as an error" if broken is not None and broken.value else ""
    yield f"{found.progress.finished} of {found.progress.planned} planned trials were finished{left}."


def _conditions(conditions: Iterable[Condition]) -> str:
    """All conditions in words: the rates of one intervention together, each way to show the box once."""
    rates: dict[str, list[str]] = {}
    for one in conditions:
        words, at, rate = condition_in_words(one, explained=True).rpartition(" at rate ")
        own = rates.setdefault(words if at else "the truth" if rate == "truth" else rate, [])
        own += [rate] if at and rate not in own else []
    said = [f"{of} at rate{'s' * (len(own) > 1)} {listed(own)}" if own else of for of, own in rates.items()]
    return tex_text(listed(said))


def _tested(found: Results) -> Iterator[str]:
    """What intervals are, by which tests changes were judged, and what that is at every look."""
    rows = [row for row in found.against_control() if row.p_value is not None]
    tests = [*dict.fromkeys(row.test.removesuffix(", and interval") for row in rows if row.test)]
    most = max((row.corrected_for for row in rows), default=1)
    corrected = f", corrected for at most {most} comparisons of a family" if most > 1 else ""
    if found.progress.every_look:
        yield tex_text(found.fact("overview", "every_look"))
        yield r"Intervals of shares are 95\,\% confidence sequences~\cite{robbins1970}."
        if any(E_PROCESS in row.test for row in rows):
            closed = r" by closed testing~\cite{vovk-wang2021}" if most > 1 else ""
            yield (
                r"Those of changes are confidence sequences by betting~\cite{waudby-smith-ramdas2024}, over blocks of "
                r"one trial under every condition, in the order of the plan. \emph{P} is 1 divided by the largest "
                rf"wealth of bets against no change~\cite{{ville1939}}{corrected}{closed}; {_DETECTED}"
            )
        return
    said = tex_text(f"Intervals of shares are {interval_kind(found)}.")
    yield said.replace("Wilson intervals", r"Wilson intervals~\cite{wilson1927}")
    if tests:
        by = listed([tex_text({"McNemar": "McNemar's exact test"}.get(one, one)) for one in tests])
        yield f"Changes of success were tested by {by}{corrected}; {_DETECTED}"


def _name(agent: str) -> str:
    """A name that may be broken after its parts."""
    return tex_text(agent).replace(":", r":\allowbreak{}").replace("/", r"/\allowbreak{}")

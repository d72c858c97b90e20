"""Everything that a report writes: numbers, figures, tables, and ``report.html``, whole in one file.

What comes from agents, models and box files is untrusted: the page is rendered with autoescaping and runs no
script. Clock readings stand in a box of their own and nowhere else.
"""

from __future__ import annotations

import base64
import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

from lockprobe.analysis.behaviour import has_loop, loop_coverage
from lockprobe.analysis.finding import beside, finding, loop_finding
from lockprobe.analysis.inference.association import LENGTH_CAVEAT
from lockprobe.analysis.loops import cover
from lockprobe.analysis.misinterpretation import claims
from lockprobe.analysis.summary import AgentSummary, StudySummary
from lockprobe.record import Outcome, Step, Trial
from lockprobe.report.results import LoadedStudy, numbers, read
from lockprobe.report.tables import as_csv, as_tex, condition_table, misinterpretation_table
from lockprobe.studies.journal import read_timings

__all__ = ["write_report"]

Pictures = dict[str, dict[str, bytes]]

_LENGTH_NOTE = (
    "Solved trials are shorter and hold fewer loops by chance alone:\n"
    "a negative r is expected even if loops do no harm."
)
"""The caveat in a length that fits below a figure."""


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """One step as the page shows it."""

    step: Step
    claimed: Outcome | None
    misinterpreted: bool
    again: bool
    loop: str


@dataclass(frozen=True, slots=True, kw_only=True)
class _Example:
    """One trial as the page shows it."""

    why: str
    trial: Trial
    lines: tuple[_Line, ...]


def write_report(directory: Path | str, *, clock: Callable[[], datetime] = lambda: datetime.now(UTC)) -> Path:
    """Write ``results.json``, ``figures/``, ``tables/`` and ``report.html`` into a study directory.

    Every file is replaced in one step, the page last.

    Args:
        directory: The directory of a study.
        clock: The time that the page gives as its own.

    Returns:
        Where the page is.

    Raises:
        BadFile: If the directory is not that of a study.
    """
    directory = Path(directory)
    study = read(directory)
    content = numbers(study)
    _write(directory / "results.json", json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n")
    pictures = _pictures(study.summary)
    for name, forms in pictures.items():
        for form, picture in forms.items():
            _write(directory / "figures" / f"{name}.{form}", picture)
    tables = {"table1": misinterpretation_table(study.summary), "conditions": condition_table(study.summary)}
    for name, table in tables.items():
        _write(directory / "tables" / f"{name}.csv", as_csv(table))
        _write(directory / "tables" / f"{name}.tex", as_tex(table))
    page = directory / "report.html"
    _write(page, _html(study, content, pictures, _speeds(directory, study.trials), clock()))
    return page


def _write(path: Path, content: str | bytes) -> None:
    path.parent.mkdir(exist_ok=True)
    draft = path.with_name(f".{path.name}.draft")
    draft.write_bytes(content.encode() if isinstance(content, str) else content)
    draft.replace(path)


def _pictures(summary: StudySummary) -> Pictures:
    """The figures by name, each as PNG and SVG."""
    if not any(condition.success.n for condition in summary.conditions):
        return {}
    from lockprobe import figures

    subjects = summary.subjects
    drawn = {
        "fig4-success-by-p": figures.single(figures.draw_success_by_p, summary),
        "fig3-success-curves": figures.single(figures.draw_success_curves, summary),
        "fig3-success-curves-by-p": figures.panels(figures.draw_success_curves_by_p, subjects),
        "fig5a-loops-against-success": figures.panels(figures.draw_loops_against_success, subjects, _LENGTH_NOTE),
        "fig5b-loops-by-p": figures.panels(figures.draw_loops_by_p, subjects),
    }
    return {
        name: {"png": figures.render(figure, "png"), "svg": figures.render(figure, "svg")}
        for name, figure in drawn.items()
    }


def _html(
    study: LoadedStudy, content: dict[str, Any], pictures: Pictures, speeds: list[dict[str, Any]], now: datetime
) -> str:
    import jinja2

    environment = jinja2.Environment(
        autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    template = files("lockprobe.report").joinpath("report.html.jinja").read_text("utf-8")
    return environment.from_string(template).render(
        study=study,
        settings=study.settings,
        summary=study.summary,
        findings=[
            (finding(agent), loop_finding(agent)) for agent in sorted(study.summary.subjects, key=lambda a: a.blind)
        ],
        beside=beside(study.summary),
        images={
            name: "data:image/svg+xml;base64," + base64.b64encode(forms["svg"]).decode()
            for name, forms in pictures.items()
        },
        conditions=condition_table(study.summary),
        misread=misinterpretation_table(study.summary),
        paper=content["paper"],
        tests=content["tests"],
        agents=_facts(study.trials),
        examples=_examples(study.summary, study.trials),
        errors=_errors(study.trials),
        speeds=speeds,
        caveat=LENGTH_CAVEAT,
        version=version("lockprobe"),
        now=now.strftime("%Y-%m-%d %H:%M %Z").strip(),
    )


def _facts(trials: Sequence[Trial]) -> dict[str, dict[str, str]]:
    """What every agent was; where trials of one agent differ, all values are named."""
    found: dict[str, dict[str, dict[str, None]]] = {}
    for trial in trials:
        for name, value in trial.facts.items():
            found.setdefault(trial.agent, {}).setdefault(name, {})[str(value)] = None
    return {agent: {name: "; ".join(values) for name, values in facts.items()} for agent, facts in found.items()}


def _errors(trials: Sequence[Trial]) -> list[tuple[str, str, int, str, bool]]:
    """Agent, boundary, count, the first message, and whether those trials are owed again."""
    broken = [(trial, trial.error) for trial in trials if trial.error is not None]
    counts = Counter((trial.agent, str(error.boundary)) for trial, error in broken)
    first = {(trial.agent, str(error.boundary)): (error.message, trial.owed_again) for trial, error in reversed(broken)}
    return [(*name, count, *first[name]) for name, count in sorted(counts.items())]


def _speeds(directory: Path, trials: Sequence[Trial]) -> list[dict[str, Any]]:
    """Steps per minute of playing time by agent, from the clock readings."""
    agents = {trial.key: trial.agent for trial in trials}
    steps: Counter[str] = Counter()
    seconds: dict[str, float] = {}
    for timing in read_timings(directory):
        if (agent := agents.get(timing.key)) is not None:
            steps[agent] += timing.steps
            seconds[agent] = seconds.get(agent, 0.0) + timing.seconds
    return [
        {
            "agent": agent,
            "steps": steps[agent],
            "seconds": spent,
            "per_minute": 60 * steps[agent] / spent if spent else None,
        }
        for agent, spent in seconds.items()
    ]


def _examples(summary: StudySummary, trials: Sequence[Trial]) -> list[_Example]:
    """A solved trial, the trial that loops most, and one with most misinterpretations, of the first subject."""
    if not summary.subjects:
        return []
    agent = summary.subjects[0]
    own = [t for t in trials if (t.agent, t.modality) == (agent.agent, agent.modality) and t.ending != "error"]
    solved = [trial for trial in own if trial.solved]
    looping = sorted((trial for trial in own if has_loop(trial)), key=loop_coverage, reverse=True)
    misread = {trial.key: sum(claim.misinterpreted for claim in claims(trial)) for trial in own}
    wrong = sorted((trial for trial in own if misread[trial.key]), key=lambda t: misread[t.key], reverse=True)
    chosen: dict[str, _Example] = {}
    for why, candidates in (
        ("Solved", _farthest_first(solved, agent)),
        ("Looping: the largest share of steps in action loops", looping),
        ("Most misinterpretations", wrong),
    ):
        for trial in (candidate for candidate in candidates[:1] if candidate.key not in chosen):
            chosen[trial.key] = _Example(why=why, trial=trial, lines=_lines(trial))
    return list(chosen.values())


def _farthest_first(trials: list[Trial], agent: AgentSummary) -> list[Trial]:
    """Trials of the condition that stands out, before the others."""
    p = agent.contrast.other.p if agent.contrast else 0.0
    return sorted(trials, key=lambda trial: trial.p != p)


def _lines(trial: Trial) -> tuple[_Line, ...]:
    said = {claim.step: claim for claim in claims(trial)}
    found = cover(trial.actions)
    letters: dict[tuple[str, ...], str] = {}
    loops: dict[int, str] = {}
    for start, length in found.intervals:
        word = trial.actions[start : start + length]
        letter = letters.setdefault(word, "abcdefghijklmnopqrstuvwxyz"[len(letters) % 26])
        loops |= dict.fromkeys(range(start, start + length), letter)
    tried: set[tuple[str, str]] = set()
    lines = []
    for i, step in enumerate(trial.steps):
        claim = said.get(step.step)
        lines.append(
            _Line(
                step=step,
                claimed=claim.claimed if claim else None,
                misinterpreted=claim is not None and claim.misinterpreted,
                again=(step.state, step.joint) in tried,
                loop=loops.get(i, ""),
            )
        )
        tried.add((step.state, step.joint))
    return tuple(lines)

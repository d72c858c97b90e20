"""Trials that broke: how many at which boundary, and what was said first."""

from __future__ import annotations

from collections.abc import Iterator

from lockprobe.foundation.spec import Spec
from lockprobe.report.rows import Estimate, Fact, Results, Row
from lockprobe.report.section import Part, Section, Template
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.trial.record import Trial


def _rows(numbers: StudyNumbers) -> Iterator[Row]:
    """By agent and boundary, with the first message, and whether the first of them will be replayed."""
    broken: dict[tuple[str, str], list[Trial]] = {}
    for trial in numbers.opened.trials:
        if trial.error is not None:
            broken.setdefault((trial.group, str(trial.error.boundary)), []).append(trial)
    for (agent, boundary), trials in sorted(broken.items()):
        yield Estimate(quantity="broken", agent=agent, of=boundary, value=len(trials), unit="trials")
        first = trials[0]
        about = _about(agent, boundary)
        yield Fact(about=about, name="first message", text=_message(first))
        yield Fact(about=about, name="will be replayed", text="yes" if first.owed_again else "no")


def _message(trial: Trial) -> str:
    """What was said; of an agent that has a name without its spec, which may hold a path."""
    said = "" if trial.error is None else trial.error.message
    for written in (trial.spec, Spec.parse(trial.spec).name.removeprefix("gguf:")) if trial.called else ():
        said = said.replace(written, trial.called) if written else said
    return said


def _about(agent: str, boundary: str) -> str:
    return f"{agent}, broken at {boundary}"


def _show(found: Results) -> Iterator[Part]:
    rows = [(row, found.facts_about(_about(row.agent, row.of))) for row in found.where("broken", condition="")]
    trials = sum(int(row.value or 0) for row, _ in rows)
    if rows:
        said = f"{trials} trials; excluded from all other numbers."
        yield Part("Trials that broke", said, [Template("broken", {"rows": rows})])


SECTIONS = (Section(name="broken", title="Trials that broke", rows=_rows, show=_show),)

"""Trials, step by step: an explorer of all of them, and examples as tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from lockprobe.report.examples import examples, exhibit
from lockprobe.report.rows import Exhibit, Results
from lockprobe.report.sample_pictures import pictures_shown
from lockprobe.report.section import Block, Detail, Heading, Part, Section, Steps, Template, Text
from lockprobe.report.study_numbers import StudyNumbers
from lockprobe.trial.record import Trial

_CONDITIONS = 6
"""Conditions beside flip rates of which a trial is shown."""


def _rows(numbers: StudyNumbers) -> Iterator[Exhibit]:
    yield from examples(numbers.flips, numbers.opened.flip_trials)
    if numbers.others and numbers.others.subjects:
        own = [trial for trial in numbers.opened.trials if trial.group == numbers.others.subjects[0]]
        yield from _of_conditions(own, known=numbers.study.flip_labels)


def _of_conditions(trials: Sequence[Trial], known: frozenset[str]) -> Iterator[Exhibit]:
    """The first ended trial under each of the first conditions, except those that are known."""
    first: dict[str, Trial] = {}
    for trial in trials:
        if trial.ending != "error" and trial.condition not in known:
            first.setdefault(trial.condition, trial)
    for label, trial in list(first.items())[:_CONDITIONS]:
        yield exhibit("trials", label, trial)


def _show(found: Results) -> Iterator[Part]:
    shown = [one for one in found.exhibits if one.section == "trials"]
    tables: list[Block] = [block for one in shown for block in (Heading(one.why), Steps(one))]
    with_pictures = " With pictures, “told” is what they show." if pictures_shown(found) else ""
    note = (
        "Equal letters in the column “loop” mark copies of the same action loop; “again”: this joint was tried before "
        f"in this true configuration.{with_pictures}"
    )
    last = Text(note, style="note") if shown else Text("No trial of the first agent was solved, looped or misread.")
    several = len(found.design.conditions) > 1
    heading = "One trial under two conditions" if several else "One trial, step by step"
    yield Part(heading, "", [Template("explorer"), Detail("Examples of trials, as tables", [*tables, last])])


SECTIONS = (Section(name="trials", title="Trials", rows=_rows, show=_show),)

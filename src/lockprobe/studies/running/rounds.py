"""In which order the owed trials of an agent are played: look by look."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace

from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.trial_rows import OnRecord
from lockprobe.studies.stopping import due
from lockprobe.studies.study import Study
from lockprobe.trial.plan import Plan


def next_plans(study: Study, journal: Journal) -> Callable[[str], Iterable[Plan]]:
    """Function from an agent to its plans: all, or those before the next look of a study that may stop there.

    All agents of the directory are judged together, those too that are not run now.
    """
    if study.until is None:
        return study.plans
    whole = replace(read_study(journal.directory), shard=study.shard)
    return lambda agent: due(whole, agent, [one for one in journal.trials.values() if _is_planned(whole, one)])


def _is_planned(study: Study, trial: OnRecord) -> bool:
    """Whether a trial lies within a study; a directory may hold records beyond it."""
    inside = 1 <= trial.repetition <= study.repetitions and 1 <= trial.trial <= study.trials_of(trial.spec)
    return inside and trial.spec in study.agents and any(one.label == trial.condition for one in study.conditions)


def owed_plans(plans: Iterable[Plan], journal: Journal) -> list[Plan]:
    """The plans that a journal owes; those that were begun first, so that a small budget ends them."""
    owed = [plan for plan in plans if journal.owes(plan.key)]
    return sorted(owed, key=lambda plan: not journal.calls.has_replies(plan.key))


def rounds(
    study: Study,
    first: list[Plan],
    more: Callable[[], Iterable[Plan]],
    journal: Journal,
    tell: Callable[[int], None] = lambda owed: None,
) -> Iterator[list[Plan]]:
    """Yield the plans that are owed; of a study that stops when it is decided, also those after each look.

    Before a look all trials have to end. So those that broke are played again, as long as others end meanwhile.

    Args:
        study: The study.
        first: The plans that are owed at first.
        more: The plans of the agent, asked for after each look.
        journal: The journal of the study.
        tell: Called after each look with the number of plans that follow.
    """
    now = first
    while now:
        yield now
        ended = any(not journal.owes(plan.key) for plan in now)
        now = owed_plans(more(), journal) if study.until and ended else []
        if now:
            tell(len(now))

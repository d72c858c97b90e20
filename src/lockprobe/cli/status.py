"""``lockprobe status``: progress, errors and cost of a study, during a run or afterwards."""

from __future__ import annotations

import json as json_
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from lockprobe.agents.reply import TIDIED
from lockprobe.cli import options
from lockprobe.cli.command import Directory
from lockprobe.cli.decisions import decided
from lockprobe.cli.format_cost import money, share, spent_facts
from lockprobe.cli.result import read_result
from lockprobe.cli.study_lines import foreign_in_words, invalid_in_words
from lockprobe.cli.tally import in_boundaries
from lockprobe.foundation.clock import time_said
from lockprobe.foundation.formatting import count
from lockprobe.foundation.terminal_text import printable
from lockprobe.people.diary import read_diaries
from lockprobe.people.journey import flow_of
from lockprobe.people.withdrawal import withdrawn
from lockprobe.studies.branch import FORKS, read_forks
from lockprobe.studies.costs.call_log import LoggedCall, logged_calls
from lockprobe.studies.costs.spending import Ledger, Spending, total
from lockprobe.studies.records.counted import Counted, idle_conditions, invalid_conditions
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import read_stored
from lockprobe.studies.records.record_index import RecordIndex
from lockprobe.studies.records.results_hash import stored_hash
from lockprobe.studies.records.store import read
from lockprobe.studies.stopping import planned_now
from lockprobe.studies.study import Study
from lockprobe.trial.asked_again import asked_again
from lockprobe.trial.model_call import BROKEN_OFF, Call
from lockprobe.trial.record import Trial


def status(directory: Directory, json: options.AsJson = False) -> None:
    """Show the progress, errors by boundary, time and cost of a study."""
    study = read_study(directory)
    logged, logged_of_forks = logged_calls(directory), logged_calls(directory / FORKS)
    with read(directory) as store:
        index = RecordIndex(store, study)
        facts: dict[str, Any] = {
            "settings_hash": study.settings_hash,
            "results_hash": stored_hash(store, study, index),
            **_in_progress(logged, index),
        }
        trials = study.own_trials(read_stored(store, study)[0]) if study.until else []
    everything = index.counted(own=False)
    of_forks = bool(everything) and all(one.trial.fork is not None for one in everything)
    records = everything if of_forks else index.counted()
    facts |= {
        "of_forks": of_forks,
        **_played(study, records, trials, of_forks=of_forks),
        "not_asked_for": sum(one.number for one in everything) - sum(one.number for one in records),
        "steps": int(index.steps),
        "pictures": len({name for one in records for name in one.trial.picture_names}),
        "seconds_playing": round(index.seconds, 1),
        "steps_per_minute": round(60 * index.steps / index.seconds, 1) if index.seconds else None,
        "forks": sum(not fork.owed_again for fork in read_forks(directory)),
        "foreign": index.left_out.foreign,
        "first_foreign": index.left_out.first_foreign,
    }
    invalid = [] if of_forks else invalid_conditions(study, records)
    unchanged = [] if of_forks else idle_conditions(study, records)
    said: list[tuple[str, str]] = []
    if study.until and not of_forks:
        lines, facts["decided"] = decided(study, trials)
        facts["until"] = str(study.until)
        said = [("decided" * (not i), line.strip()) for i, line in enumerate(lines)]
    said += [("invalid", invalid_in_words(invalid))] if invalid else []
    said += [("idle", f"{cell}: no intervention has changed anything so far") for cell in unchanged]
    report = None if of_forks else read_result(directory)
    flow = flow_of(study, read_diaries(directory), withdrawn(directory))
    people = {} if flow is None else {"joined": flow.consented, "finished": flow.finished, "withdrawn": flow.withdrawn}
    facts |= {
        "without_valid_trial": [one.condition for one in invalid],
        "changed_nothing": unchanged,
        "time": time_said(),
        "reported": None if report is None else report.progress.finished,
        "participants": people,
    }
    ledger, forks = _ledger(study, logged, everything), _ledger(study, logged_of_forks)
    if json:
        print(json_.dumps(facts | _spent(study, ledger, forks)))
        return
    _print_named([*_lines(directory, facts), *said])
    if ledger.by_agent or forks.by_agent:
        print()
        _print_columns(_table(study, ledger, forks))
        print()
        _print_named(_about_calls(_both(ledger, forks), [*ledger.by_agent.values(), *forks.by_agent.values()]))
    if foreign := foreign_in_words(index.left_out):
        _print_named([("left out", foreign)])


def _in_progress(logged: Sequence[LoggedCall], index: RecordIndex) -> dict[str, object]:
    """The trials that were begun and are owed, the replies that are kept for them, and calls without an answer."""
    waiting, begun = [one.asked for one in logged if one.answer is None and one.asked is not None], Counter[str]()
    for call in (one.answer for one in logged if one.answer is not None):
        begun.update([call.key] if call.reply is not None and index.owes(call.key) else [])
        if call.owed_anew:
            del begun[call.key]
    return {
        "in_progress": len({*begun, *(call.key for call in waiting if index.owes(call.key))}),
        "in_progress_calls": begun.total(),
        "unanswered_calls": len(waiting),
    }


def _played(study: Study, records: Sequence[Counted], trials: Sequence[Trial], *, of_forks: bool) -> dict[str, object]:
    """What is planned, played, owed and broken. ``trials`` are those of a study that stops when it is decided.

    Forks have no plan, and people's trials are counted apart from the others.
    """
    run, people = ([one for one in records if bool(one.trial.player) == of] for of in (False, True))
    errors = [(one.trial.error, one.number) for one in records if one.trial.error is not None]
    played, again = sum(one.number for one in run), sum(one.number for one in run if one.trial.owed_again)
    by_people = 0 if of_forks else study.places_filled(one.trial for one in people)
    planned = sum(one.number for one in records) if of_forks else planned_now(study, trials)
    finished, invited = played - again + by_people, 0 if of_forks else study.invited
    steps = [step for one in run for step in one.trial.steps]
    tidied = Counter(TIDIED.get(what, what) for step in steps for what in step.decision.tidied)  # type: ignore[call-overload]
    return {
        "study": study.name,
        "trials": planned - invited,
        "done": played - again,
        "owed": planned - invited - played + again,
        "people_trials": study.invited,
        "people_done": by_people,
        "people_solved": sum(one.trial.solved for one in people),
        "people": len({one.trial.agent for one in people}),
        "planned": planned,
        "finished": finished,
        "partial": finished < planned,
        "solved": sum(one.number for one in run if one.trial.solved),
        "errors": dict(sum((Counter({error.boundary: number}) for error, number in errors), Counter[str]())),
        "first_errors": {error.boundary: error.message for error, _ in reversed(errors)},
        "decisions": sum(one.steps for one in run),
        "asked_again": {
            agent: {"replies": replies, "asked_again": again}
            for agent, (again, replies) in asked_again(one.trial for one in run).items()
        },
        "tidied": dict(tidied.most_common()),
        "tidied_decisions": sum(bool(step.decision.tidied) for step in steps),
    }


def _ledger(study: Study, logged: Sequence[LoggedCall], records: Sequence[Counted] = ()) -> Ledger:
    """The cost of all calls, and of what decisions of trials without calls on disk used, which were imported.

    Forks have the decisions of their trial on record, which it paid for.
    """
    waiting = [replace(one.asked, error=BROKEN_OFF) for one in logged if one.answer is None and one.asked is not None]
    answered = [one.answer for one in logged if one.answer is not None]
    known, used = {call.key for call in answered}, list[Call]()
    for trial in (one.trial for one in records if one.trial.key not in known and one.trial.fork is None):
        asked = [(step.step, step.decision.usage, step.decision.served) for step in trial.steps]
        if trial.error is not None:
            asked.append((trial.error.step, trial.error.usage, ""))
        for step, usage, served in asked:
            if usage is not None:
                call = Call(key=trial.key, step=step, turn=1, request="", reply="", usage=usage, served=served)
                used.append(replace(call, agent=trial.agent))
    return Ledger(study, (*waiting, *used, *answered))


def _both(ledger: Ledger, forks: Ledger) -> Spending:
    """The cost of a study and its forks."""
    return total([*ledger.by_agent.values(), *forks.by_agent.values()])


def _spent(study: Study, ledger: Ledger, forks: Ledger) -> dict[str, object]:
    agents = {study.label_of(agent): spent_facts(spent) for agent, spent in ledger.by_agent.items()}
    dates = {str(found["price_date"]) for found in agents.values() if found["price_date"]}
    return spent_facts(ledger.total) | {
        "price_date": min(dates, default=None),
        "agents": agents,
        "spent_on_forks": spent_facts(forks.total),
        "spent_with_forks": spent_facts(_both(ledger, forks)),
    }


def _print_named(lines: Iterable[tuple[str, str]]) -> None:
    for name, said in lines:
        print(printable(f"{name:<12}{said}"))


def _print_columns(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = (f"{cell:>{width}}" for cell, width in zip(others, widths[1:], strict=True))
        print(printable("  ".join((f"{first:<{widths[0]}}", *cells))))


def _lines(directory: Path, facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Of every fact its name, empty where it goes on, and what is said."""
    yield "study", f"{facts['study']} in {directory}, at {facts['time']}"
    extra = f", {facts['not_asked_for']} of other settings" if facts["not_asked_for"] else ""
    if facts["of_forks"]:
        yield "forks", f"{facts['done']} done, {facts['owed']} owed, {facts['solved']} solved"
    elif facts["trials"] or not facts["people_trials"]:
        done = f"{facts['done']} of {facts['trials']} done, {facts['owed']} owed, {facts['solved']} solved"
        yield "trials", f"{done}{extra}"
    if facts["people_trials"]:
        who = f" by {facts['people']}" if facts["people"] else ""
        played = f"{facts['people_done']} of {facts['people_trials']} played{who}, {facts['people_solved']} solved"
        yield "people", f"{played}{extra if not facts['trials'] else ''} (lockprobe serve {directory})"
    if people := facts["participants"]:
        joined = f"{count(people['joined'], 'person', 'people')} joined"
        yield "", f"{joined}, {people['finished']} finished, {people['withdrawn']} withdrew"
    if facts["forks"]:
        yield "forks", f"{facts['forks']} done (lockprobe branch {directory})"
    if facts["in_progress"]:
        kept = f"{facts['in_progress_calls']} replies kept for them"
        yield "open", f"{count(facts['in_progress'], 'trial')} unfinished, {kept}"
    if facts["unanswered_calls"]:
        yield "", f"{count(facts['unanswered_calls'], 'call')} in progress, or lost with a killed run"
    yield from _played_lines(directory, facts)


def _played_lines(directory: Path, facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """How long it took, what broke, what was asked again or tidied, and the hashes."""
    yield "steps", f"{facts['steps']} in {facts['seconds_playing']} s of playing, summed over parallel trials"
    if facts["reported"] is not None:
        behind = facts["finished"] - facts["reported"]
        renew = f", {behind} behind; lockprobe report {directory} makes it anew" if behind else ""
        yield "report", f"of {facts['reported']} of {facts['planned']} trials{renew}"
    if facts["pictures"]:
        yield "pictures", f"{facts['pictures']}"
    yield "errors", in_boundaries(facts["errors"]) or "none"
    for boundary, message in sorted(facts["first_errors"].items()):
        yield "", f"first at {boundary}: {' '.join(message.split())[:200]}"
    for i, (agent, of) in enumerate(facts["asked_again"].items()):
        counts = f"{of['asked_again']:,} of {of['replies']:,} replies of {agent}"
        yield "" if i else "replies", f"{counts} could not be used and were asked for again"
    if facts["tidied_decisions"]:
        what = ", ".join(f"{what} {times}" for what, times in facts["tidied"].items())
        yield "tidied", f"{facts['tidied_decisions']} of {facts['decisions']} replies before they were read: {what}"
    yield "settings", f"hash {facts['settings_hash']} (lockprobe verify {directory} --settings HASH)"
    yield "results", f"hash {facts['results_hash']} (lockprobe verify {directory} --results HASH)"


def _table(study: Study, ledger: Ledger, forks: Ledger) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = [
        ("calls of", "replies", "failed", "broken off", "retries", "tokens in", "cached", "out", "reasoning", "cost")
    ]
    parts = [(study.label_of(agent), spent) for agent, spent in ledger.by_agent.items()]
    if len(parts) > 1:
        parts.append(("all", ledger.total))
    if forks.by_agent:
        parts += [("forks", forks.total), ("study and forks", _both(ledger, forks))]
    for agent, spent in parts:
        usage = spent.usage
        numbers = (
            *(usage.calls, spent.failed, spent.broken_off, spent.retries),
            *(usage.input_tokens, usage.cached_tokens, usage.output_tokens, usage.reasoning_tokens),
        )
        cost = "not known" if spent.dollars is None else money(spent.dollars)
        rows.append((agent, *(f"{number:,}" for number in numbers), cost))
    return rows


def _about_calls(spent: Spending, parts: Sequence[Spending]) -> Iterator[tuple[str, str]]:
    read = spent.usage.input_tokens
    if read:
        repeated, cached = share(spent.repeated_tokens, read), share(spent.usage.cached_tokens, read) or 0
        before = "" if repeated is None else f"{repeated:.0%} of the tokens in had been sent before; "
        yield "prefixes", f"{before}{cached:.0%} came from a cache"
    if spent.broken_off or spent.uncounted or spent.unanswered:
        most = "" if spent.dollars_unknown is None else f", at most {money(spent.dollars_unknown)} more"
        lost = f"{count(spent.broken_off, 'call')} broken off" if spent.broken_off else ""
        bare = f"{count(spent.uncounted, 'reply', 'replies')} without a count" if spent.uncounted else ""
        vain = f"{count(spent.unanswered, 'attempt')} without an answer" if spent.unanswered else ""
        yield "uncounted", f"{', '.join(filter(None, (lost, bare, vain)))}: of unknown cost{most}"
    if spent.claimed:
        claim = "" if spent.claimed_dollars is None else f", {money(spent.claimed_dollars)}"
        more = f"{count(spent.claimed, 'call')}: the provider claims an impossible usage{claim}"
        yield "claimed", f"{more}; counted above as the possible maximum"
    if dates := {part.price.date for part in parts if part.price is not None}:
        yield "prices", f"of {', '.join(sorted(dates))}, US dollars"
    if spent.served:
        yield "served by", ", ".join(f"{name} ({number})" for name, number in spent.served)

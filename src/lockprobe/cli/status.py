"""``lockprobe status``: progress, errors and cost of a study, during a run or afterwards."""

from __future__ import annotations

import json as json_
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from lockprobe.cli.format_cost import money, share, spent_facts
from lockprobe.cli.progress import count, foreign_in_words, in_boundaries, invalid_in_words
from lockprobe.model_call import BROKEN_OFF, Call
from lockprobe.record import Trial
from lockprobe.studies.branch import read_forks
from lockprobe.studies.call_log import read_calls, unanswered
from lockprobe.studies.directory import added_agents
from lockprobe.studies.journal import read_timings
from lockprobe.studies.records import read_records
from lockprobe.studies.results_hash import results_hash
from lockprobe.studies.settings import read_study
from lockprobe.studies.spending import Ledger
from lockprobe.studies.study import Study
from lockprobe.studies.suites import is_suite, read_suite, suite_directories
from lockprobe.studies.valid_conditions import Invalid, invalid_conditions
from lockprobe.terminal_text import printable

__all__ = ["status"]

Directory = Annotated[Path, typer.Argument(metavar="DIR", help="The directory of a study or a suite.")]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object; for a suite one line per study.")]


def status(directory: Directory, json: AsJson = False) -> None:
    """Show the progress, errors by boundary, time and cost of a study, or of each study of a suite."""
    if not is_suite(directory):
        _status(directory, json=json)
        return
    suite = read_suite(directory)
    for i, name in enumerate(suite_directories(directory, suite)):
        if i and not json:
            print()
        _status(directory / name, json=json)


def _status(directory: Path, *, json: bool) -> None:
    study = read_study(directory)
    everything, left_out = read_records(directory)
    trials = study.own_trials(everything)
    over = {trial.key for trial in trials if not trial.owed_again}
    ledger, begun = Ledger(study), Counter[str]()
    waiting = unanswered(directory)
    for call in (*(replace(call, error=BROKEN_OFF) for call in waiting), *_decided(directory, everything)):
        ledger.add(call)
    for call in read_calls(directory):
        ledger.add(call)
        begun.update([call.key] if call.reply is not None and call.key not in over else [])
        if call.owed_anew:
            del begun[call.key]
    facts = _played(study, trials, everything) | _took(directory, trials)
    facts["forks"] = sum(not fork.owed_again for fork in read_forks(directory))
    facts |= {"foreign": left_out.foreign, "first_foreign": left_out.first_foreign, "added": added_agents(directory)}
    invalid = invalid_conditions(study, {trial.key: trial for trial in trials})
    facts |= {"without_valid_trial": [one.condition for one in invalid]}
    facts |= {"settings_hash": study.settings_hash, "results_hash": results_hash(study, trials)}
    facts["in_progress"] = len({*begun, *(call.key for call in waiting)} - over)
    facts |= {"in_progress_calls": begun.total(), "unanswered_calls": len(waiting)}
    if not json:
        _show([*_lines(directory, facts), *(("invalid", said) for said in _invalid(invalid))], ledger)
        if foreign := foreign_in_words(left_out):
            _print_named([("left out", foreign)])
        return
    agents = {agent: spent_facts(spent) for agent, spent in ledger.by_agent.items()}
    dates = {str(found["price_date"]) for found in agents.values() if found["price_date"]}
    spent = spent_facts(ledger.total) | {"price_date": min(dates, default=None), "agents": agents}
    print(json_.dumps(facts | spent))


def _played(study: Study, trials: Sequence[Trial], everything: Sequence[Trial]) -> dict[str, object]:
    run, people = ([trial for trial in trials if bool(trial.player) == of] for of in (False, True))
    again = sum(trial.owed_again for trial in run)
    first = {trial.error.boundary: trial.error.message for trial in reversed(trials) if trial.error}
    planned = study.size - study.invited
    return {
        "study": study.name,
        "trials": planned,
        "done": len(run) - again,
        "owed": planned - len(run) + again,
        "people_trials": study.invited,
        "people_done": sum(not trial.owed_again for trial in people),
        "people_solved": sum(trial.solved for trial in people),
        "people": len({trial.agent for trial in people}),
        "not_asked_for": len(everything) - len(trials),
        "solved": sum(trial.solved for trial in run),
        "errors": dict(Counter(trial.error.boundary for trial in trials if trial.error)),
        "first_errors": first,
    }


def _took(directory: Path, trials: Sequence[Trial]) -> dict[str, object]:
    timings = read_timings(directory)
    seconds, steps = sum(t.seconds for t in timings), sum(t.steps for t in timings)
    return {
        "steps": steps,
        "pictures": len({name for trial in trials for name in trial.picture_names}),
        "seconds_playing": round(seconds, 1),
        "steps_per_minute": round(60 * steps / seconds, 1) if seconds else None,
    }


def _decided(directory: Path, trials: Sequence[Trial]) -> Iterator[Call]:
    """The recorded usage of trials without calls on disk: imported, or from before calls were stored."""
    known = {call.key for call in read_calls(directory)}
    for trial in trials:
        if trial.key in known:
            continue
        asked = [(step.step, step.decision.usage, step.decision.served) for step in trial.steps]
        if trial.error is not None:
            asked.append((trial.error.step, trial.error.usage, ""))
        for step, usage, served in asked:
            if usage is not None:
                yield Call(key=trial.key, step=step, turn=1, request="", reply="", usage=usage, served=served)


def _invalid(found: Sequence[Invalid]) -> list[str]:
    return [invalid_in_words(found)] if found else []


def _show(lines: list[tuple[str, str]], ledger: Ledger) -> None:
    if ledger.by_agent:
        _print_named(lines)
        print()
        _print_columns(_table(ledger))
        print()
        lines = [*_about_calls(ledger)]
    _print_named(lines)


def _print_named(lines: Iterable[tuple[str, str]]) -> None:
    for name, said in lines:
        print(printable(f"{name:<12}{said}"))


def _print_columns(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for first, *others in rows:
        cells = (f"{cell:>{width}}" for cell, width in zip(others, widths[1:], strict=True))
        print(printable("  ".join((f"{first:<{widths[0]}}", *cells))))


def _lines(directory: Path, facts: Mapping[str, object]) -> Iterator[tuple[str, str]]:
    yield "study", f"{facts['study']} in {directory}"
    extra = f", {facts['not_asked_for']} of other settings" if facts["not_asked_for"] else ""
    if facts["trials"] or not facts["people_trials"]:
        done = f"{facts['done']} of {facts['trials']} done, {facts['owed']} owed, {facts['solved']} solved"
        yield "trials", f"{done}{extra}"
    if facts["people_trials"]:
        who = f" by {facts['people']}" if facts["people"] else ""
        played = f"{facts['people_done']} of {facts['people_trials']} played{who}, {facts['people_solved']} solved"
        yield "people", f"{played}{extra if not facts['trials'] else ''} (lockprobe serve {directory})"
    if facts["forks"]:
        yield "forks", f"{facts['forks']} done (lockprobe branch {directory})"
    if facts["in_progress"]:
        kept = f"{facts['in_progress_calls']} replies kept for them"
        yield "open", f"{count(int(str(facts['in_progress'])), 'trial')} unfinished, {kept}"
    if facts["unanswered_calls"]:
        number = int(str(facts["unanswered_calls"]))
        yield "", f"{count(number, 'call')} in progress, or lost with a killed run"
    added = facts["added"]
    assert isinstance(added, dict)
    for agent, when in added.items():
        yield "added", f"{agent} at {when}"
    yield "steps", f"{facts['steps']} in {facts['seconds_playing']} s of playing, summed over parallel trials"
    if facts["pictures"]:
        yield "pictures", f"{facts['pictures']}"
    errors, first = facts["errors"], facts["first_errors"]
    assert isinstance(errors, dict)
    assert isinstance(first, dict)
    yield "errors", in_boundaries(errors) or "none"
    for boundary, message in sorted(first.items()):
        yield "", f"first at {boundary}: {' '.join(message.split())[:200]}"
    yield "settings", f"hash {facts['settings_hash']} (lockprobe verify {directory} --settings HASH)"
    yield "results", f"hash {facts['results_hash']} (lockprobe verify {directory} --results HASH)"


def _table(ledger: Ledger) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = [
        ("calls of", "replies", "failed", "broken off", "retries", "tokens in", "cached", "out", "reasoning", "cost")
    ]
    parts = [*ledger.by_agent.items()]
    for agent, spent in (*parts, ("all", ledger.total)) if len(parts) > 1 else parts:
        numbers = (
            spent.usage.calls,
            spent.failed,
            spent.broken_off,
            spent.retries,
            spent.usage.input_tokens,
            spent.usage.cached_tokens,
            spent.usage.output_tokens,
            spent.usage.reasoning_tokens,
        )
        cost = "not known" if spent.dollars is None else money(spent.dollars)
        rows.append((agent, *(f"{number:,}" for number in numbers), cost))
    return rows


def _about_calls(ledger: Ledger) -> Iterator[tuple[str, str]]:
    spent = ledger.total
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
    if dates := {part.price.date for part in ledger.by_agent.values() if part.price is not None}:
        yield "prices", f"of {', '.join(sorted(dates))}, US dollars"
    if spent.served:
        yield "served by", ", ".join(f"{name} ({number})" for name, number in spent.served)

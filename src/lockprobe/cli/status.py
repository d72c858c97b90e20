"""``lockprobe status``: progress, errors and cost of a study, during a run or afterwards."""

from __future__ import annotations

import json as json_
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from lockprobe.cli import options
from lockprobe.cli.command import Directory
from lockprobe.cli.format_cost import money, spent_facts
from lockprobe.cli.printing import print_rows
from lockprobe.cli.progress import in_boundaries
from lockprobe.cli.result import decided, read_result
from lockprobe.foundation.clock import time_said
from lockprobe.foundation.formatting import count
from lockprobe.foundation.terminal_text import printable
from lockprobe.people.diary import flow_of, read_diaries
from lockprobe.people.withdrawal import withdrawn
from lockprobe.studies.branch import FORKS, read_forks
from lockprobe.studies.costs.call_log import kept_replies, read_calls
from lockprobe.studies.costs.spending import Ledger, Spending, total
from lockprobe.studies.decisions import planned_now
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import Tally, load, tally
from lockprobe.studies.records.store import read, trials_in
from lockprobe.studies.study import Study
from lockprobe.trial.model_call import Call
from lockprobe.trial.record import Trial


def status(directory: Directory, json: options.AsJson = False) -> None:
    """Show the progress, errors by boundary, time and cost of a study."""
    study, logged = read_study(directory), read_calls(directory)
    with read(directory) as store:
        records = tally(store, study)
        steps, seconds = store.one("select total(steps), total(seconds) from trial where not current")
        errors = {one.boundary: next(trials_in(store, "id = ?", one.first)).error for one in records if one.boundary}
        finished = (
            {key for (key,) in store.rows("select key from trial where current and not owed")} if logged else set()
        )
    steps, seconds = steps + sum(one.steps for one in records), seconds + sum(one.seconds for one in records)
    trials = load(directory, study) if study.until else []
    report, flow = read_result(directory), flow_of(read_diaries(directory), withdrawn(directory))
    facts: dict[str, Any] = {
        "study": study.name,
        "time": time_said(),
        **_played(study, records, trials),
        "first_errors": {name: error.message for name, error in errors.items() if error is not None},
        **_in_progress(logged, finished),
        "steps": int(steps),
        "seconds_playing": round(seconds, 1),
        "steps_per_minute": round(60 * steps / seconds, 1) if seconds else None,
        "forks": sum(not fork.owed_again for fork in read_forks(directory)),
        "reported": None if report is None else report.progress.finished,
        "participants": flow
        and {"joined": flow["consented"], "finished": flow["finished"], "withdrawn": flow["withdrawn"]},
        "settings_hash": study.settings_hash,
    }
    said = list[str]()
    if study.until:
        said, facts["decided"] = decided(study, trials)
        facts["until"] = str(study.until)
    ledger, forks = Ledger(study, logged), Ledger(study, read_calls(directory / FORKS))
    both = total([*ledger.by_agent.values(), *forks.by_agent.values()])
    if json:
        agents = {study.label_of(agent): spent_facts(spent) for agent, spent in ledger.by_agent.items()}
        of_forks = {"spent_on_forks": spent_facts(forks.total), "spent_with_forks": spent_facts(both)}
        print(json_.dumps(facts | spent_facts(ledger.total) | {"agents": agents} | of_forks))
        return
    lines = [*_lines(directory, facts), *(("decided" * (not i), line.strip()) for i, line in enumerate(said))]
    for name, line in lines:
        print(printable(f"{name:<12}{line}"))
    if ledger.by_agent or forks.by_agent:
        print()
        print_rows(_table(study, ledger, forks, both))
        print()
        for name, line in _about_calls(both):
            print(printable(f"{name:<12}{line}"))


def _in_progress(logged: Sequence[Call], finished: set[str]) -> dict[str, object]:
    """The trials that were begun and are owed, and the replies that are kept for them."""
    kept = {key: len(replies) for key, replies in kept_replies(logged).items() if key not in finished}
    begun = {call.key for call in logged if call.broken_off and call.key not in finished} | kept.keys()
    return {"in_progress": len(begun), "in_progress_calls": sum(kept.values())}


def _played(study: Study, records: Sequence[Tally], trials: Sequence[Trial]) -> dict[str, object]:
    """What is planned, played, owed and broken. ``trials`` are those of a study that stops when it is decided.

    People's trials are counted apart from the others.
    """
    run, people = ([one for one in records if bool(one.player) == of] for of in (False, True))
    done, by_people = (sum(one.number for one in own if not one.owed_again) for own in (run, people))
    errors, planned = Counter[str](), planned_now(study, trials)
    for one in records:
        errors.update({one.boundary: one.number} if one.boundary else {})
    return {
        "trials": planned - study.invited,
        "done": done,
        "owed": planned - study.invited - done,
        "people_trials": study.invited,
        "people_done": by_people,
        "people_solved": sum(one.number for one in people if one.ending == "solved"),
        "people": len({one.player for one in people}),
        "planned": planned,
        "finished": done + by_people,
        "partial": done + by_people < planned,
        "solved": sum(one.number for one in run if one.ending == "solved"),
        "errors": errors,
    }


def _lines(directory: Path, facts: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Of every fact that there is its name, empty where it goes on, and what is said."""
    people = facts["participants"] or {}
    who = f" by {facts['people']}" * bool(facts["people"])
    behind = facts["finished"] - (facts["reported"] or 0)
    renew = f", {behind} behind; lockprobe report {directory} makes it anew" if behind else ""
    played = f"{facts['people_done']} of {facts['people_trials']} played{who}, {facts['people_solved']} solved"
    kept = f"{count(facts['in_progress'], 'trial')} unfinished, {facts['in_progress_calls']} replies kept for them"
    trials = f"{facts['done']} of {facts['trials']} done, {facts['owed']} owed, {facts['solved']} solved"
    said = [
        (True, "study", f"{facts['study']} in {directory}, at {facts['time']}"),
        (facts["trials"] or not facts["people_trials"], "trials", trials),
        (facts["people_trials"], "people", f"{played} (lockprobe serve {directory})"),
        (people, "", ", ".join(f"{number} {what}" for what, number in people.items())),
        (facts["forks"], "forks", f"{facts['forks']} done (lockprobe branch {directory})"),
        (facts["in_progress"], "open", kept),
        (True, "steps", f"{facts['steps']} in {facts['seconds_playing']} s of playing, summed over parallel trials"),
        (facts["reported"] is not None, "report", f"of {facts['reported']} of {facts['planned']} trials{renew}"),
        (True, "errors", in_boundaries(facts["errors"]) or "none"),
    ]
    firsts = [f"first at {at}: {' '.join(why.split())[:200]}" for at, why in sorted(facts["first_errors"].items())]
    verify = f"hash {facts['settings_hash']} (lockprobe verify {directory} --settings HASH)"
    shown = [(name, line) for there, name, line in said if there]
    return [*shown, *(("", first) for first in firsts), ("settings", verify)]


def _table(study: Study, ledger: Ledger, forks: Ledger, both: Spending) -> list[tuple[str, ...]]:
    """What the calls of each agent have cost; --json has the rest."""
    rows: list[tuple[str, ...]] = [("calls of", "replies", "failed", "retries", "tokens in", "out", "cost")]
    parts = [(study.label_of(agent), spent) for agent, spent in ledger.by_agent.items()]
    parts += [("all", ledger.total)] * (len(parts) > 1)
    parts += [("forks", forks.total), ("study and forks", both)] * bool(forks.by_agent)
    for agent, spent in parts:
        usage, failed = spent.usage, spent.failed + spent.broken_off
        numbers = (usage.calls, failed, spent.retries, usage.input_tokens, usage.output_tokens)
        cost = "not known" if spent.dollars is None else money(spent.dollars)
        rows.append((agent, *(f"{number:,}" for number in numbers), cost))
    return rows


def _about_calls(spent: Spending) -> Iterator[tuple[str, str]]:
    if spent.unpriced:
        most = "" if spent.dollars_unknown is None else f", at most {money(spent.dollars_unknown)} more"
        yield "uncounted", f"{count(spent.unpriced, 'attempt')} of unknown cost{most}"
    if spent.claimed:
        more = f"{count(spent.claimed, 'call')}: the provider claims an impossible usage"
        yield "claimed", f"{more}; counted above as the possible maximum"
    if spent.price is not None:
        yield "prices", f"of {spent.price.date}, US dollars"
    if spent.served:
        yield "served by", ", ".join(f"{name} ({number})" for name, number in spent.served.most_common())

"""``lockprobe status``: progress, errors and cost of a study, during a run or afterwards."""

from __future__ import annotations

import json as json_
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from lockprobe.cli import options
from lockprobe.cli.format_cost import in_boundaries, spent_facts, spent_in_words
from lockprobe.foundation.formatting import count, time_said
from lockprobe.foundation.inputs import is_there
from lockprobe.foundation.terminal_text import printable
from lockprobe.studies import FORKS, RESULTS
from lockprobe.studies.costs.call_log import kept_replies, read_calls
from lockprobe.studies.costs.spending import Spending, spent_by_agent, total
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import is_being_written
from lockprobe.studies.records.read_records import Tally, load, tally
from lockprobe.studies.records.store import STORE, read, trials_in
from lockprobe.studies.study import Study
from lockprobe.trial.record import Trial


def status(directory: options.Directory, json: options.AsJson = False) -> None:
    """Show the progress, errors by boundary, time and cost of a study."""
    study, logged = read_study(directory), read_calls(directory)
    flow, forks, report = dict[str, int](), list[Trial](), None
    with read(directory) as store:
        counted = tally(store, study)
        replaced = store.one("select total(steps), total(seconds) from trial where not current")
        broke = [trial for one in counted if one.boundary for trial in trials_in(store, "id = ?", one.first)]
        ended = store.rows("select key from trial where current and not owed and key in (select key from call)")
        over = {key for (key,) in ended}  # finished trials that have calls
    trials, planned, given = load(directory) if study.until else [], study.size, dict[str, tuple[int, int]]()
    if study.invited:  # what a study does not have takes longer to import than its trials to count
        from lockprobe.people.diary import boxes_of, flow_of, read_diaries
        from lockprobe.people.withdrawal import withdrawn

        diaries = read_diaries(directory)
        flow, given = flow_of(diaries, withdrawn(directory)), boxes_of(study, diaries)
    if is_there(directory / FORKS / STORE):
        from lockprobe.studies.branch import read_forks

        forks = read_forks(directory)
    if is_there(directory / RESULTS):
        from lockprobe.cli.result import read_result

        report = read_result(directory)
    said = list[str]()
    if study.until:
        from lockprobe.cli.result import decided
        from lockprobe.studies.decisions import planned_now

        planned, (said, decisions) = planned_now(study, trials), decided(study, trials)
    kept = {key: len(replies) for key, replies in kept_replies(logged).items() if key not in over}
    begun = {call.key for call in logged if call.broken_off and call.key not in over} | kept.keys()
    flying = {call.key: call for call in logged if call.key not in over} if is_being_written(directory) else {}
    logged = [call for call in logged if not (call.broken_off and call is flying.get(call.key))]
    facts: dict[str, Any] = {
        "study": study.name,
        "time": time_said(),
        **_played(study, counted, planned),
        "first_errors": {str(one.error.boundary): one.error.message for one in broke[::-1] if one.error},
        "in_progress": len(begun),
        "in_progress_calls": sum(kept.values()),
        "on_their_way": sum(call.broken_off for call in flying.values()),
        "steps": int(replaced[0]) + sum(one.steps for one in counted),
        "seconds_playing": round(replaced[1] + sum(one.seconds for one in counted), 1),
        "forks": sum(not fork.owed_again for fork in forks),
        "reported": None if report is None else report.progress.finished,
        "participants": flow
        and {"joined": flow["consented"], "finished": flow["finished"], "withdrawn": flow["withdrawn"]},
        "boxes_given": {condition: number for condition, (number, _) in given.items()},
        "settings_hash": study.settings_hash,
    } | ({"decided": decisions, "until": str(study.until)} if study.until else {})
    spent, on_forks = spent_by_agent(logged), spent_by_agent(read_calls(directory / FORKS))
    if json:
        agents = {study.label_of(agent): spent_facts(own) for agent, own in spent.items()}
        more = {"agents": agents, "spent_on_forks": spent_facts(total(on_forks.values()))}
        print(json_.dumps(facts | spent_facts(total(spent.values())) | more))
        return
    answers = (("decided" * (not i), line.strip()) for i, line in enumerate(said))
    for name, line in (*_lines(directory, facts), *answers, *_calls(study, spent, on_forks)):
        print(printable(f"{name:<12}{line}"))


def _played(study: Study, records: Sequence[Tally], planned: int) -> dict[str, object]:
    """What is planned, played, owed and broken; people's trials are counted apart from the others."""
    numbers, errors = Counter[str](), Counter[str]()
    for one in records:
        of = "people_" * bool(one.player)
        numbers[f"{of}done"] += one.number * (not one.owed_again)
        numbers[f"{of}solved"] += one.number * (one.ending == "solved")
        errors.update({one.boundary: one.number} if one.boundary else {})
    finished = numbers["done"] + numbers["people_done"]
    return {
        "trials": planned - study.invited,
        "owed": planned - study.invited - numbers["done"],
        **{name: numbers[name] for name in ("done", "solved", "people_done", "people_solved")},
        "people_trials": study.invited,
        "people": len({one.player for one in records if one.player}),
        "planned": planned,
        "finished": finished,
        "partial": finished < planned,
        "errors": errors,
    }


def _lines(directory: Path, facts: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Of every fact that there is its name, empty where it goes on, and what is said."""
    yield "study", f"{facts['study']} in {directory}, at {facts['time']}"
    if facts["trials"] or not facts["people_trials"]:
        yield "trials", f"{facts['done']} of {facts['trials']} done, {facts['owed']} owed, {facts['solved']} solved"
    if facts["people_trials"]:
        by = f" by {facts['people']}" * bool(facts["people"])
        played = f"{facts['people_done']} of {facts['people_trials']} played{by}, {facts['people_solved']} solved"
        yield "people", f"{played} (lockprobe serve {directory})"
    if facts["participants"]:
        yield "", ", ".join(f"{number} {what}" for what, number in facts["participants"].items())
        yield "", f"boxes given: {', '.join(f'{given} under {one}' for one, given in facts['boxes_given'].items())}"
    if facts["forks"]:
        yield "forks", f"{facts['forks']} done (lockprobe branch {directory})"
    if facts["in_progress"]:
        unfinished = count(facts["in_progress"], "trial")
        flying = f", {count(facts['on_their_way'], 'call')} on their way" if facts["on_their_way"] else ""
        yield "open", f"{unfinished} unfinished, {facts['in_progress_calls']} replies kept for them{flying}"
    yield "steps", f"{facts['steps']} in {facts['seconds_playing']} s of playing, summed over parallel trials"
    if facts["reported"] is not None:
        behind = facts["finished"] - facts["reported"]
        renew = f", {behind} behind; lockprobe report {directory} makes it anew" if behind else ""
        yield "report", f"of {facts['reported']} of {facts['planned']} trials{renew}"
    yield "errors", in_boundaries(facts["errors"]) or "none"
    for at, of in sorted(facts["first_errors"].items()):
        yield "", f"first at {at}: {' '.join(of.split())[:200]}"
    yield "settings", f"hash {facts['settings_hash']} (lockprobe verify {directory} --settings HASH)"


def _calls(
    study: Study, by_agent: Mapping[str, Spending], on_forks: Mapping[str, Spending]
) -> Iterator[tuple[str, str]]:
    """The same of what the calls of each agent have cost; --json has every number."""
    parts = [(study.label_of(agent), spent) for agent, spent in by_agent.items()]
    parts += [("all", total(by_agent.values()))] * (len(parts) > 1)
    parts += [("forks", total(on_forks.values()))] * bool(on_forks)
    for i, (agent, spent) in enumerate(parts):
        yield "calls" * (not i), f"{agent}: {count(spent.usage.calls, 'reply', 'replies')}, {spent_in_words(spent)}"
    spent = total([*by_agent.values(), *on_forks.values()])
    if spent.unpriced:
        yield "uncounted", f"{count(spent.unpriced, 'attempt')} of unknown cost"
    if spent.claimed:
        said = "the provider claims an impossible usage; counted above as its maximum"
        yield "claimed", f"{count(spent.claimed, 'call')}: {said}"
    if spent.price:
        yield "prices", f"of {spent.price.date}, US dollars"
    if spent.served:
        yield "served by", ", ".join(f"{name} ({number})" for name, number in spent.served.most_common())

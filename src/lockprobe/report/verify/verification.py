"""Verification of a finished study from its records alone: settings, checksums, luck, truth, replies and report.

What a record says of the box and of the reports has to follow from its actions, from the rules of the box and from the
random streams of its seed. So every trial is played again with the recorded choices. Choices are held against what
there is of their agent: strategies are asked again, hosted models have their replies in the log of calls, local models
their probabilities, people and clients the log of their server. The report is made again and compared. No code of a
user or of another package runs, and no model is asked.
"""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path

from lockprobe.agents.catalogue import is_strategy, resolve
from lockprobe.agents.llm.settings import Model
from lockprobe.agents.policy import Policy
from lockprobe.foundation.errors import LockprobeError, UserMistake
from lockprobe.foundation.inputs import is_there, read_input
from lockprobe.foundation.plugins import no_foreign_code
from lockprobe.foundation.spec import MCP, Spec, spec_kind
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.people.journey import acts_of_steps
from lockprobe.report.opened import OpenedStudy, open_study
from lockprobe.report.verify.check import Check, also
from lockprobe.report.verify.made_again import report_held
from lockprobe.report.verify.replay import ReplayedTrial, is_foreign, kind_of, played_again
from lockprobe.report.verify.replies import LoggedCalls, replies_held
from lockprobe.studies.branch import FORKS, fork_plan
from lockprobe.studies.decisions import due
from lockprobe.studies.next_choice import next_choice
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.known_facts import lasting_facts
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.records.results_hash import results_hash
from lockprobe.studies.records.store import STORE, read
from lockprobe.studies.records.trial_rows import contradictions
from lockprobe.studies.running.paused_trial import RecordedAttempt
from lockprobe.studies.study import Study
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.protocols import InterventionTraits
from lockprobe.trial.record import Trial
from lockprobe.trial.source import CAMERA
from lockprobe.trial.trial_name import ForkName

NOT_SHOWN = (
    "No such check can show that the plan was changed, the seed chosen, or an agent or a person left out before these "
    "records were made, or that all of it was made up together (replies, answers of people and of local models, "
    "clock readings). To be safe against it: put the hash of the settings, which run prints before the first trial, "
    "under a preregistration, and that of the results under the paper; --settings HASH and --results HASH check them"
)
"""What verification cannot find, and what helps against it."""


def verify(
    directory: Path | str,
    *,
    settings: str | None = None,
    results: str | None = None,
    tell: Callable[[int, int], None] = lambda done, of: None,
) -> tuple[Check, ...]:
    """Recompute a study from its records, and hold what lies in its directory against that.

    Args:
        directory: The directory of a study.
        settings: The hash of its settings, as it was published; None checks none.
        results: The hash of its records likewise.
        tell: Called with the number of trials played again, and of all.

    Returns:
        The checks in order. After settings or records that cannot be read there are no others.
    """
    with no_foreign_code():
        try:
            opened = open_study(Path(directory))
            trials = {trial.key: trial for trial in opened.trials}
            acts_of_steps(opened.study, trials, opened.diaries, opened.directory)  # diaries and records agree
            found = _PlayedAgain(opened, {"settings": settings, "results": results}, tell)
            return (*chain.from_iterable(check(found) for check in _CHECKS), *report_held(opened))
        except LockprobeError as error:
            return (Check(name="records", holds=False, said=str(error)),)


class _PlayedAgain:
    """A study whose trials are played again, and its published hashes."""

    def __init__(
        self, opened: OpenedStudy, published: Mapping[str, str | None], tell: Callable[[int, int], None]
    ) -> None:
        self.opened, self.published, self.study = opened, published, opened.study
        self.log = LoggedCalls(opened.directory)
        self.trials = {trial.key: trial for trial in opened.trials}
        finished = {key for key, trial in self.trials.items() if not trial.owed_again}
        plans = (plan for agent in self.study.run_agents for plan in self.study.plans(agent))
        self.owed = {plan.key: plan for plan in plans if plan.key not in finished}
        self.again = list[ReplayedTrial]()
        with asyncio.Runner() as runner:
            for done, trial in enumerate(opened.trials, 1):
                condition = self.study.condition_of(trial)
                assert condition is not None  # only trials that the settings ask for are opened
                plan = self.study.plan(trial.agent, condition, trial.repetition, trial.trial)
                self.again.append(runner.run(played_again(plan, trial, self.log.kept.get(trial.key, ()))))
                tell(done, len(opened.trials))


def _records(of: _PlayedAgain) -> Iterator[Check]:
    """The store is sound and says what its records say; how many trials ended as an error."""
    opened, directory, failed = of.opened, of.opened.directory, list[str]()
    for folder in (directory, directory / FORKS):
        if is_there(folder / STORE):
            with read(folder) as store:
                damage = [said for (said,) in store.rows("pragma quick_check") if said != "ok"]
                failed += (f"{store.path.relative_to(directory)}: {said}" for said in damage or contradictions(store))
    broken = Counter(trial.error.boundary for trial in opened.trials if trial.error is not None)
    where = f" ({', '.join(f'{name} {broken[name]}' for name in sorted(broken))})" if broken else ""
    ended = f"{broken.total()} of {len(opened.trials)} trials ended as an error{where}"
    holds = f"{len(opened.trials)} records, unchanged, and {len(of.log.calls)} calls; {ended}"
    yield Check.of("records", failed, f"{{n}} records that are damaged or contradict the others; {ended}", holds)


def _settings(of: _PlayedAgain) -> Iterator[Check]:
    """All records are of this study: its seed, box, budget, conditions and panels."""
    own, failed = of.study, list[str]()
    for condition in own.conditions:
        for spec, doses in condition.acting:
            if is_foreign("intervention", spec):
                continue
            try:
                (made,) = interventions_of(spec)
            except UserMistake:  # it cannot be made here, as without the file of a prompt
                continue
            if (found := InterventionTraits.of(made).doses) != doses:
                names, said = (", ".join(one) or "none" for one in (found, doses))
                failed.append(f"{condition.label}: the doses of {spec} are {names}, not {said}")
    holds = f"all {len(of.trials)} trials are of seed {own.seed} and these settings, {own.settings_hash}"
    yield Check.of("settings", failed, "; ".join(failed), holds)


def _complete(of: _PlayedAgain) -> Iterator[Check]:
    """Every planned trial of agents is there; participants owe none."""
    own, opened, owed = of.study, of.opened, of.owed
    if own.until is not None:  # what it has to play before its next look; nothing if it may stop
        owed = {plan.key: plan for agent in own.run_agents for plan in due(own, agent, opened.trials)}
    people = f"; of people {sum(bool(one.player) for one in opened.trials)} of {own.invited}, who owe none"
    holds = f"every {f'trial that it needs until {own.until}' if own.until else 'planned trial'} is there"
    yield Check.of("complete", owed, "{n} planned trials are missing", holds + people * bool(own.invited))


def _hashes(of: _PlayedAgain) -> Iterator[Check]:
    """The hashes are the published ones, where there are any."""
    found = {"settings": of.study.settings_hash, "results": results_hash(of.study, of.opened.trials)}
    for what, published in of.published.items():
        if published is not None:
            asked, said = published.strip(), f"these {what} have the hash {found[what]}"
            yield Check.of(f"{what} hash", [asked] * (asked.lower() != found[what]), f"{said}, not {asked}", said)


def _luck(of: _PlayedAgain) -> Iterator[Check]:
    """Truth and reports follow from the choices, the box and the seed."""
    left, follow = sum(one.unplayed for one in of.again), "follow from their choices, the box and the seed"
    pairs = zip(of.opened.trials, of.again, strict=True)
    sensed = sum(CAMERA in trial.opening_sensed and not one.unplayed for trial, one in pairs)
    more = "more need a plant or an intervention that does not ship, or a real box, and are not played"
    holds = f"all {len(of.again) - left} trials {follow}{also(sensed, 'take what a camera read from their records')}"
    failed = [f"{one.key}: {one.luck}" for one in of.again if one.luck]
    yield Check.of("luck", failed, f"{{n}} trials do not {follow}", holds + also(left, more))


def _choices(of: _PlayedAgain) -> Iterator[Check]:
    """Strategies choose the same again, local models by their probabilities, and nobody the impossible."""
    counts = Counter(one.kind for one in of.again if not one.unplayed or one.kind == "own")
    unasked = sum(one.unplayed and one.kind in ("strategy", "local") for one in of.again)
    failed = [f"{one.key}: {one.choices}" for one in of.again if one.choices and one.kind != "hosted"]
    holds = f"{counts['strategy']} trials of strategies are the same when they are asked again"
    if counts["local"]:
        holds += f"; those of {counts['local']} trials of local models follow from their recorded probabilities"
    holds += also(unasked, "more of both are not asked, since they are not played")
    if counts["own"]:
        holds += f"; those of {counts['own']} trials of your own agents cannot be recomputed"
    yield Check.of("choices", failed, "{n} trials differ from what their agents choose", holds)


def _agents(of: _PlayedAgain) -> Iterator[Check]:
    """An agent is the same in all its trials, and a model the one that its spec names."""
    known, failed = dict[tuple[str, str], object](), dict[str, None]()
    for trial in of.opened.trials:
        for name, value in lasting_facts(trial).items():
            if value is not None and known.setdefault((trial.agent, name), value) != value:
                failed[f"{trial.key}: {name} is {value}, and {known[trial.agent, name]} in other trials"] = None
        if why := _another_model(trial):
            failed[f"{trial.key}: {why}"] = None
    holds = "every agent says the same of itself in all its trials"
    yield Check.of("agents", failed, "{n} trials differ in what they say of their agent", holds)


def _another_model(trial: Trial) -> str:
    """What the facts of a hosted model have otherwise than its spec; empty if nothing."""
    if kind_of(trial.agent) != "hosted" or not trial.facts:
        return ""
    try:
        name = Model.parse(trial.agent).name
    except UserMistake as mistake:
        return str(mistake)
    for fact, value in {"model": name, **Spec.parse(trial.agent).options}.items():
        there = trial.facts.get(fact)
        with suppress(ValueError):  # a number may be written in several ways
            if isinstance(there, int | float) and float(value) == there:
                continue
        if there is not None and str(there) != value:
            return f"{fact} is {there} in its record and {value} in its spec"
    return ""


def _attempts(of: _PlayedAgain) -> Iterator[Check]:
    """Steps of people and clients are the attempts in their diaries and in the log of attempts, and all of them."""
    opened, logged = of.opened, AttemptLog.read(of.opened.directory)
    clients = [trial for trial in opened.trials if spec_kind(trial.agent) == MCP]
    people, diaries = [trial for trial in opened.trials if trial.player], {diary.spec for diary in opened.diaries}
    if not (clients or people or logged or diaries):
        return
    failed = [f"{trial.key}: {why}" for trial in clients if (why := _unlike(trial, logged.get(trial.key, ())))]
    nobody = logged.keys() - of.trials.keys() - of.owed.keys()
    failed += (f"{key}: attempts of no trial of this study" for key in nobody)
    failed += (f"{trial.key}: its player has no diary" for trial in people if diaries and trial.agent not in diaries)
    for diary in opened.diaries:
        for box in range(1, len(diary.joined.slots) + 1):
            key = diary.key(of.study, box)
            trial = of.trials.get(key)
            if trial is not None and trial.agent == diary.spec:
                failed += [f"{key}: {why}"] if (why := _unlike(trial, diary.attempts(box))) else []
            elif trial is None and (steps := diary.steps.get(box)) and steps[-1].ended is not None:
                failed.append(f"{key}: it ended in the diary of {diary.spec} and is not on record")
    held, rest = len(clients) + len(people) * bool(diaries), also(0 if diaries else len(people), "have no diaries")
    holds = f"{held} trials of clients and people are as their servers wrote them step by step{rest}"
    yield Check.of("attempts", failed, "{n} contradictions between records and the logs of attempts", holds)


def _unlike(trial: Trial, attempts: Sequence[RecordedAttempt]) -> str:
    """The first difference between a trial and the attempts in a log; empty without one."""
    if trial.owed_again:  # its box broke: the log starts anew
        return ""
    if len(attempts) != len(trial.steps):
        return f"{len(trial.steps)} steps, and {len(attempts)} attempts in its log"
    for step, attempt in zip(trial.steps, attempts, strict=True):
        said = step.decision
        if attempt != RecordedAttempt(said.joint, said.claimed, step.told, said.hypothesis):
            return f"step {step.step} is another one in its log"
    return ""


def _forks(of: _PlayedAgain) -> Iterator[Check]:
    """Forks follow from the records of their trials, their choices and the seed, and next choices from strategies."""
    opened, own, directory = of.opened, of.study, of.opened.directory / FORKS
    if not opened.forks:
        return
    there, log, chances = read_study(directory), LoggedCalls(directory), dict(opened.choices)
    again, choices, failed = list[ReplayedTrial](), list[str](), list[str]()
    if list(map(there.record_identity, there.conditions)) != list(map(own.record_identity, own.conditions)):
        failed.append(f"{FORKS}/study.json: the settings of another study")
    with asyncio.Runner() as runner:
        for fork in opened.forks:
            planned, chosen = _fork_plan(own, of.trials, fork), chances.pop(fork.key, None)
            if isinstance(planned, str):
                again.append(ReplayedTrial(key=fork.key, kind="own", luck=planned))
                choices += [f"{fork.key}: a next choice, but {planned}"] if chosen is not None else []
                continue
            name, plan = planned
            replies = log.kept.get(fork.key, ()), of.log.kept.get(name.parent, ())
            again.append(runner.run(played_again(plan, fork, *replies)))
            if chosen is not None:
                policy = resolve(fork.agent).make() if is_strategy(fork.agent) else None
                if not isinstance(policy, Policy) or runner.run(next_choice(plan, policy, name.at)) != chosen:
                    choices.append(f"{fork.key}: another next choice than its strategy has")
    for one in again:  # choices of hosted models have a check of their own
        if why := one.luck or one.choices * (one.kind != "hosted"):
            failed.append(f"{one.key}: {why}")
    failed += (*choices, *(f"{key}: a next choice, but no fork on record has it" for key in chances))
    follow = "follow from their trials, their choices and the seed"
    yield Check.of("forks", failed, f"{{n}} forks do not {follow}", f"all {len(again)} forks {follow}")
    yield from replies_held("fork replies", log, {one.key: one for one in opened.forks}, again, {})


def _fork_plan(study: Study, trials: Mapping[str, Trial], fork: Trial) -> tuple[ForkName, Plan] | str:
    """The name and the plan of a fork, or why it has none."""
    name = fork.fork
    if name is None or name.parent not in trials:
        return "it is a fork of no trial on record"
    try:
        return name, fork_plan(study, trials[name.parent], name)
    except (UserMistake, ValueError, StopIteration) as error:  # an unknown arm; a trial that is none of its condition
        return f"its trial cannot be forked so ({str(error) or 'its record is another one'})"


def _pictures(of: _PlayedAgain) -> Iterator[Check]:
    """Every picture that is there is the one of its name."""
    album, names = of.opened.directory / ALBUM, {name for one in of.opened.trials for name in one.picture_names}
    there = [name for name in sorted(names) if (album / name).is_file()]
    failed = [name for name in there if Picture(kind="rgb", png=read_input(album / name)).name != name]
    holds = f"{len(there)} pictures are those that the records name{also(len(names) - len(there), 'are not there')}"
    if names:
        yield Check.of("pictures", failed, "{n} pictures are not those that the records name", holds)


_CHECKS = (
    _records, _settings, _complete, _hashes, _luck, _choices, _agents,
    lambda of: replies_held("replies", of.log, of.trials, of.again, of.owed), _attempts, _forks, _pictures,
)  # fmt: skip
"""What is checked before the report, in order; each says what is wrong, and what it found if nothing is."""

"""The session of a study that clients with tools play: one trial after another, one call at a time.

Every attempt is on disk before its report leaves (:mod:`lockprobe.studies.records.attempt_log`). A client that goes
away leaves its trial where it is: whoever begins next goes on with it. A refused call changes nothing.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Coroutine, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager, nullcontext
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any, TypeVar

from lockprobe.agents.reply import CLAIMS, LONGEST_HYPOTHESIS
from lockprobe.foundation.errors import BadFile, BadValue, LockprobeError, SettingsChanged
from lockprobe.foundation.redaction import without_keys, without_secrets
from lockprobe.foundation.terminal_text import printable
from lockprobe.interfaces.mcp.wording import OVER, instruction, observation, wording
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.picture_store import ALBUM
from lockprobe.studies.running.paused_trial import PausedTrial, RecordedAttempt
from lockprobe.studies.running.playable import CLIENT, check_playable
from lockprobe.studies.running.rounds import next_plans
from lockprobe.studies.running.trial_setup import own_thread
from lockprobe.studies.study import Study
from lockprobe.trial.loop import Executor, here
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Fact, Outcome, Situation

_T = TypeVar("_T")

TOGETHER = 0.01
"""Seconds for which a call blocks others after its work: calls sent together arrive within this time."""


_LONGEST_FACT = 100
"""Characters of what a client says of itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Connection:
    """A client's description of itself.

    Attributes:
        client: The name that the program gives; empty if it gives none.
        version: Its version.
        protocol: The version of the Model Context Protocol.
    """

    client: str = ""
    version: str = ""
    protocol: str = ""


def facts_of(connection: Connection, wording: str, *, position: int, resumed: int) -> Mapping[str, Fact]:
    """The facts of a record.

    Args:
        connection: The client.
        wording: Fingerprint of instruction and tools.
        position: The number of trials that the connection has begun, including this one.
        resumed: How often the trial was resumed after a client or the server had stopped.
    """
    client, version = (
        printable(without_secrets(said))[:_LONGEST_FACT] for said in (connection.client, connection.version)
    )
    facts: dict[str, Fact] = {
        "protocol": f"MCP tools {connection.protocol}".rstrip(),
        "client": client,
        "client_version": version,
        "wording": wording,
        "position": position,
    }
    return facts | ({"resumed": resumed} if resumed else {})


class CallRefused(LockprobeError):
    """A refused call, which changed nothing. The client reads the message."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reply:
    """The reply to a client: words, and pictures if the modality has them."""

    text: str
    pictures: tuple[Picture, ...] = ()


class ToolSession:
    """The trials of one agent, as tools play them. Use :meth:`open`."""

    def __init__(
        self,
        study: Study,
        agent: str,
        journal: Journal,
        log: AttemptLog,
        place: Executor,
        trials_each: int | None,
        together: float,
    ) -> None:
        self.study, self.agent = study, agent
        self._journal, self._log, self._place = journal, log, place
        self._most, self._together = trials_each, together
        self._wording = wording(
            len(study.box.joints), assessment=study.assessment, hypothesis=study.hypothesis != "off"
        )
        self._trial: PausedTrial | None = None
        self._begun = 0
        self._owed = self._due()
        self._broken: set[str] = set()
        self._busy = False

    @classmethod
    @asynccontextmanager
    async def open(
        cls, directory: Path, study: Study, agent: str, *, trials_each: int | None = None, together: float = TOGETHER
    ) -> AsyncIterator[ToolSession]:
        """Open a study for an agent in a directory, new or existing.

        ``trials_each`` is the most trials of the session; None for any number. ``together`` are the seconds for which a
        call blocks others after its work.

        Raises:
            SettingsChanged: If the directory holds another study, or the agent played with other settings.
            DirectoryBusy: If another process writes there.
            BadValue: If a client cannot play a condition.
            BadFile: If a file in it is damaged.
        """
        check_playable(study.conditions, CLIENT)
        if len({len(box.joints) for box in study.boxes}) > 1:
            raise BadValue("box", ", ".join(box.name for box in study.boxes), "boxes with equally many joints")
        for plant, box in product(study.plants, study.boxes):
            resolve_plant(plant).check(box)
        with (
            Journal.open(directory, study) as journal,
            own_thread() if study.simulated else nullcontext(here) as place,
        ):
            session = cls(study, agent, journal, AttemptLog(journal.store), place, trials_each, together)
            session._check_played()
            try:
                yield session
            finally:
                await session._let_go()

    def _due(self) -> dict[str, Plan]:
        """The trials that are owed; of a study that stops when it is decided, those before the next look."""
        plans = next_plans(self.study, self._journal)(self.agent)
        return {plan.key: plan for plan in plans if self._journal.owes(plan.key)}

    @property
    def owed(self) -> int:
        """The number of trials left; of a study that stops when it is decided, those before the next look."""
        return len(self._owed)

    async def observe(self, connection: Connection) -> Reply:
        """Begin the next trial, or go on with the unfinished one: its instruction, its steps and the last report.

        Raises:
            CallRefused: If no trial is left, or another call is being answered.
        """
        return await self._alone(self._observe(connection))

    async def attempt(self, joint: str, last_action: str | None = None, hypothesis: str = "") -> Reply:
        """Attempt a joint. The attempt is on disk when this returns.

        Args:
            joint: Label of the joint.
            last_action: The claimed effect of the last action, a key of :data:`CLAIMS`.
            hypothesis: How the box works, at most 4000 characters.

        Raises:
            CallRefused: If no trial is under way, the joint does not exist, the claim is missing or not asked for,
                another call is being answered, or nothing can be written.
        """
        return await self._alone(self._attempt(joint, last_action, hypothesis))

    async def _alone(self, work: Coroutine[Any, Any, _T]) -> _T:
        """Do one call. A second one that arrives meanwhile is refused; a client that goes away interrupts nothing."""
        if self._busy:
            work.close()
            raise CallRefused("Another call is being answered, so this one did nothing. Make one call at a time.")
        self._busy = True
        call = asyncio.create_task(self._answered(work))
        call.add_done_callback(_retrieve)
        return await asyncio.shield(call)

    async def _answered(self, work: Coroutine[Any, Any, _T]) -> _T:
        try:
            return await work
        finally:
            await asyncio.sleep(self._together)
            self._busy = False

    async def _observe(self, connection: Connection) -> Reply:
        with _writing():
            self._journal.store.check()
            self._refuse_another(connection)
            if self._trial is None:
                await self._open_next(connection)
        assert self._trial is not None
        assert self._trial.situation is not None
        return _reply(self._trial.situation, instruction(self._trial.situation))

    async def _open_next(self, connection: Connection) -> None:
        """Open the trial that was under way, or the next one that is owed."""
        most = self._most
        while True:
            plan = self._next()
            if most is not None and self._begun >= most and not self._log.under_way(plan.key):
                raise CallRefused(f"This session has played its trials ({most}). Start the server anew for more.")
            if await self._open(plan, connection):
                return

    def _next(self) -> Plan:
        """The trial left unfinished by the last client or server, or the first owed trial."""
        playable = [plan for key, plan in self._owed.items() if key not in self._broken]
        if not playable:
            left = f" ({self.owed} broke and are owed)" if self._owed else ""
            raise CallRefused(f"No trial is left{left}. There is nothing more to do.")
        return next((plan for plan in playable if self._log.under_way(plan.key)), playable[0])

    async def _open(self, plan: Plan, connection: Connection) -> bool:
        """Open a trial; False if it is over: it had not been recorded, or its box broke."""
        resumed = self._log.times_begun(plan.key)
        if not resumed or not self._begun:
            self._begun += 1
        trial = await PausedTrial.begin(
            plan,
            self._log.attempts(plan.key),
            facts=dict(facts_of(connection, self._wording, position=self._begun, resumed=resumed)),
            pictures=self._journal.directory / ALBUM,
            place=self._place,
        )
        if trial.trial is not None:
            self._record(trial)
            return False
        self._journal.used = True
        try:
            self._log.begin(plan.key)
        except BadFile:
            await trial.close()
            raise
        self._trial = trial
        return True

    async def _attempt(self, joint: str, last_action: str | None, hypothesis: str) -> Reply:
        trial = self._trial
        if trial is None or trial.situation is None:
            raise CallRefused("No trial is under way, so this call did nothing. Call observe first.")
        situation = trial.situation
        if joint not in (known := situation.task.joints):
            raise CallRefused(f"joint: {joint[:40]!r} is none of {', '.join(known)}. This call did nothing.")
        claimed = _claimed(last_action, situation)
        if len(hypothesis) > LONGEST_HYPOTHESIS:
            raise CallRefused(f"hypothesis: at most {LONGEST_HYPOTHESIS} characters. This call did nothing.")
        step = RecordedAttempt(joint, claimed, hypothesis=without_keys(hypothesis))
        with _writing():
            told = await trial.attempt(step.joint, step.claimed, step.hypothesis)
            try:
                if trial.sound:
                    self._log.attempt(trial.plan.key, step._replace(told=told))
            except BadFile:  # an attempt that is not written has not been made
                await self._let_go()
                raise
            if trial.trial is None:
                assert trial.situation is not None
                return _reply(trial.situation, observation(trial.situation))
            self._trial = None
            self._record(trial)
        if not trial.sound:
            return Reply(text="The box broke, so this trial does not count. Call observe to go on.")
        return Reply(text=f"{OVER} {'Call observe for the next one.' if self.owed else 'No trial is left.'}")

    def _record(self, trial: PausedTrial) -> None:
        """Write a finished trial, unless it is on record."""
        assert trial.trial is not None
        assert trial.timing is not None
        if not trial.sound:
            self._broken.add(trial.plan.key)
            self._log.broke(trial.plan.key)
        if self._journal.owes(trial.plan.key):
            self._journal.append(trial.trial, trial.timing)
        if not self._journal.owes(trial.plan.key):
            self._owed.pop(trial.plan.key, None)
        self._owed = self._owed or self._due()

    def _check_played(self) -> None:
        """Refuse an agent that played this study with another wording.

        Raises:
            SettingsChanged: If it did.
        """
        before = next((one for one in self._journal.kinds() if one.agent == self.agent), None)
        if before is not None and (said := before.facts.get("wording")) not in (None, self._wording):
            raise SettingsChanged(self._journal.directory, {f"{self.agent}, wording": (said, self._wording)})

    def _refuse_another(self, connection: Connection) -> None:
        """Refuse another program under the name of the agent that played before."""
        now = facts_of(connection, "", position=0, resumed=0)["client"]
        for before in self._journal.kinds():
            if before.agent == self.agent and before.facts.get("client") not in (None, now):
                played = before.facts["client"]
                raise CallRefused(
                    f"Trials of {self.agent} were played by the client {played!r}, and this is {now!r}. "
                    "Whoever started the server gives this client another --agent-name."
                )

    async def _let_go(self) -> None:
        trial, self._trial = self._trial, None
        if trial is not None:
            await trial.close()


@contextmanager
def _writing() -> Iterator[None]:
    """Tell a client that nothing could be written, without the path."""
    try:
        yield
    except (BadFile, BadValue) as error:
        raise CallRefused("The server cannot write or read its records, so this call did nothing.") from error


def _retrieve(call: asyncio.Task[Any]) -> None:
    """Retrieve what a call raised, in case its client has gone: nobody else would."""
    if not call.cancelled():
        call.exception()


def _claimed(said: str | None, situation: Situation) -> Outcome | None:
    """The client's claim about its last action, as in the chat protocol."""
    first = situation.percept.joint is None
    if said is not None and said not in CLAIMS:
        raise CallRefused(f"last_action: {said[:40]!r} is none of {', '.join(CLAIMS)}. This call did nothing.")
    claimed = None if said is None else CLAIMS[said]
    if not situation.task.assessment:
        if said is not None:
            raise CallRefused("last_action: nobody asks for it here. This call did nothing.")
    elif first and claimed is not None:
        raise CallRefused("last_action: there is no last action yet; leave it out. This call did nothing.")
    elif not first and claimed is None:
        raise CallRefused('last_action is missing: "moved" or "did not move". This call did nothing.')
    return claimed


def _reply(situation: Situation, text: str) -> Reply:
    shown = tuple(picture for picture in situation.percept.pictures if picture.shown)
    return Reply(text=text, pictures=shown)

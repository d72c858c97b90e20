"""A study as two tools of the Model Context Protocol, ``observe`` and ``attempt``, over standard input and output.

A client plays the trials one after another, one call at a time. It starts the server, which ends with it. Every attempt
is on disk before its report leaves (:mod:`lockprobe.studies.records.attempt_log`). A client that goes away leaves its
trial where it is: whoever begins next goes on with it. A refused call is a result that the model reads, marked as an
error. The instruction is the one that language models get, but for how to reply. The end of a trial
says neither whether the box opened nor what the last report was, because agents that chat are told neither. Results
hold text and pictures and no structured content: some clients show a model that in place of the text.
"""

from __future__ import annotations

import asyncio
import json
import logging
import sys
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from importlib.metadata import version
from itertools import product
from pathlib import Path
from typing import Any

from lockprobe.agents.catalogue import SAME_IN_ALL_TRIALS
from lockprobe.agents.prompt import INSTRUCTIONS, fingerprint, instructions
from lockprobe.agents.reply import CLAIMS, LONGEST_HYPOTHESIS
from lockprobe.foundation.errors import BadFile, BadValue, LockprobeError, needing
from lockprobe.foundation.redaction import without_keys, without_secrets
from lockprobe.foundation.terminal_text import printable
from lockprobe.plants.catalogue import resolve_plant
from lockprobe.studies.records.attempt_log import AttemptLog
from lockprobe.studies.records.journal import Journal, note
from lockprobe.studies.records.store import ALBUM
from lockprobe.studies.running.paused_trial import PausedTrial, RecordedAttempt
from lockprobe.studies.running.playable import CLIENT, check_playable
from lockprobe.studies.running.runner import next_plans
from lockprobe.studies.running.trial_setup import plants_place
from lockprobe.studies.study import Study
from lockprobe.trial.labels import LABELS
from lockprobe.trial.loop import Executor
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Fact, Situation

with needing("agents with tools", "mcp"):
    import mcp_types as types
    from mcp.server.context import ServerRequestContext
    from mcp.server.lowlevel import Server
    from mcp.server.stdio import stdio_server

Reply = list[types.TextContent | types.ImageContent]
"""What a call tells the client: words, and pictures if the modality has them."""

OVER, NO_REPORT = "The trial is over.", "(no report)"

TOGETHER = 0.01
"""Seconds for which a call blocks others after its work: calls sent together arrive within this time."""

LONGEST_LINE = 64 * 1024
"""Bytes of the longest message. A longer one is answered as malformed, and never kept as a whole."""

_LONGEST_FACT = 100
"""Characters of what a client says of itself."""

_INSTRUCTIONS = (
    "A lockbox to open, one trial after another. Call observe for a trial and its instruction, then attempt, one "
    "call at a time, until the trial is over."
)

_DESCRIPTIONS = {
    "observe": "Begin the next trial, or read the one under way: its instruction, its steps and what is seen.",
    "attempt": "Attempt one joint, and read what follows. Every call is one step of the trial.",
}

_ARGUMENTS: Mapping[str, tuple[str, dict[str, Any]]] = {
    "joint": (
        "In every step call the tool attempt once. joint is the joint to attempt.",
        {"enum": [], "description": "The joint to attempt."},
    ),
    "last_action": (
        'last_action is what your last action did, "moved" or "did not move"; leave it out in the first step.',
        {"enum": [*CLAIMS], "description": "What your last action did, from step 2 on."},
    ),
    "hypothesis": (
        "hypothesis is a short sentence on how the box works, if you have one.",
        {"maxLength": LONGEST_HYPOTHESIS, "description": "How the box works, in a sentence."},
    ),
}
"""The arguments of an attempt: how to reply, and what their schema says beside that they are text."""

_log = logging.getLogger(__name__)


class CallRefused(LockprobeError):
    """A refused call. The client reads the message, which says what became of it."""


class ToolSession:
    """The trials of one agent, as tools play them. Use :meth:`open`.

    Attributes:
        schemas: The arguments of each tool as a JSON schema.
    """

    def __init__(self, study: Study, agent: str, journal: Journal, place: Executor, trials_each: int | None) -> None:
        self.study, self.agent = study, agent
        self._journal, self._log, self._place, self._most = journal, AttemptLog(journal.store), place, trials_each
        asked = {"joint": True, "last_action": study.assessment, "hypothesis": study.hypothesis != "off"}
        names = [name for name in _ARGUMENTS if asked[name]]
        texts = {name: {"type": "string", **_ARGUMENTS[name][1]} for name in names}
        texts["joint"]["enum"] = [*LABELS[: len(study.box.joints)]]
        self.schemas: dict[str, dict[str, Any]] = {
            tool: {"type": "object", "properties": own, "required": [*own][:1], "additionalProperties": False}
            for tool, own in (("observe", {}), ("attempt", texts))
        }
        self._how = " ".join([*(_ARGUMENTS[name][0] for name in names), "Wait for the result before the next call."])
        self._trial: PausedTrial | None = None
        self._begun = 0
        self._broken: set[str] = set()
        self._busy = False

    @classmethod
    @asynccontextmanager
    async def open(
        cls, directory: Path, study: Study, agent: str, *, trials_each: int | None = None
    ) -> AsyncIterator[ToolSession]:
        """Open a study for an agent in a directory, new or existing.

        ``trials_each`` is the most trials of the session; None for any number.

        Raises:
            SettingsChanged: If the directory holds another study.
            DirectoryBusy: If another process writes there.
            BadValue: If a client cannot play a condition.
            BadFile: If a file in it is damaged.
        """
        check_playable(study.conditions, CLIENT)
        if len({len(box.joints) for box in study.boxes}) > 1:
            raise BadValue("box", ", ".join(box.name for box in study.boxes), "boxes with equally many joints")
        for plant, box in product(study.plants, study.boxes):
            resolve_plant(plant).check(box)
        with Journal.open(directory, study) as journal, plants_place(study.simulated) as place:
            session = cls(study, agent, journal, place, trials_each)
            try:
                yield session
            finally:
                await session._let_go()

    @property
    def owed(self) -> int:
        """The number of trials left; of a study that stops when it is decided, those before the next look."""
        return len(self._due())

    async def call(self, tool: str, given: Mapping[str, object], facts: Mapping[str, str]) -> Reply:
        """Do one call: ``observe`` or ``attempt``. An attempt is on disk when this returns.

        A second call that arrives meanwhile is refused. A client that goes away interrupts nothing.

        Args:
            tool: Name of the tool.
            given: Its arguments.
            facts: What the client says of itself: ``client``, ``client_version``, ``protocol``.

        Raises:
            CallRefused: If the tool or an argument does not exist, no trial is under way or left, the claim is missing
                or not asked for, another call is being answered, or nothing can be written.
        """
        if self._busy:
            raise CallRefused("Another call is being answered, so this one did nothing. Make one call at a time.")
        self._busy = True
        call = asyncio.create_task(self._answered(tool, given, facts))
        call.add_done_callback(lambda done: None if done.cancelled() else done.exception())  # its client may have gone
        return await asyncio.shield(call)

    async def _answered(self, tool: str, given: Mapping[str, object], facts: Mapping[str, str]) -> Reply:
        try:
            if tool not in self.schemas:
                raise CallRefused(f"no tool is called {tool[:40]!r}; there are observe and attempt.")
            known, texts = self.schemas[tool]["properties"], dict[str, str]()
            asked = {name: value for name, value in given.items() if value is not None}
            for name, value in (dict.fromkeys(self.schemas[tool]["required"], "") | asked).items():
                about = known.get(name)
                if about is None:
                    why = f"{tool} has no argument {name[:40]!r}; it takes {', '.join(known) or 'no argument'}"
                elif value not in about.get("enum", [value]):
                    why = f"{name}: {str(value)[:40]!r} is none of {', '.join(about['enum'])}"
                elif not isinstance(value, str) or len(value) > about.get("maxLength", len(value)):
                    why = f"{name}: a text of at most {about['maxLength']} characters"
                else:
                    texts[name] = value
                    continue
                raise CallRefused(f"{why}. This call did nothing.")
            return await (self._observe(facts) if tool == "observe" else self._attempt(texts))
        except (BadFile, BadValue) as error:  # said without the path
            await self._let_go()  # an attempt that is not written has not been made
            _log.error("%s", error)  # for whoever started the server
            said = "The server cannot write or read its records. Call observe to see where the trial stands."
            raise CallRefused(said) from error
        finally:
            await asyncio.sleep(TOGETHER)
            self._busy = False

    async def _observe(self, client: Mapping[str, str]) -> Reply:
        self._journal.store.check()
        facts: dict[str, Fact] = {
            name: printable(without_secrets(text))[:_LONGEST_FACT].strip() for name, text in client.items()
        }
        facts["wording"] = fingerprint(INSTRUCTIONS, self._how, json.dumps(self.schemas), OVER, NO_REPORT)
        own = {(self.agent, name): facts[name] for name in SAME_IN_ALL_TRIALS}
        for (_, name), (before, now) in note(self._journal.known, own).items():
            raise CallRefused(
                f"{self.agent} played with the {name} {before!r}, and this is {now!r}. Whoever started the server "
                "gives this client another --agent-name."
            )
        while self._trial is None:
            due = self._due()
            playable = [plan for plan in due if plan.key not in self._broken]
            if not playable:
                left = f" ({len(due)} broke and are owed)" if due else ""
                raise CallRefused(f"No trial is left{left}. There is nothing more to do.")
            # the one left unfinished by the last client or server, or the first
            plan = next((plan for plan in playable if plan.key in self._log.times_begun), playable[0])
            resumed = self._log.times_begun[plan.key]
            if self._most is not None and self._begun >= self._most and not resumed:
                raise CallRefused(f"This session has played its trials ({self._most}). Start the server anew for more.")
            position = self._begun + (not resumed or not self._begun)
            trial = PausedTrial(
                plan,
                facts={**facts, "position": position, **({"resumed": resumed} if resumed else {})},
                pictures=self._journal.directory / ALBUM,
                place=self._place,
            )
            await trial.begin(self._log.attempts.get(plan.key, ()))
            if trial.trial is not None:  # it was over and had not been recorded, or its box broke
                self._record(trial)
            else:
                self._trial = trial
                self._log.write(plan.key, "begun")
            self._begun = position
        assert self._trial.situation is not None
        past = self._trial.situation.past  # of a trial that goes on
        lines = ["The trial goes on. Your steps so far:", past[0].percept.text, past[0].remark] if past else []
        for number, turn in enumerate(past, 1):
            joint, claimed = turn.decision.joint, turn.decision.claimed
            said = f"You said that your last action had {'' if claimed == 'moved' else 'not '}moved its joint. "
            line = f"{number}. {said if claimed else ''}You attempted {joint}."
            if number < len(past):  # the last report follows
                gone = "(pictures no longer shown)" if past[number].percept.pictures else ""
                line = " ".join(filter(None, (line, past[number].percept.text, gone, past[number].remark)))
            lines.append(line)
        text = instructions(self._trial.situation, self._how), "\n".join(filter(None, lines))
        return _reply(self._trial.situation, "\n\n".join(filter(None, text)))

    def _due(self) -> list[Plan]:
        plans = next_plans(self.study, self._journal)(self.agent)
        return [plan for plan in plans if self._journal.owes(plan.key)]

    async def _attempt(self, given: Mapping[str, str]) -> Reply:
        trial = self._trial
        if trial is None or trial.situation is None:
            raise CallRefused("No trial is under way, so this call did nothing. Call observe first.")
        first, claimed = trial.situation.percept.joint is None, CLAIMS.get(given.get("last_action", "none"))
        if first and claimed:
            raise CallRefused("last_action: there is no last action yet; leave it out. This call did nothing.")
        if trial.situation.task.assessment and not first and not claimed:
            raise CallRefused('last_action is missing: "moved" or "did not move". This call did nothing.')
        step = RecordedAttempt(given["joint"], claimed, hypothesis=without_keys(given.get("hypothesis", "")))
        told = await trial.attempt(step.joint, step.claimed, step.hypothesis)
        if trial.sound:
            self._log.write(trial.plan.key, "attempt", step._replace(told=told))
        if trial.trial is None:
            assert trial.situation is not None
            return _reply(trial.situation)
        self._trial = None
        self._record(trial)
        after = "Call observe for the next one." if self.owed else "No trial is left."
        end = (
            f"{OVER} {after}" if trial.sound else "The box broke, so this trial does not count. Call observe to go on."
        )
        return [types.TextContent(text=end)]

    async def _let_go(self) -> None:
        """Drop the paused trial from memory; it is replayed when it is needed."""
        trial, self._trial = self._trial, None
        if trial is not None:
            await trial.close()

    def _record(self, trial: PausedTrial) -> None:
        """Write a finished trial, unless it is on record."""
        assert trial.trial is not None
        if not trial.sound:
            self._broken.add(trial.plan.key)
            self._log.write(trial.plan.key, "broke")
        if self._journal.owes(trial.plan.key):
            self._journal.append(trial.trial, trial.seconds)


def _reply(situation: Situation, before: str = "") -> Reply:
    """The current report. Pictures get a caption, because providers refuse results without words."""
    now = " ".join(filter(None, (situation.percept.text, situation.briefing.remark))) or NO_REPORT
    text = types.TextContent(text="\n\n".join(filter(None, (before, now))))
    return [text, *(types.ImageContent(data=one.base64, mime_type="image/png") for one in situation.percept.shown)]


def make_server(session: ToolSession) -> Server[Any]:
    """The server of a session."""

    async def list_tools(
        context: ServerRequestContext[Any, Any], params: types.PaginatedRequestParams | None
    ) -> types.ListToolsResult:
        schemas = session.schemas.items()
        return types.ListToolsResult(
            tools=[types.Tool(name=name, description=_DESCRIPTIONS[name], input_schema=one) for name, one in schemas]
        )

    async def call_tool(
        context: ServerRequestContext[Any, Any], params: types.CallToolRequestParams
    ) -> types.CallToolResult:
        client = context.session.client_params
        facts = {
            "protocol": f"MCP tools {context.protocol_version}",
            "client": "" if client is None else client.client_info.name,
            "client_version": "" if client is None else client.client_info.version,
        }
        try:
            return types.CallToolResult(content=[*await session.call(params.name, params.arguments or {}, facts)])
        except CallRefused as refused:
            return types.CallToolResult(content=[types.TextContent(text=str(refused))], is_error=True)

    return Server(
        "lockprobe",
        version=version("lockprobe"),
        instructions=_INSTRUCTIONS,
        on_list_tools=list_tools,
        on_call_tool=call_tool,
    )


async def serve_stdio(session: ToolSession) -> None:
    """Serve one client until it closes standard input. Nothing else may be printed to standard output.

    Raises:
        BadValue: If standard input is a file.
    """
    reader = asyncio.StreamReader(limit=LONGEST_LINE)  # its reading can be cancelled, unlike that of a thread
    try:
        sys.stdin.fileno()  # of what is nothing of the system asyncio would leave half a transport
        await asyncio.get_running_loop().connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
    except ValueError:
        raise BadValue("standard input", "a file", "a pipe from the client that starts this command") from None
    server, lines = make_server(session), _lines(reader)
    async with stdio_server(stdin=lines) as (reading, writing):  # type: ignore[arg-type] # it is only iterated over
        await server.run(reading, writing, server.create_initialization_options())


async def _lines(reader: asyncio.StreamReader) -> AsyncIterator[str]:
    """The messages, one per line."""
    while True:
        try:
            line = await reader.readline()
        except ValueError:  # longer than the limit
            line = b"too long\n"
        if not line:
            return
        text = line.decode("utf-8", "replace")
        try:  # a client may send the arguments of a call as the text of an object
            message = json.loads(text)
            message["params"]["arguments"] = json.loads(message["params"]["arguments"])
            yield json.dumps(message)
        except (ValueError, LookupError, TypeError, RecursionError):
            yield text

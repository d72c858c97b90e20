"""The texts that a client with tools reads: the instruction and the reports.

The instruction is the one that language models get, but for how to reply. The end of a trial says neither whether the
box opened nor what the last report was, because agents that chat are told neither.
"""

from __future__ import annotations

import json
from collections.abc import Mapping

from lockprobe.agents.prompt import INSTRUCTIONS, fingerprint, instructions
from lockprobe.agents.reply import CLAIMS, LONGEST_HYPOTHESIS
from lockprobe.trial.plan import LABELS
from lockprobe.trial.record import Outcome, Percept, Situation

OVER = "The trial is over."

NO_REPORT = "(no report)"
"""What is told where an intervention leaves nothing to be told."""

_CLAIM = 'last_action is what your last action did, "moved" or "did not move"; leave it out in the first step.'

_WORKS = "hypothesis is a short sentence on how the box works, if you have one."

_SAID: Mapping[Outcome, str] = {
    "moved": "You said that your last action had moved its joint.",
    "blocked": "You said that your last action had not moved its joint.",
}

_GONE = "(pictures no longer shown)"


def reply_form(*, assessment: bool, hypothesis: bool = True) -> str:
    """How to reply with the tool ``attempt``, as a sentence of the instruction."""
    claim = f" {_CLAIM}" if assessment else ""
    works = f" {_WORKS}" if hypothesis else ""
    return (
        f"In every step call the tool attempt once. joint is the joint to attempt.{claim}{works} Wait for the result "
        "before the next call."
    )


def tool_schema(joints: int, *, assessment: bool, hypothesis: bool = True) -> dict[str, object]:
    """The arguments of ``attempt`` as a JSON schema, for a box with this many joints."""
    properties: dict[str, object] = {
        "joint": {"type": "string", "enum": list(LABELS[:joints]), "description": "The joint to attempt next."}
    }
    if assessment:
        properties["last_action"] = {
            "type": "string",
            "enum": list(CLAIMS),
            "description": "What your last action did; none, or left out, in the first step.",
        }
    if hypothesis:
        properties["hypothesis"] = {
            "type": "string",
            "maxLength": LONGEST_HYPOTHESIS,
            "description": "A short sentence on how the box works.",
        }
    return {"type": "object", "properties": properties, "required": ["joint"], "additionalProperties": False}


def wording(joints: int, *, assessment: bool, hypothesis: bool = True) -> str:
    """A fingerprint of the instruction and the tools, for the record: twelve hexadecimal digits."""
    schema = json.dumps(tool_schema(joints, assessment=assessment, hypothesis=hypothesis))
    form = reply_form(assessment=assessment, hypothesis=hypothesis)
    return fingerprint(INSTRUCTIONS, form, schema, OVER, NO_REPORT)


def instruction(situation: Situation) -> str:
    """The instruction of a trial and the current report; for a resumed trial also its steps so far."""
    task, first = situation.task, (*(turn.percept for turn in situation.past), situation.percept)[0]
    shown = sum(picture.shown for picture in first.pictures)
    text = instructions(
        task,
        positions=first.positions is not None,
        outcomes=not first.states_only,
        in_full=first.in_full,
        pictures=shown,
        labelled=not first.unlabelled,
        briefing=situation.briefing,
        reply=reply_form(assessment=task.assessment, hypothesis=situation.briefing.hypothesis != "off"),
    )
    return "\n\n".join(filter(None, (text, _so_far(situation, first), observation(situation))))


def observation(situation: Situation) -> str:
    """The current report in words. Pictures get a caption, because providers refuse results without words."""
    return " ".join(filter(None, (situation.percept.text, situation.briefing.remark))) or NO_REPORT


def _so_far(situation: Situation, first: Percept) -> str:
    """The steps so far, for a client that resumes a trial; the report of the last step follows separately."""
    past = situation.past
    if not past:
        return ""
    lines = ["The trial goes on. Your steps so far:", *filter(None, [first.text, past[0].remark])]
    for number, turn in enumerate(past, 1):
        claimed = "" if turn.decision.claimed is None else f"{_SAID[turn.decision.claimed]} "
        after = past[number] if number < len(past) else None
        gone = _GONE if after is not None and after.percept.pictures else ""
        report = () if after is None else (after.percept.text, gone, after.remark)
        lines.append(" ".join(filter(None, (f"{number}. {claimed}You attempted {turn.decision.joint}.", *report))))
    return "\n".join(lines)

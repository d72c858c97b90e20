"""Notices a server that is set up wrongly for its model: every reply holds marks of the template, or its reasoning."""

from __future__ import annotations

from collections import Counter

from lockprobe.agents.reply import mark_in, without_marks
from lockprobe.trial.model_call import Call

ENOUGH = 3
"""The first replies of an agent that all hold marks, after which it is said; once in a run."""

_REMEDIES = {
    "reasoning": "set the server's reasoning parser (vLLM, SGLang: --reasoning-parser NAME; llama.cpp: "
    "--reasoning-format auto)",
    "template": "set the model's own chat template and stop tokens (vLLM, SGLang: --chat-template FILE; llama.cpp: "
    "--jinja; Ollama: TEMPLATE and PARAMETER stop)",
}


class ServerMarks:
    """Counts the marks in the replies of each agent."""

    def __init__(self) -> None:
        self._replies: Counter[str] = Counter()
        self._clean: set[str] = set()

    def notice(self, agent: str, call: Call) -> str:
        """What to say after a call, in one line; empty for nothing."""
        if call.reply is None or not call.reply or agent in self._clean:
            return ""
        kinds = without_marks(call.reply)[1]
        if not kinds:
            self._clean.add(agent)
            return ""
        self._replies[agent] += 1
        if self._replies[agent] != ENOUGH:
            return ""
        return (
            f"{agent}: every reply so far holds marks that its server should have removed, such as "
            f"{mark_in(call.reply)!r}; they are left out and counted as tidied. To mend it, {_REMEDIES[kinds[0]]}"
        )

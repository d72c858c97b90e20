"""Inspect's ReAct agent plays a study with the tools of the server; the model is scripted."""

from pathlib import Path

import forked
import pytest

pytest.importorskip("mcp")
pytest.importorskip("inspect_ai")

from mcp_wire import served
from tool_player import SPEC, plain_records

from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.journal import load
from lockprobe.studies.running.runner import run_study

TESTS = Path(__file__).parents[2]
OPTIONS = ["--p", "0.3", "--trials", "2", "--repetitions", "1", "--max-steps", "8"]

AGENT = """
import asyncio, sys
sys.path.insert(0, sys.argv.pop())
from inspect_ai import Task, eval
from inspect_ai.agent import react
from inspect_ai.dataset import Sample
from inspect_ai.model import ChatMessageTool, ModelOutput, ModelUsage, get_model
from inspect_ai.tool import mcp_server_http
from tool_player import Player

def output(tool, given):
    made = ModelOutput.for_tool_call("mockllm", tool, given)
    made.usage = ModelUsage(total_tokens=1)  # else they are counted with a file from the network
    return made

class Model:
    "A tool call for every call of the player, then submit."
    player = None
    async def __call__(self, messages, tools, tool_choice, config):
        if self.player is None:
            self.calls, self.results = asyncio.Queue(), asyncio.Queue()
            self.player = asyncio.create_task(Player(self.call).play())
        elif isinstance(last := messages[-1], ChatMessageTool):
            self.results.put_nowait(None if last.error else last.text)
        asked = asyncio.create_task(self.calls.get())
        await asyncio.wait({asked, self.player}, return_when=asyncio.FIRST_COMPLETED)
        if asked.done():
            return output(*asked.result())
        asked.cancel()
        return output("submit", {"answer": str(self.player.result())})
    async def call(self, tool, given):
        self.calls.put_nowait((tool, given))
        return await self.results.get()

url, token, logs = sys.argv[1:]
server = mcp_server_http(name="lockprobe", url=url, headers={"Authorization": token})
task = Task(dataset=[Sample(input="Open the boxes.")], solver=react(tools=[server]))
model = get_model("mockllm/model", custom_outputs=Model(), memoize=False)
(log,) = eval(task, model=model, display="none", log_dir=logs, score=False)
print(log.status, log.samples[0].output.completion if log.status == "success" else log.error.message)
"""


def test_the_react_agent_plays_a_study(tmp_path):
    (tmp_path / "project").mkdir()
    with served(tmp_path / "S", tmp_path / "project", OPTIONS) as (url, headers):
        done = forked.run([url, headers["Authorization"], tmp_path / "logs", TESTS], script=AGENT)
    said = done.stdout.split() or [done.stderr]
    assert (said[0], said[-1]) == ("success", "2"), done.stdout + done.stderr
    run_study(study("flips", agent=[SPEC], p=[0.3], trials=2, repetitions=1, max_steps=8), tmp_path / "alone")
    assert plain_records(tmp_path / "S") == plain_records(tmp_path / "alone")
    assert {trial.facts["client"] for trial in load(tmp_path / "S")} == {"mcp"}

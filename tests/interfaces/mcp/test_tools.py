"""The tools as the SDK's own client calls them in this process, in both ages of the protocol."""

import asyncio
import base64

import pytest

pytest.importorskip("mcp")

from mcp import Client
from seen import PhotographedPlant
from tool_player import AGENT, SPEC, Player, plain_records

from lockprobe.interfaces.mcp.session import ToolSession
from lockprobe.interfaces.mcp.tools import make_server
from lockprobe.plants import catalogue
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study
from lockprobe.trial.pictures.png import from_png

STUDY = {"p": [0.4], "trials": 2, "repetitions": 1, "max_steps": 12}


def with_client(directory, do, mode="auto", **more):
    """What a coroutine that gets a client gives."""

    async def run():
        planned = study("flips", agent=[AGENT], **{**STUDY, **more})
        async with (
            ToolSession.open(directory, planned, AGENT, together=0.0) as session,
            Client(make_server(session), mode=mode) as client,
        ):
            return await do(client)

    return asyncio.run(run())


@pytest.mark.parametrize("mode", ["auto", "legacy"])
@pytest.mark.parametrize("assessment", [True, False])
def test_any_client_plays_a_study(tmp_path, mode, assessment):
    async def play(client):
        async def call(tool, given):
            result = await client.call_tool(tool, given)
            return None if result.is_error else result.content[0].text

        return await Player(call, assessment).play()

    assert with_client(tmp_path / "tools", play, mode, assessment=assessment) == 2
    run_study(study("flips", agent=[SPEC], **STUDY, assessment=assessment), tmp_path / "alone")
    assert plain_records(tmp_path / "tools") == plain_records(tmp_path / "alone")
    facts = load(tmp_path / "tools")[0].facts
    assert facts["protocol"] == ("MCP tools 2026-07-28" if mode == "auto" else "MCP tools 2025-11-25")


WRONG = {
    "joint is missing": ("attempt", {}),
    "joint: expected text, got int": ("attempt", {"joint": 1}),
    "joint: expected text, got list": ("attempt", {"joint": ["A"]}),
    "attempt has no argument 'step'": ("attempt", {"joint": "A", "step": 1}),
    "observe has no argument 'truth'": ("observe", {"truth": True}),
    "no tool is called 'solve'": ("solve", {}),
    "is none of": ("attempt", {"joint": "A" * 100_000}),
    "hypothesis: at most 4000": ("attempt", {"joint": "A", "hypothesis": "x" * 100_000}),
}


@pytest.mark.parametrize("why", WRONG)
def test_a_wrong_call_is_a_result_that_the_model_reads(tmp_path, why):
    tool, given = WRONG[why]

    async def call(client):
        await client.call_tool("observe", {})
        before = {path: path.read_bytes() for path in tmp_path.iterdir()}
        result = await client.call_tool(tool, given)
        assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
        return result

    result = with_client(tmp_path, call)
    assert result.is_error
    assert why in result.content[0].text
    assert len(result.content[0].text) < 200


def test_optional_arguments_may_be_null(tmp_path):
    async def call(client):
        await client.call_tool("observe", {})
        return await client.call_tool("attempt", {"joint": "A", "last_action": None, "hypothesis": None})

    assert not with_client(tmp_path, call).is_error


def test_the_tools_are_listed_and_nothing_structured_is_said(tmp_path):
    async def call(client):
        return (await client.list_tools()).tools, await client.call_tool("observe", {})

    tools, begun = with_client(tmp_path, call)
    assert [tool.name for tool in tools] == ["observe", "attempt"]
    assert [tool.output_schema for tool in tools] == [None] * 2
    assert begun.structured_content is None
    assert [content.type for content in begun.content] == ["text"]


@pytest.mark.parametrize(("modality", "pictures"), [("rgb", 1), ("rgbd", 2)])
def test_pictures_are_image_content(tmp_path, monkeypatch, modality, pictures):
    source = catalogue.PlantSource(spec="fast-twin", make=lambda box, labels, rng: PhotographedPlant(box))
    for room in ("plants.catalogue", "interfaces.mcp.session"):
        monkeypatch.setattr(f"lockprobe.{room}.resolve_plant", lambda spec: source)

    async def call(client):
        await client.call_tool("observe", {})
        return await client.call_tool("attempt", {"joint": "A"})

    shown = with_client(tmp_path, call, p=[0.0], plant="fast-twin", modality=[modality])
    kinds = [content.type for content in shown.content]
    assert kinds == ["text", *["image"] * pictures]
    files = [base64.b64decode(content.data) for content in shown.content[1:]]
    assert {content.mime_type for content in shown.content[1:]} == {"image/png"}
    assert from_png(files[0]).shape == (6, 8, 3)
    assert {path.read_bytes() for path in (tmp_path / "pictures").iterdir()} >= set(files)

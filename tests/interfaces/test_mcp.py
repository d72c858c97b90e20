"""A study played with tools: records like any other agent's, nothing lost, and no refused call changes a file."""

import asyncio
import base64
import json

import pytest

pytest.importorskip("mcp")

from mcp import Client
from seen import PhotographedPlant
from stored import contents, records, sql, timings
from tool_player import AGENT, FACTS, SPEC, Player, calls, plain_records

from lockprobe.agents.catalogue import SAME_IN_ALL_TRIALS
from lockprobe.agents.prompt import conversation
from lockprobe.foundation.errors import BadFile, BadValue
from lockprobe.interfaces import mcp as module
from lockprobe.interfaces.mcp import CallRefused, ToolSession, make_server
from lockprobe.plants import catalogue
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study

STUDY = {"p": [0.0, 0.3], "trials": 2, "repetitions": 2, "max_steps": 12}


def planned(agent=AGENT, **more):
    return study("flips", agent=[agent], **{**STUDY, **more})


def opened(directory, a_study=None, agent=AGENT, **options):
    return ToolSession.open(directory, a_study or planned(), agent, **options)


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """One call waits for no other."""
    monkeypatch.setattr(module, "TOGETHER", 0.0)


async def observe(session, **facts):
    return await session.call("observe", {}, FACTS | facts)


async def attempt(session, joint, last_action=None):
    return await session.call("attempt", {"joint": joint, "last_action": last_action}, FACTS)


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    directory = tmp_path_factory.mktemp("alone")
    run_study(planned(SPEC), directory)
    return plain_records(directory)


async def test_records_are_those_of_the_same_policy_played_directly(tmp_path, alone):
    async with opened(tmp_path) as session:
        assert session.owed == 8
        assert await Player(calls(session)).play() == 8
        assert session.owed == 0
    assert plain_records(tmp_path) == alone
    facts = [dict(trial.facts) for trial in load(tmp_path)]
    assert [one.pop("position") for one in facts] == list(range(1, 9))
    assert all(one == facts[0] for one in facts)
    assert {*SAME_IN_ALL_TRIALS, *FACTS} == {*facts[0]}
    assert timings(tmp_path, "steps") == [len(trial.steps) for trial in load(tmp_path)]


def test_a_study_stops_when_it_is_decided(tmp_path):
    def stops(agent):
        return study("flips", agent=[agent], p=[0.0, 0.3], until="±45", trials=40, max_steps=12)

    async def play():
        async with opened(tmp_path / "tools", stops(AGENT)) as session:
            return await Player(calls(session)).play()

    assert 10 < asyncio.run(play()) < 80
    run_study(stops(SPEC), tmp_path / "alone")
    assert plain_records(tmp_path / "tools") == plain_records(tmp_path / "alone")


def test_a_server_that_is_gone_at_any_step_loses_nothing(tmp_path, alone):
    """A new server after every single step; the one before is dropped without a word, as by a kill."""

    async def play():
        steps, done = 0, False
        while not done:
            async with opened(tmp_path, planned(repetitions=1, trials=1)) as session:
                player = Player(calls(session))
                done = not await player.begin()
                if not done:
                    steps += 1
                    await player.step()
                    session._trial = None  # nothing is said or written
        return steps

    assert asyncio.run(play()) == sum(len(trial.steps) for trial in load(tmp_path))
    assert plain_records(tmp_path).items() <= alone.items()
    assert [trial.facts.get("resumed", 0) for trial in load(tmp_path)] == [len(t.steps) - 1 for t in load(tmp_path)]


async def test_a_trial_that_ended_before_it_was_recorded_is_recorded_by_the_next_server(tmp_path, alone, monkeypatch):
    async with opened(tmp_path) as session:
        monkeypatch.setattr(session, "_record", lambda trial: None)
        player = Player(calls(session))
        await player.begin()
        while await player.step():
            pass
    assert records(tmp_path) == []
    async with opened(tmp_path) as session:
        await Player(calls(session)).play()
    assert plain_records(tmp_path) == alone


REFUSED = [
    ("attempt", {}, "joint: '' is none of"),
    ("attempt", {"joint": "A" * 10**6}, "is none of"),
    ("attempt", {"joint": '{"joint": "A"}'}, "is none of"),
    ("attempt", {"joint": 1}, "joint: '1' is none of A, B, C, D"),
    ("attempt", {"joint": ["A"]}, "is none of A, B, C, D"),
    ("attempt", {"joint": "A", "step": "1"}, "attempt has no argument 'step'; it takes joint, last_action, hypothesis"),
    ("attempt", {"joint": "A"}, "last_action is missing"),
    ("attempt", {"joint": "A", "last_action": "none"}, "last_action is missing"),
    ("attempt", {"joint": "A", "last_action": "perhaps"}, "is none of moved, did not move, none"),
    ("attempt", {"joint": "A", "last_action": "moved", "hypothesis": "x" * 4001}, "a text of at most 4000"),
    ("attempt", {"joint": "A", "last_action": "moved", "hypothesis": 1}, "hypothesis: a text of at most 4000"),
    ("observe", {"truth": True}, "observe has no argument 'truth'; it takes no argument"),
    ("solve", {}, "no tool is called 'solve'; there are observe and attempt"),
]


def with_client(directory, do, mode="auto", **more):
    """What a coroutine gives that gets a session and the SDK's own client of it, in this process."""

    async def run():
        async with opened(directory, planned(**more)) as session, Client(make_server(session), mode=mode) as client:
            return await do(session, client)

    return asyncio.run(run())


def test_a_refused_call_says_why_and_changes_nothing(tmp_path):
    """As a result that the model reads."""

    async def play(session, client):
        assert (await client.call_tool("attempt", {"joint": "A"})).is_error  # no trial is under way
        await client.call_tool("observe", {})
        first = {"joint": "A", "last_action": "moved"}
        assert (await client.call_tool("attempt", first)).is_error  # nothing is done yet
        nothing = {"last_action": None, "hypothesis": None}
        assert not (await client.call_tool("attempt", {"joint": "A", **nothing})).is_error
        before, seen = contents(tmp_path), await client.call_tool("observe", {})
        for tool, given, why in REFUSED:
            refused = await client.call_tool(tool, given)
            assert refused.is_error
            assert why in refused.content[0].text
            assert len(refused.content[0].text) < 200
            assert (contents(tmp_path), await client.call_tool("observe", {})) == (before, seen)

    with_client(tmp_path, play)


@pytest.mark.parametrize(("mode", "asked"), [("auto", {}), ("legacy", {"assessment": False})])
def test_any_client_plays_what_a_model_is_asked(tmp_path, mode, asked):
    """In both ages of the protocol; the instruction is that of the chat protocol but for how to reply."""

    async def play(session, client):
        tools = (await client.list_tools()).tools
        begun = await client.call_tool("observe", {})
        chat = conversation(session._trial.situation)[0].text.splitlines()
        told = begun.content[0].text.splitlines()
        assert (told[:3], told[4]) == (chat[:3], chat[-3])
        named = ["last_action"] * (not asked) + ["hypothesis"]
        assert [name for name in ("last_action", "hypothesis") if name in told[3]] == named
        assert [*tools[1].input_schema["properties"]] == ["joint", *named]
        assert [tool.output_schema for tool in tools] == [None] * 2
        assert (begun.structured_content, [part.type for part in begun.content]) == (None, ["text"])

        async def call(tool, given):
            result = await client.call_tool(tool, given)
            return None if result.is_error else result.content[0].text

        return await Player(call, assessment=not asked).play()

    assert with_client(tmp_path / "tools", play, mode, trials=1, **asked) == 4
    assert load(tmp_path / "tools")[0].facts["protocol"].startswith("MCP tools 20")
    if not asked:
        run_study(planned(SPEC, trials=1), tmp_path / "alone")
        assert plain_records(tmp_path / "tools") == plain_records(tmp_path / "alone")


async def test_calls_at_once_are_one_call_and_refusals(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "TOGETHER", 0.01)
    async with opened(tmp_path) as session:
        await observe(session)
        many = [attempt(session, joint) for joint in "ABCD" * 5]
        got = await asyncio.gather(*many, observe(session), return_exceptions=True)
        refused = [one for one in got if isinstance(one, CallRefused)]
        assert len(refused) == len(got) - 1
        assert all("one call at a time" in str(one) for one in refused)
        assert len(sql(tmp_path, "select id from attempt where kind = 'attempt'")) == 1


async def test_a_client_that_stops_waiting_interrupts_no_attempt(tmp_path):
    lost = []
    asyncio.get_running_loop().set_exception_handler(lambda loop, context: lost.append(context["message"]))
    async with opened(tmp_path) as session:
        await observe(session)
        for joint in ("no joint", "A"):
            waiting = asyncio.create_task(attempt(session, joint))
            await asyncio.sleep(0)
            waiting.cancel()
            await asyncio.sleep(0.1)
        assert "You attempted A." in (await observe(session))[0].text
    assert lost == []


async def test_a_session_may_have_its_number_of_trials(tmp_path):
    for _ in range(4):
        async with opened(tmp_path, trials_each=2) as session:
            assert await Player(calls(session)).play() == 2
            with pytest.raises(CallRefused, match=r"played its trials \(2\). Start the server|No trial is left"):
                await observe(session)
    assert [trial.facts["position"] for trial in load(tmp_path)] == [1, 2] * 4


async def test_another_way_to_play_is_another_agent(tmp_path, monkeypatch):
    async with opened(tmp_path) as session:
        await Player(calls(session)).play(1)
        with pytest.raises(CallRefused, match="the client 'test', and this is 'other'.*another --agent-name"):
            await observe(session, client="other")
        monkeypatch.setattr(module, "OVER", "Over.")
        with pytest.raises(CallRefused, match="with the wording .*another --agent-name"):
            await observe(session)
    async with opened(tmp_path, planned("mcp:other"), "mcp:other") as session:
        assert session.owed == 8


async def test_a_full_disk_undoes_the_attempt(tmp_path, monkeypatch):
    def refuse(*row):
        raise BadFile("study.db", "cannot be written (No space left on device)")

    async with opened(tmp_path) as session:
        await observe(session)
        before = contents(tmp_path)
        with monkeypatch.context() as full:
            full.setattr(session._log, "write", refuse)
            with pytest.raises(CallRefused, match="where the trial stands"):
                await attempt(session, "A")
        assert contents(tmp_path) == before
        assert "goes on" not in (await observe(session))[0].text


async def test_a_box_that_breaks_is_an_error_and_is_played_again_from_its_first_step(tmp_path, monkeypatch, alone):
    class Stuck(SymbolicPlant):
        left = 2

        def attempt(self, joint):
            Stuck.left -= 1
            if not Stuck.left:
                raise OSError("stuck")
            return super().attempt(joint)

    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: Stuck(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)
    async with opened(tmp_path) as session:
        player = Player(calls(session))
        await player.begin()
        await player.step()
        assert (await attempt(session, "A", "moved"))[0].text.startswith("The box broke")
        assert await player.play() == 7
        with pytest.raises(CallRefused, match="1 broke and are owed"):
            await observe(session)
    async with opened(tmp_path) as session:
        assert await Player(calls(session)).play() == 1
    assert sql(tmp_path, "delete from trial where ending = 'error' returning current") == [0]
    assert plain_records(tmp_path) == alone


@pytest.mark.parametrize(("modality", "pictures"), [("rgb", 1), ("rgbd", 2)])
def test_pictures_are_image_content_and_kept(tmp_path, monkeypatch, modality, pictures):
    source = catalogue.PlantSource(spec="fast-twin", make=lambda box, labels, rng: PhotographedPlant(box))
    for room in ("plants.catalogue", "interfaces.mcp"):
        monkeypatch.setattr(f"lockprobe.{room}.resolve_plant", lambda spec: source)

    async def play(session, client):
        replies = [await client.call_tool("observe", {})]
        replies.append(await client.call_tool("attempt", {"joint": "A"}))
        replies.append(await client.call_tool("observe", {}))
        for reply in replies:
            assert [content.type for content in reply.content] == ["text", *["image"] * pictures]
            files = {base64.b64decode(content.data) for content in reply.content[1:]}
            assert files <= {path.read_bytes() for path in (tmp_path / "pictures").iterdir()}
        assert "At 1" not in replies[1].content[0].text

    with_client(tmp_path, play, p=[0.0], plant="fast-twin", modality=[modality])


@pytest.mark.parametrize("name", ["a\nb", "x" * 10_000, "\u202ename", "sk-ant-0123456789abcdef"])
async def test_what_a_client_says_of_itself_is_short_and_plain(tmp_path, name):
    async with opened(tmp_path, planned(trials=1, repetitions=1, p=[0.0], max_steps=1)) as session:
        await observe(session, client=name)
        await attempt(session, "A")
    client = load(tmp_path)[0].facts["client"]
    assert len(client) <= 100
    assert client.isprintable()
    assert "0123456789" not in client


def test_a_run_does_not_play_clients_and_says_who_does(tmp_path):
    with pytest.raises(BadValue, match="lockprobe mcp"):
        run_study(planned(), tmp_path / "alone")
    run_study(study("flips", agent=["random", AGENT], **STUDY), tmp_path / "both")
    assert {trial.agent for trial in load(tmp_path / "both")} == {"random"}

    async def play():
        async with opened(tmp_path / "both") as session:
            await Player(calls(session)).play()

    asyncio.run(play())
    assert json.loads((tmp_path / "both" / "study.json").read_text())["agents"] == ["random", AGENT]
    assert len({(trial.p, trial.repetition, trial.trial, trial.labels) for trial in load(tmp_path / "both")}) == 8

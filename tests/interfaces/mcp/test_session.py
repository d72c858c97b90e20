"""A study played with tools: records like any other agent's, nothing lost, and no call that is refused changes a file."""

import asyncio
import gc
import json
from dataclasses import replace

import pytest
from seen import PhotographedPlant
from stored import contents, records, sql, timings
from tool_player import AGENT, SPEC, Player, calls, plain_records

from lockprobe.agents.outside import SAME_IN_ALL_TRIALS
from lockprobe.foundation.errors import BadFile, BadValue, DirectoryBusy, SettingsChanged
from lockprobe.interfaces.mcp import wording
from lockprobe.interfaces.mcp.session import CallRefused, Connection, ToolSession, facts_of
from lockprobe.plants import catalogue
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study

STUDY = {"p": [0.0, 0.3], "trials": 2, "repetitions": 2, "max_steps": 12}
STDIO = Connection(client="test", version="1")


def planned(agent=AGENT, **more):
    return study("flips", agent=[agent], **{**STUDY, **more})


def opened(directory, a_study=None, agent=AGENT, **options):
    return ToolSession.open(directory, a_study or planned(), agent, **{"together": 0.0, **options})


def attempts(directory):
    return sql(directory, "select entry from attempt where entry ->> 'kind' = 'attempt'")


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    directory = tmp_path_factory.mktemp("alone")
    run_study(planned(SPEC), directory)
    return plain_records(directory)


def test_records_are_those_of_the_same_policy_played_directly(tmp_path, alone):
    async def play():
        async with opened(tmp_path) as session:
            assert session.owed == 8
            assert await Player(calls(session)).play() == 8
            assert session.owed == 0

    asyncio.run(play())
    assert plain_records(tmp_path) == alone
    facts = [dict(trial.facts) for trial in load(tmp_path)]
    assert [one.pop("position") for one in facts] == list(range(1, 9))
    assert all(one == facts[0] for one in facts)
    assert facts[0]["client"] == "test"
    assert [timing.steps for timing in timings(tmp_path)] == [len(trial.steps) for trial in load(tmp_path)]


def test_a_study_stops_when_it_is_decided(tmp_path):
    def stops(agent):
        return study("flips", agent=[agent], p=[0.0, 0.3], until="±45", most=40, max_steps=12)

    async def play():
        async with opened(tmp_path / "tools", stops(AGENT)) as session:
            assert session.owed == 10
            played = await Player(calls(session)).play()
            assert session.owed == 0
            return played

    assert 10 < asyncio.run(play()) < 80
    run_study(stops(SPEC), tmp_path / "alone")
    assert plain_records(tmp_path / "tools") == plain_records(tmp_path / "alone")


def test_an_agent_is_added_to_a_study_and_shares_its_luck(tmp_path, alone):
    run_study(planned(SPEC), tmp_path)

    async def play():
        async with opened(tmp_path) as session:
            await Player(calls(session)).play()

    asyncio.run(play())
    trials = load(tmp_path)
    by_agent = {agent: [t for t in trials if t.agent == agent] for agent in (SPEC, AGENT)}
    places = [[(t.p, t.repetition, t.trial, t.labels, t.steps) for t in of] for of in by_agent.values()]
    assert places[0] == places[1]
    assert json.loads((tmp_path / "study.json").read_text())["agents"] == [SPEC, AGENT]


def test_a_server_that_is_gone_at_any_step_loses_nothing(tmp_path, alone):
    """A new server after every single step; the one before is dropped without a word, as by a kill."""

    async def play():
        steps, done = 0, False
        while not done:
            async with opened(tmp_path) as session:
                player = Player(calls(session))
                done = not await player.begin()
                if not done:
                    steps += 1
                    await player.step()
                    session._trial = None  # nothing is said or written
        return steps

    assert asyncio.run(play()) == sum(len(trial.steps) for trial in load(tmp_path))
    assert plain_records(tmp_path) == alone
    assert [trial.facts.get("resumed", 0) for trial in load(tmp_path)] == [len(t.steps) - 1 for t in load(tmp_path)]


def test_a_trial_that_ended_before_it_was_recorded_is_recorded_by_the_next_server(tmp_path, alone, monkeypatch):
    async def play():
        async with opened(tmp_path) as session:
            monkeypatch.setattr(session, "_record", lambda trial: None)
            player = Player(calls(session))
            await player.begin()
            while await player.step():
                pass
        assert records(tmp_path) == []
        async with opened(tmp_path) as session:
            await Player(calls(session)).play()

    asyncio.run(play())
    assert plain_records(tmp_path) == alone


REFUSED = {
    "unknown joint": ({"joint": "Z"}, "is none of"),
    "empty joint": ({"joint": ""}, "is none of"),
    "huge joint": ({"joint": "A" * 10**6}, "is none of"),
    "half a character": ({"joint": "\ud800"}, "is none of"),
    "no claim": ({"joint": "A"}, "last_action is missing"),
    "no claim in words": ({"joint": "A", "last_action": "none"}, "last_action is missing"),
    "another claim": ({"joint": "A", "last_action": "perhaps"}, "is none of moved, did not move, none"),
    "huge hypothesis": ({"joint": "A", "last_action": "moved", "hypothesis": "x" * 4001}, "at most 4000"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_refused_call_says_why_and_changes_nothing(tmp_path, name):
    given, why = REFUSED[name]

    async def play():
        async with opened(tmp_path) as session:
            await session.observe(STDIO)
            await session.attempt("A", "none")
            before, seen = contents(tmp_path), await session.observe(STDIO)
            with pytest.raises(CallRefused, match=why) as refused:
                await session.attempt(**given)
            assert len(str(refused.value)) < 200
            assert (contents(tmp_path), await session.observe(STDIO)) == (before, seen)

    asyncio.run(play())


def test_calls_without_a_beginning_and_after_the_end_change_nothing(tmp_path):
    async def play():
        async with opened(tmp_path, planned(trials=1, repetitions=1, p=[0.0])) as session:
            before = contents(tmp_path)
            with pytest.raises(CallRefused, match="Call observe first"):
                await session.attempt("A")
            assert contents(tmp_path) == before
            player = Player(calls(session))
            await player.begin()
            with pytest.raises(CallRefused, match="no last action yet"):
                await session.attempt("A", "moved")
            while await player.step():
                pass
            before = contents(tmp_path)
            with pytest.raises(CallRefused, match="No trial is left"):
                await session.observe(STDIO)
            with pytest.raises(CallRefused, match="observe first"):
                await session.attempt("A", "moved")
            assert contents(tmp_path) == before

    asyncio.run(play())


def test_calls_at_once_are_one_call_and_refusals(tmp_path):
    async def play():
        async with opened(tmp_path, together=0.01) as session:
            await session.observe(STDIO)
            many = [session.attempt(joint) for joint in "ABCD" * 5]
            got = await asyncio.gather(*many, session.observe(STDIO), return_exceptions=True)
            refused = [one for one in got if isinstance(one, CallRefused)]
            assert len(refused) == len(got) - 1
            assert all("one call at a time" in str(one) for one in refused)
            assert len(attempts(tmp_path)) == 1

    asyncio.run(play())


def test_a_client_that_stops_waiting_interrupts_no_attempt(tmp_path):
    async def play():
        async with opened(tmp_path, together=0.001) as session:
            await session.observe(STDIO)
            waiting = asyncio.create_task(session.attempt("A"))
            await asyncio.sleep(0)
            waiting.cancel()
            await asyncio.sleep(0.1)
            assert len(attempts(tmp_path)) == 1
            assert "You attempted A." in (await session.observe(STDIO)).text

    asyncio.run(play())


def test_a_session_may_have_its_number_of_trials(tmp_path):
    async def play():
        for _ in range(4):
            async with opened(tmp_path, trials_each=2) as session:
                assert await Player(calls(session)).play() == 2
                with pytest.raises(
                    CallRefused, match=r"played its trials \(2\). Start the server anew|No trial is left"
                ):
                    await session.observe(STDIO)

    asyncio.run(play())
    assert [trial.facts["position"] for trial in load(tmp_path)] == [1, 2] * 4


def test_a_refused_call_whose_client_has_gone_is_retrieved(tmp_path):
    async def play():
        lost = []
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: lost.append(context["message"]))
        async with opened(tmp_path) as session:
            await session.observe(STDIO)
            call = asyncio.ensure_future(session.attempt("no joint"))
            await asyncio.sleep(0)
            call.cancel()
            await asyncio.wait([call])
            await asyncio.sleep(0.05)
            del call
            gc.collect()
        return lost

    assert asyncio.run(play()) == []


def test_another_way_to_play_is_another_agent(tmp_path, monkeypatch):
    async def play():
        async with opened(tmp_path) as session:
            await Player(calls(session)).play(1)
            with pytest.raises(CallRefused, match="another --agent-name"):
                await session.observe(replace(STDIO, client="other"))
        monkeypatch.setattr(wording, "OVER", "Over.")
        with pytest.raises(SettingsChanged, match="mcp:scripted, wording"):
            async with opened(tmp_path):
                pass
        async with opened(tmp_path, planned("mcp:other"), "mcp:other") as session:
            assert session.owed == 8

    asyncio.run(play())


def test_one_process_plays_a_study_at_a_time(tmp_path):
    async def play():
        async with opened(tmp_path):
            with pytest.raises(DirectoryBusy):
                async with opened(tmp_path):
                    pass

    asyncio.run(play())


def test_steps_on_disk_hold_a_study_to_its_settings(tmp_path):
    async def play():
        async with opened(tmp_path) as session:
            await session.observe(STDIO)
        with pytest.raises(SettingsChanged, match="seed"):
            async with opened(tmp_path, planned(seed=2)):
                pass
        with pytest.raises(ZeroDivisionError):
            async with opened(tmp_path):
                raise ZeroDivisionError
        async with opened(tmp_path) as session:
            assert await Player(calls(session)).play() == 8

    asyncio.run(play())


def test_a_report_that_differs_from_the_one_on_disk_is_never_told(tmp_path, monkeypatch):
    async def play():
        async with opened(tmp_path) as session:
            player = Player(calls(session))
            await player.begin()
            await player.step()
        monkeypatch.setattr(SymbolicPlant, "attempt", lambda self, joint: self.observe())
        async with opened(tmp_path) as session:
            with pytest.raises(CallRefused, match="cannot write or read its records") as refused:
                await session.observe(STDIO)
            assert "as it was shown before" in str(refused.value.__cause__)
            assert str(tmp_path) not in str(refused.value)

    asyncio.run(play())


def test_a_full_disk_undoes_the_attempt(tmp_path, monkeypatch):
    async def play():
        async with opened(tmp_path) as session:
            await session.observe(STDIO)
            before = contents(tmp_path)
            with monkeypatch.context() as full:

                def refuse(key, entry):
                    raise BadFile("study.db", "cannot be written (No space left on device)")

                full.setattr(session._log, "_write", refuse)
                with pytest.raises(CallRefused, match="did nothing"):
                    await session.attempt("A")
            assert contents(tmp_path) == before
            assert "goes on" not in (await session.observe(STDIO)).text

    asyncio.run(play())


class _Stuck(SymbolicPlant):
    breaks = 2

    def attempt(self, joint):
        type(self).breaks -= 1
        if type(self).breaks == 0:
            raise OSError("stuck")
        return super().attempt(joint)


def test_a_box_that_breaks_is_an_error_and_is_played_again_from_its_first_step(tmp_path, monkeypatch, alone):
    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: _Stuck(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)

    async def play():
        async with opened(tmp_path) as session:
            player = Player(calls(session))
            await player.begin()
            await player.step()
            reply = await session.attempt("A", "moved")
            assert reply.text.startswith("The box broke")
            assert await player.play() == 7
            assert session.owed == 1
            with pytest.raises(CallRefused, match="1 broke and are owed"):
                await session.observe(STDIO)
        async with opened(tmp_path) as session:
            assert await Player(calls(session)).play() == 1

    asyncio.run(play())
    assert sql(tmp_path, "delete from trial where ending = 'error' returning current") == [0]
    assert plain_records(tmp_path) == alone


def test_pictures_are_shown_and_kept(tmp_path, monkeypatch):
    source = catalogue.PlantSource(spec="fast-twin", make=lambda box, labels, rng: PhotographedPlant(box))
    for room in ("plants.catalogue", "interfaces.mcp.session"):
        monkeypatch.setattr(f"lockprobe.{room}.resolve_plant", lambda spec: source)
    shown = planned(p=[0.0], plant="fast-twin", modality=["rgb", "rgbd"])

    async def play():
        async with opened(tmp_path, shown) as session:
            for pictures in (1, 2):
                replies = [await session.observe(STDIO)]
                replies.append(await session.attempt("A"))
                replies.append(await session.observe(STDIO))
                assert [len(reply.pictures) for reply in replies] == [pictures] * 3
                assert "At 1" not in replies[1].text
                kept = {path.name for path in (tmp_path / "pictures").iterdir()}
                assert {picture.name for reply in replies for picture in reply.pictures} <= kept
                reply = replies[1]
                while reply.pictures:
                    reply = await session.attempt("A", "moved")

    asyncio.run(play())


def test_a_condition_that_cannot_act_on_a_client_is_refused_before_anything_is_written(tmp_path):
    async def play():
        with pytest.raises(BadValue, match="history"):
            async with opened(tmp_path / "new", study("flips", agent=[AGENT], condition=["history?last=2"])):
                pass
        assert not (tmp_path / "new").exists()

    asyncio.run(play())


def test_a_run_does_not_play_clients_and_says_who_does(tmp_path):
    with pytest.raises(BadValue, match="lockprobe mcp"):
        run_study(planned(), tmp_path / "alone")
    trials = run_study(study("flips", agent=["random", AGENT], **STUDY), tmp_path / "both")
    assert {trial.agent for trial in trials} == {"random"}


def facts(**said):
    connection = Connection(**{"client": "name", "version": "1.2", "protocol": "2025-11-25", **said})
    return facts_of(connection, "0f", position=3, resumed=0)


def test_the_facts_say_how_the_agent_was_connected():
    assert facts() == {
        "protocol": "MCP tools 2025-11-25",
        "client": "name",
        "client_version": "1.2",
        "wording": "0f",
        "position": 3,
    }
    assert {*SAME_IN_ALL_TRIALS} <= {*facts()}
    resumed = facts_of(Connection(), "0f", position=1, resumed=2)
    assert (resumed["resumed"], resumed["client"], resumed["protocol"]) == (2, "", "MCP tools")


@pytest.mark.parametrize("name", ["a\nb", "x" * 10_000, "\u202ename", "sk-ant-0123456789abcdef"])
def test_what_a_client_says_of_itself_is_short_and_plain(name):
    client = facts(client=name)["client"]
    assert len(client) <= 100
    assert client.isprintable()
    assert "0123456789" not in client

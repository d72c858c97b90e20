"""The server as a whole: many at once, killed and started again, stopped; nobody loses or repeats a step."""

import asyncio
import json
import random
import signal
from urllib.parse import urlsplit

import pytest
from seated import as_played, diaries_of, without_page
from served import EXPERIMENT, STUDY, at_the_box, served, visiting
from stored import records
from visitor import Visitor, start
from wire import Wire

from lockprobe import load
from lockprobe.people.diary import Did
from lockprobe.people.experiment import read_words
from lockprobe.people.web.address import Address
from lockprobe.people.web.app import opened
from lockprobe.studies.records.directory import read_study

KILLS = 4
"""How often the server is killed while they play."""

STRATEGIES = ("human-inspired", "random", "ideal-observer", "random-no-repeat", "round-robin")
SILENT = ("random", "random-no-repeat", "round-robin")
"""Those that say nothing of their last action, and are asked."""


async def come(where, directory, study, number, **settings):
    """So many visitors, each with a strategy and a platform ID of its own, from the first scene to the last."""
    visitors = [
        Visitor(
            where["url"],
            study,
            directory,
            strategy=STRATEGIES[i % len(STRATEGIES)],
            platform={"PROLIFIC_PID": f"person-{i}"},
            luck=random.Random(i),
        )
        for i in range(number)
    ]
    try:
        await asyncio.gather(*(visitor.play(**settings) for visitor in visitors))
    finally:
        await asyncio.gather(*(visitor.close() for visitor in visitors))
    return visitors


def check_nothing_lost_doubled_or_crossed(directory, study, visitors):
    """What is on disk is what each visitor did and was shown, and the trials are the strategies' own."""
    assert {visitor.scene["kind"] for visitor in visitors} == {"debrief"}
    who = {f"participant:{visitor.identity}": visitor for visitor in visitors}
    assert len(who) == len(visitors)
    trials = load(directory)
    assert len(trials) == len({trial.key for trial in trials}) == 2 * len(visitors)
    assert len(records(directory)) == len(trials)
    played = {agent: {} for agent in who}
    for trial in trials:
        strategy = who[trial.agent].strategy
        said = strategy not in SILENT
        assert as_played(trial, claims=said) == as_played(without_page(study, trial, strategy), claims=said)
        played[trial.agent][trial.facts["position"]] = trial
    for diary in diaries_of(directory):
        visitor = who[f"participant:{diary[0].identity}"]
        assert [line.turn for line in diary[1:]] == list(range(2, len(diary) + 1))
        assert all(isinstance(line, Did) for line in diary[1:])
        assert [seen.turn for seen in visitor.seen] == list(range(1, len(diary) + 2))
        shown = [seen.scene for seen in visitor.seen if seen.scene["kind"] == "box"]
        told = [line.told for line in diary[1:] if line.scene == "box"]
        trials_told = [
            step.told for _, trial in sorted(played[f"participant:{visitor.identity}"].items()) for step in trial.steps
        ]
        assert told == trials_told
        read = [line.shown for line in diary[1:] if line.scene == "box" and not line.ended]
        assert [" ".join(scene["panel"]["report"]) for scene in shown if scene["step"] > 1] == read


@pytest.mark.parametrize("number", [16, pytest.param(60, marks=pytest.mark.slow)])
def test_killed_again_and_again_the_server_loses_nothing_that_was_shown(tmp_path, number):
    people = tmp_path / "people.toml"
    people.write_text('practice = ""\n')
    directory, luck = tmp_path / "study", random.Random(7)
    arguments = ("flips", "--box", "chain-4", "--p", "0,0.4", "--trials", number, "--repetitions", 1, "--out", directory,
                 "--people", people)  # fmt: skip

    def begun(port=0):
        process = start(*arguments, "--port", port)
        return process, json.loads(process.stdout.readline())

    def killed(process):
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()

    async def play(where, process):
        playing = asyncio.create_task(come(where, directory, read_study(directory), number, pause=0.02 * KILLS))
        kills = 0
        while kills < KILLS:
            await asyncio.wait({playing}, timeout=luck.uniform(0.1, 1.2))
            assert not playing.done(), "it was over too soon"
            killed(process)
            kills += 1
            process, _ = await asyncio.to_thread(begun, urlsplit(where["url"]).port)
        return await playing, process

    process, where = begun()
    try:
        visitors, process = asyncio.run(play(where, process))
    finally:
        killed(process)
    assert sum(visitor.resent for visitor in visitors) > 0
    check_nothing_lost_doubled_or_crossed(directory, read_study(directory), visitors)


def test_ctrl_c_ends_it_and_the_same_command_goes_on(tmp_path):
    arguments = ("flips", "--box", "chain-4", "--trials", 2, "--repetitions", 1, "--p", "0,0.4", "--out", tmp_path)

    def begun(port):
        process = start(*arguments, "--port", port)
        return process, json.loads(process.stdout.readline())["url"]

    def ended(process, how):
        process.send_signal(how)
        assert process.wait(60) == 0
        with process.stdout as said:
            assert said.read() == ""

    async def visit():
        process, url = begun(0)
        one = Visitor(url, read_study(tmp_path), tmp_path)
        await at_the_box(one, step=2)
        ended(process, signal.SIGINT)
        process, again = begun(urlsplit(url).port)
        was = one.seen[-1]
        await one.open()
        assert (again, one.seen[-1]) == (url, was)
        await one.play()
        ended(process, signal.SIGTERM)
        await one.close()

    asyncio.run(visit())
    assert len(load(tmp_path)) == 2


def test_no_address_is_kept(tmp_path, capfd):
    async def visit():
        async with served(tmp_path) as place, visiting(place) as one:
            mine = {"x-forwarded-for": "203.0.113.7", "user-agent": "a-browser/1.0"}
            one.http.headers.update(mine)
            await one.play()
            await place.http.get("/nothing", headers=mine)

    asyncio.run(visit())
    said = capfd.readouterr()
    kept = [path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()] + [(said.out + said.err).encode()]
    for trace in (b"203.0.113.7", b"127.0.0.1", b"a-browser"):
        assert not any(trace in content for content in kept)


def test_behind_tls_the_cookie_stays_there_and_the_proxys_name_is_known(tmp_path):
    door = Address(port=0, public="https://study.example.org")

    async def visit():
        async with opened(tmp_path, STUDY, EXPERIMENT, read_words("en"), door) as (where, _):
            wire = Wire(f"http://127.0.0.1:{where.port}")
            own = {"origin": "https://study.example.org", "sec-fetch-site": "same-origin"}
            named = await wire.post("/api/open", {}, headers=own | {"host": "study.example.org"})
            unnamed = await wire.post("/api/open", {}, headers=own)  # nginx, unless it is told otherwise
            plain = await wire.post("/api/open", {}, headers={"origin": "http://study.example.org"})
            await wire.close()
            return where, named, unnamed, plain

    where, named, unnamed, plain = asyncio.run(visit())
    assert where.url == "https://study.example.org/"
    assert (named.status_code, unnamed.status_code, plain.status_code) == (200, 200, 403)
    assert "secure" in named.headers["set-cookie"].lower().split("; ")

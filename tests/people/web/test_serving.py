"""The server as a whole: many at once, killed and started again, stopped; nobody loses or repeats a step."""

import asyncio
import random
import signal
from urllib.parse import urlsplit

from httpx2 import AsyncClient
from seated import as_played, without_page
from stored import records
from visitor import STUDY, Visitor, experiment, served, start, visiting

from lockprobe import load
from lockprobe.people.diary import read_diaries
from lockprobe.people.experiment import read_words
from lockprobe.people.web.address import Address
from lockprobe.people.web.app import opened
from lockprobe.studies.records.directory import read_study

KILLS = 3
"""How often the server is killed while they play."""

VISITORS = 8

STRATEGIES = ("human-inspired", "random", "random-no-repeat", "round-robin")
SILENT = ("random", "random-no-repeat", "round-robin")
"""Those that say nothing of their last action, and are asked."""


def check_nothing_lost_doubled_or_crossed(directory, study, visitors):
    """What is on disk is what each visitor did and was shown, and the trials are the strategies' own."""
    assert {visitor.scene.kind for visitor in visitors} == {"debrief"}
    who = {f"participant:{visitor.identity}": visitor for visitor in visitors}
    trials = load(directory)
    assert len(trials) == len({trial.key for trial in trials}) == len(records(directory)) == 2 * len(who)
    told = {agent: {} for agent in who}
    for trial in trials:
        strategy = who[trial.agent].strategy
        said = strategy not in SILENT
        assert as_played(trial, claims=said) == as_played(without_page(study, trial, strategy), claims=said)
        told[trial.agent][trial.facts["position"]] = [step.told for step in trial.steps]
    for diary in read_diaries(directory):
        agent = f"participant:{diary.identity}"
        assert [line.turn for line in diary.lines] == [*range(2, diary.turn)]
        assert [seen.turn for seen in who[agent].seen] == [*range(1, diary.turn + 1)]
        steps = [line for line in diary.lines if line.scene == "box"]
        assert [line.told for line in steps] == [*told[agent][1], *told[agent][2]]
        shown = [seen.scene for seen in who[agent].seen if seen.scene.kind == "box" and seen.scene.step > 1]
        assert [" ".join(scene.panel.report) for scene in shown] == [line.shown for line in steps if not line.ended]


def test_killed_again_and_again_the_server_loses_nothing_that_was_shown(tmp_path):
    people, directory, luck = tmp_path / "people.toml", tmp_path / "study", random.Random(7)
    people.write_text('practice = ""\n')
    arguments = ("flips", "--box", "chain-4", "--p", "0,0.4", "--trials", VISITORS, "--repetitions", 1,
                 "--out", directory, "--people", people)  # fmt: skip

    def killed(process):
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()

    async def play(process, url):
        study = read_study(directory)
        visitors = [
            Visitor(url, study, directory, STRATEGIES[i % len(STRATEGIES)], {"PROLIFIC_PID": f"person-{i}"}, i)
            for i in range(VISITORS)
        ]
        playing = asyncio.gather(*(visitor.play(pause=0.02 * KILLS) for visitor in visitors))
        for _ in range(KILLS):
            await asyncio.wait({playing}, timeout=luck.uniform(0.1, 1.2))
            assert not playing.done(), "it was over too soon"
            killed(process)
            process, _ = await asyncio.to_thread(start, *arguments, "--port", urlsplit(url).port)
        await playing
        killed(process)
        for visitor in visitors:
            await visitor.http.aclose()
        return visitors

    visitors = asyncio.run(play(*start(*arguments, "--port", 0)))
    assert sum(visitor.resent for visitor in visitors) > 0
    check_nothing_lost_doubled_or_crossed(directory, read_study(directory), visitors)


async def test_ctrl_c_ends_it_and_the_same_command_goes_on(tmp_path):
    arguments = ("flips", "--box", "chain-4", "--trials", 2, "--repetitions", 1, "--p", "0,0.4", "--out", tmp_path)

    def ended(process, how):
        process.send_signal(how)
        assert process.wait(60) == 0
        with process.stdout as said:
            assert said.read() == ""

    process, url = start(*arguments, "--port", 0)
    one = Visitor(url, read_study(tmp_path), tmp_path)
    await one.to_the_box(2)
    ended(process, signal.SIGINT)
    process, again = start(*arguments, "--port", urlsplit(url).port)
    was = one.seen[-1]
    await one.open()
    assert (again, one.seen[-1]) == (url, was)
    await one.play()
    ended(process, signal.SIGTERM)
    await one.http.aclose()
    assert len(load(tmp_path)) == 2


async def test_no_address_is_kept(tmp_path, capfd):
    async with served(tmp_path) as place, visiting(place) as one:
        mine = {"x-forwarded-for": "203.0.113.7", "user-agent": "a-browser/1.0"}
        one.http.headers.update(mine)
        await one.play()
        await place.http.get("/nothing", headers=mine)
    said = capfd.readouterr()
    kept = [path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()] + [(said.out + said.err).encode()]
    for trace in (b"203.0.113.7", b"127.0.0.1", b"a-browser"):
        assert not any(trace in content for content in kept)


async def test_behind_tls_the_cookie_stays_there_and_the_proxys_name_is_known(tmp_path):
    door = Address(port=0, public="https://study.example.org")

    async with opened(tmp_path, STUDY, experiment(), read_words("en"), door) as (where, _):
        own = {"origin": "https://study.example.org", "sec-fetch-site": "same-origin"}
        ways = (own | {"host": "study.example.org"}, own, {"origin": "http://study.example.org"})
        async with AsyncClient(base_url=f"http://127.0.0.1:{where.port}", trust_env=False) as http:
            named, unnamed, plain = [await http.post("/api/open", json={}, headers=headers) for headers in ways]
    assert where.url == "https://study.example.org/"
    assert (named.status_code, unnamed.status_code, plain.status_code) == (200, 200, 403)
    assert "secure" in named.headers["set-cookie"].lower().split("; ")

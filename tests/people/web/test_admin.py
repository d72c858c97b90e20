"""The experimenter's page: what it says, to whom, and that people can be deleted."""

import asyncio
import re

import pytest
from served import STUDY, at_the_box, experiment, logged, served, visiting, written

from lockprobe import load
from lockprobe.people.web.admin import AdminPage
from lockprobe.people.web.files import STATIC

BEARER = {"authorization": "Bearer a-token-for-tests"}
CHECKED = [{"after": 1, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}]


def test_progress_says_how_far_they_are_and_not_what_they_wrote(tmp_path):
    people = experiment(checks=CHECKED)
    private = {"platform": {"PROLIFIC_PID": "prolific-id"}, "answers": {"how": "in my own words", "check": "red"}}

    async def visit():
        async with (
            served(tmp_path, people=people) as place,
            visiting(place, **private) as one,
            visiting(place) as other,
        ):
            await asyncio.gather(one.play(), at_the_box(other, step=3))
            answer = await place.http.get("/api/admin/progress", headers=BEARER)
            return answer, one.identity, other.identity

    answer, one, other = asyncio.run(visit())
    progress = answer.json()
    assert (progress["joined"], progress["finished"], progress["checks_wrong"]) == (2, 1, 1)
    assert {(c["condition"], c["slots"], c["finished"], c["under_way"], c["free"]) for c in progress["conditions"]} == {
        ("truth", 3, 1, 1, 1),
        ("flip?p=0.4", 3, 1, 1, 1),
    }
    assert {p["identity"]: (p["stage"], p["boxes_done"]) for p in progress["participants"]} == {
        one: ("finished", 2),
        other: ("under way", 0),
    }
    assert "prolific-id" not in answer.text
    assert "own words" not in answer.text


@pytest.mark.parametrize("header", [None, "", "Bearer", "Bearer wrong", "Basic a-token-for-tests"])
def test_without_the_token_there_is_nothing(tmp_path, header):
    async def visit():
        async with served(tmp_path) as place, visiting(place) as one:
            await at_the_box(one)
            before = written(tmp_path)
            headers = {} if header is None else {"authorization": header}
            asked = await one.http.get("/api/admin/progress", headers=headers)
            deleted = await one.http.post("/api/admin/withdraw", {"participant": one.identity}, headers=headers)
            for answer in (asked, deleted):
                assert (answer.status_code, answer.json()["error"]) == (401, "forged")
                assert answer.headers["www-authenticate"] == "Bearer"
                assert "set-cookie" not in answer.headers  # the participant's is left alone
            assert written(tmp_path) == before
            await one.play()

    asyncio.run(visit())
    assert len(logged(tmp_path)) == 2


def test_somebody_who_asks_for_it_is_deleted(tmp_path):
    async def visit():
        async with served(tmp_path) as place, visiting(place) as one, visiting(place) as other:
            await asyncio.gather(one.play(), other.play())
            assert len(load(tmp_path)) == 4
            answer = await place.http.post(
                "/api/admin/withdraw", json={"participant": one.identity}, headers=BEARER
            )  # fmt: skip
            assert (answer.status_code, answer.json()["joined"], answer.json()["withdrawn"]) == (200, 1, 1)
            before = written(tmp_path)
            again = await place.http.post("/api/admin/withdraw", json={"participant": one.identity}, headers=BEARER)
            assert (again.status_code, again.json()["error"]) == (404, "unknown")
            for nobody in ("../secret", "<script>", "", 1, None, "A" * 8, "a" * 100):
                asked = await place.http.post("/api/admin/withdraw", json={"participant": nobody}, headers=BEARER)
                assert (asked.status_code, asked.json()["error"]) == (400, "malformed")
            assert written(tmp_path) == before
            return one.identity, other.identity

    gone, stays = asyncio.run(visit())
    assert {trial.agent for trial in load(tmp_path)} == {f"participant:{stays}"}
    assert not any(gone.encode() in path.read_bytes() for path in tmp_path.rglob("*") if path.is_file())
    assert STUDY.size == 6


def test_a_platform_id_finds_the_participant(tmp_path):
    desk = AdminPage(study_url=lambda url: url + "?x", reminders=("do this",))

    async def visit():
        async with (
            served(tmp_path, desk=desk) as place,
            visiting(place, platform={"PROLIFIC_PID": "abc123"}) as one,
            visiting(place) as other,
        ):
            await asyncio.gather(at_the_box(one), at_the_box(other))

            async def find(value):
                answer = await place.http.post("/api/admin/find", json={"id": value}, headers=BEARER)
                return answer.json()

            assert await find("abc123") == {"participants": [one.identity]}
            assert await find("abc12") == {"participants": []}
            assert (await find(""))["error"] == "malformed"
            assert (await place.http.post("/api/admin/find", json={})).status_code == 401
            progress = (await place.http.get("/api/admin/progress", headers=BEARER)).json()
            assert (progress["study_url"], progress["reminders"]) == (f"{place.url}?x", ["do this"])

    asyncio.run(visit())


def test_the_page_is_its_own_and_loads_nothing_from_elsewhere(tmp_path):
    async def visit():
        async with served(tmp_path) as place:
            return await place.http.get("/admin")

    page = asyncio.run(visit())
    assert page.status_code == 200
    assert page.headers["content-type"] == "text/html; charset=utf-8"
    for name in ("admin.html", "admin.css", "admin.js"):
        text = (STATIC / name).read_text("utf-8")
        assert "://" not in text
        assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|eval\(|\bstyle=|\bon\w+=", text)
    loaded = set(re.findall(r'(?:src|href)="(?:static/)([^"]+)"', page.text))
    assert loaded <= {path.name for path in STATIC.iterdir()}
    assert "<script>" not in page.text

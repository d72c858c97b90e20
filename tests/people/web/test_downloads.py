"""What an experimenter downloads: everything that may be given away, and nothing of those who have withdrawn."""

import asyncio
import csv
import io
import json
import shutil
import zipfile
from functools import partial
from itertools import chain, count, repeat

import pytest
from served import served, visiting

from lockprobe.interfaces.export.downloads import Download, downloads
from lockprobe.interfaces.export.tables import TABLES
from lockprobe.people.web.admin import AdminPage
from lockprobe.people.web.downloads import Downloads
from lockprobe.people.web.refusals import STATUS, RequestRefused

BEARER = {"authorization": "Bearer a-token-for-tests"}
NAMES = ["dataset.zip", *(name for table in TABLES for name in (f"{table}.csv", f"{table}.csv-metadata.json"))]


def test_everything_can_be_had_but_what_is_not_given_away(tmp_path):
    async def visit():
        async with (
            served(tmp_path, desk=AdminPage(files=downloads(tmp_path))) as place,
            visiting(place, platform={"PROLIFIC_PID": "abc123"}, answers={"how": "in my own words"}) as stays,
            visiting(place, answers={"how": "to be forgotten"}) as gone,
        ):
            nobody = await place.http.get("/api/admin/data/dataset.zip", headers=BEARER)
            assert (nobody.status_code, nobody.json()["error"]) == (404, "unknown")
            assert "nobody took part" in nobody.json()["message"]
            await asyncio.gather(stays.play(), gone.play())
            leave = await place.http.post("/api/admin/withdraw", json={"participant": gone.identity}, headers=BEARER)
            assert leave.json()["withdrawn"] == 1
            progress = (await place.http.get("/api/admin/progress", headers=BEARER)).json()
            assert [file["name"] for file in progress["downloads"]] == NAMES
            for name in ("", "/dataset.zip", "/steps.csv"):
                assert (await place.http.get(f"/api/admin/data{name}")).status_code == 401
            other = await place.http.get("/api/admin/data/secret", headers=BEARER)
            assert (other.status_code, other.json()["error"]) == (404, "unknown")
            files = {
                name: await place.http.get(f"/api/admin/data/{name}", headers=BEARER)
                for name in ("dataset.zip", "participants.csv", "trials.csv-metadata.json")
            }
            files["steps.csv"] = await place.http.get("/api/admin/data", headers=BEARER)  # where no file is named
            return stays.identity, gone.identity, files

    stays, gone, files = asyncio.run(visit())
    assert files["steps.csv"].headers["content-type"] == "text/csv; charset=utf-8"
    assert files["dataset.zip"].headers["content-disposition"] == 'attachment; filename="dataset.zip"'
    with zipfile.ZipFile(io.BytesIO(files["dataset.zip"].content)) as archive:
        inside = {name: archive.read(name) for name in archive.namelist()}
    assert "dataset/dataset_description.json" in inside
    for name in ("steps", "participants"):
        assert inside[f"dataset/data/study-flips_description-{name}_data.csv"] == files[f"{name}.csv"].content
    everything = b"".join(inside.values())
    assert b"in my own words" in everything
    diary = (tmp_path / "people" / f"{stays}.jsonl").read_text("utf-8")
    token = json.loads(diary.partition("\n")[0])["token"]
    assert "abc123" in diary
    assert not [one for one in ("abc123", token, gone, "to be forgotten") if one.encode() in everything]
    (row,) = csv.DictReader(io.StringIO(files["participants.csv"].text))
    assert (row["participant"], row["finished"]) == (stays, "1")
    columns = json.loads(files["trials.csv-metadata.json"].text)["tableSchema"]["columns"]
    trials = inside["dataset/data/study-flips_description-trials_data.csv"].decode()
    assert [column["name"] for column in columns] == trials.splitlines()[0].split(",")


@pytest.fixture
def copied(tmp_path):
    """One file to download: a copy of another."""
    source = tmp_path / "source"
    source.write_bytes(b"as it is")
    return Download(name="steps.csv", about="", write=partial(shutil.copyfile, source))


def sent(files, withdrawals):
    async def asked():
        answer = await Downloads(files, withdrawals).answer("steps.csv")
        return b"".join([piece async for piece in answer.body_iterator]), answer.headers

    return asyncio.run(asked())


def test_where_somebody_withdraws_meanwhile_it_is_written_anew(copied):
    withdrawals = chain([0, 1], repeat(1))  # between the first look and the second somebody withdrew
    content, headers = sent([copied], lambda: next(withdrawals))
    assert (content, headers["content-length"]) == (b"as it is", "8")
    assert next(withdrawals) == 1
    counted = count()
    with pytest.raises(RequestRefused, match="withdrawing") as refused:
        sent([copied], lambda: next(counted))
    assert (STATUS[refused.value.code], next(counted)) == (429, 10)


def test_what_cannot_be_written_is_said(tmp_path, copied):
    by_name = {file.name: file for file in downloads(tmp_path / "nothing")}
    with pytest.raises(RequestRefused, match="nothing"):
        sent([by_name["steps.csv"]], lambda: 0)
    broken = Download(name="steps.csv", about="", write=partial(shutil.copyfile, tmp_path / "not there"))
    with pytest.raises(RequestRefused, match="could not be written"):
        sent([broken], lambda: 0)
    with pytest.raises(RequestRefused, match=r"no such file; there are steps.csv"):
        asyncio.run(Downloads([copied], lambda: 0).answer("other.csv"))

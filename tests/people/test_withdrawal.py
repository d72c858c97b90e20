"""Who withdraws leaves no byte but the count, whenever the process is killed."""

import asyncio
import os
import shutil
import signal
import time
from contextlib import closing
from pathlib import Path
from sqlite3 import connect

import pytest
from seated import GO_ON, Clock, Player, diary_of, free, go_on, opened, people_study, short, take_part
from stored import sql, timings
from typed import in_process

from lockprobe.foundation.errors import BadFile
from lockprobe.foundation.storage.database import Database
from lockprobe.people.diary import Agree, read_diaries
from lockprobe.people.scenes import ActRefused
from lockprobe.people.withdrawal import withdraw, withdrawn
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.store import STORE

STUDY = people_study()


def pieces(directory: Path, identity: str) -> set[bytes]:
    """All that is stored of somebody and of nobody else, in pieces as long as a search needs."""
    stored = sql(directory, "select participant, cast(entry as blob) from act")
    stored += [
        (player.partition(":")[2], record) for player, record in sql(directory, "select player, record from trial")
    ]
    found = {True: {identity.encode()}, False: set()}
    for whose, content in stored:
        windows = {content[at : at + 24] for at in range(len(content) - 23)}
        found[whose == identity] |= windows
    return found[True] - found[False]


def left_of(directory: Path, of: set[bytes]) -> set[bytes]:
    """The pieces that any file still holds, in its name or content."""
    files = [path for path in directory.rglob("*") if path.is_file()]
    content = b"\n".join(path.name.encode() + b"\n" + path.read_bytes() for path in files)
    return of & {content[at : at + length] for length in {*map(len, of)} for at in range(len(content))}


def in_the_second_box(shown):
    return shown.scene.kind == "box" and shown.scene.number == 2 and shown.scene.step == 2


def test_who_withdraws_leaves_no_trace_but_the_count_and_is_a_stranger(tmp_path):
    last = take_part(tmp_path, STUDY, short(), people=2)
    (left,) = take_part(tmp_path, STUDY, short(), platform={"PROLIFIC_PID": "platformname"}, until=in_the_second_box)
    of = pieces(tmp_path, left.participant)
    token = diary_of(tmp_path, left.participant)[0].token
    assert left_of(tmp_path, of) == of
    kept = [trial for trial in load(tmp_path) if left.participant not in trial.agent]

    async def withdraws():
        async with opened(tmp_path, STUDY, short()) as reception:
            shown = await reception.enter(left.token, {})
            shown = await reception.withdraw(shown.token)
            assert (shown.scene.why, shown.participant) == ("withdrawn", None)
            again = await reception.withdraw(shown.token)  # its reply was lost
            assert again.scene == shown.scene
            with pytest.raises(ActRefused) as refusal:
                await reception.act(shown.token, 7, GO_ON, {})
            assert refusal.value.code == "stale"
            assert (withdrawn(tmp_path), len(read_diaries(tmp_path)), free(reception)) == (1, 2, [2, 2])
            assert left_of(tmp_path, of | {token.encode(), b"platformname"}) == set()
            assert load(tmp_path) == kept
            assert {diary.identity for diary in read_diaries(tmp_path)} == {one.participant for one in last}
            shown = await reception.enter(left.token, {})
            assert shown.scene.kind == "consent"
            shown = await reception.act(shown.token, 1, Agree(agreed=True), {})
            assert shown.participant != left.participant
            await go_on(reception, Player(tmp_path, STUDY, "random"), shown)

    asyncio.run(withdraws())
    assert load(tmp_path)[: len(kept)] == kept
    assert len(load(tmp_path)) == len(kept) + 2
    assert timings(tmp_path, "key") == [trial.key for trial in load(tmp_path)]
    assert left_of(tmp_path, {left.participant.encode(), b"platformname"}) == set()


@pytest.mark.parametrize("by", ["the page", "the experimenter"])
def test_who_has_withdrawn_cannot_begin_again_under_the_same_platform_id(tmp_path, by):
    (left,) = take_part(tmp_path, STUDY, short(), platform={"PROLIFIC_PID": "zq7name"}, until=in_the_second_box)
    if by == "the experimenter":
        assert in_process("withdraw", tmp_path, "zq7name").exit_code == 0

    async def comes_back():
        async with opened(tmp_path, STUDY, short()) as reception:
            if by == "the page":
                shown = await reception.enter(left.token, {})
                await reception.withdraw(shown.token)
            for who, kind in (("zq7name", "closed"), ("other", "consent")):
                shown = await reception.enter(None, {"PROLIFIC_PID": who})
                assert shown.scene.kind == kind
                shown = await reception.act(shown.token, 1, Agree(agreed=True), {"PROLIFIC_PID": who})
                assert (shown.participant is None) == (who == "zq7name")
            assert withdrawn(tmp_path) == 1

    asyncio.run(comes_back())
    assert left_of(tmp_path, {b"zq7name"}) == set()


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A study that two have played, what they were shown last, and the seconds that a withdrawal takes; to be copied."""
    directory, copy = tmp_path_factory.mktemp("played"), tmp_path_factory.mktemp("played") / "copy"
    shown = take_part(directory, STUDY, short(), people=2)
    shutil.copytree(directory, copy)
    shutil.copy(copy / STORE, copy / f"{STORE}.rescued")
    with Journal.open(copy, STUDY) as journal:
        began = time.perf_counter()
        withdraw(journal, shown[0].participant)
        return directory, shown, time.perf_counter() - began


def withdraws_and_is_killed(directory, identity, after):
    """Somebody withdraws in a process that is killed after so many seconds, or before anything is erased; whether it was."""
    child = os.fork()
    if not child:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        try:
            with Journal.open(directory, STUDY) as journal:
                if after is None:
                    Database.erase = lambda store: os.kill(os.getpid(), signal.SIGKILL)
                else:
                    signal.setitimer(signal.ITIMER_REAL, 1e-6 + after)
                withdraw(journal, identity)
        finally:
            os._exit(0)
    return os.WIFSIGNALED(os.waitpid(child, 0)[1])


MOMENTS = 6
"""At how many moments of a withdrawal, one after the other, it is killed."""


@pytest.mark.parametrize(("rescued", "moment"), [(False, None), (True, None), *((True, n) for n in range(MOMENTS))])
def test_after_a_kill_a_withdrawal_is_done_or_not_and_what_is_done_is_finished_at_the_next_opening(
    tmp_path, played, rescued, moment
):
    directory, (left, stays), seconds = played
    shutil.copytree(directory, tmp_path, dirs_exist_ok=True)
    if rescued:
        shutil.copy(tmp_path / STORE, tmp_path / f"{STORE}.rescued")
    of = pieces(tmp_path, left.participant)
    killed = withdraws_and_is_killed(tmp_path, left.participant, None if moment is None else seconds * moment / MOMENTS)
    if moment is None:
        assert killed
        assert left_of(tmp_path, of)
    with Journal.open(tmp_path, STUDY) as journal:
        people = len(read_diaries(tmp_path))
        assert (withdrawn(tmp_path), people, len(load(tmp_path)), len(journal.trials)) in ((0, 2, 4, 4), (1, 1, 2, 2))
        if withdrawn(tmp_path):
            assert left_of(tmp_path, of) == set()
        withdraw(journal, left.participant)
        assert left_of(tmp_path, of) == set()
    assert left_of(tmp_path, of) == set()
    assert (withdrawn(tmp_path), {trial.agent for trial in load(tmp_path)}) == (1, {f"participant:{stays.participant}"})
    assert not [path.name for path in tmp_path.iterdir() if path.name.endswith(("-wal", "-shm", "-journal"))]


def test_where_it_could_not_be_erased_nobody_is_told_that_it_was_and_nobody_comes_back(tmp_path, monkeypatch):
    monkeypatch.setattr("lockprobe.foundation.storage.database._WAIT", 0.05)
    left, stays = take_part(tmp_path, STUDY, short(), people=2)
    of = pieces(tmp_path, left.participant)

    async def withdraws():
        async with opened(tmp_path, STUDY, short()) as reception:
            shown = await reception.enter(left.token, {})
            with closing(connect(tmp_path / STORE)) as reader:
                reader.execute("begin")
                reader.execute("select * from trial").fetchone()
                for _ in range(2):
                    with pytest.raises(BadFile, match="read by another program"):
                        await reception.withdraw(shown.token)
                    with pytest.raises(ActRefused):
                        await reception.act(shown.token, shown.turn, GO_ON, {})
                assert [diary.identity for diary in read_diaries(tmp_path)] == [stays.participant]
                assert left_of(tmp_path, of)
            other = await reception.enter(stays.token, {})
            await reception.withdraw(other.token)  # takes them along
            assert left_of(tmp_path, of) == set()
            assert (await reception.withdraw(shown.token)).scene.why == "withdrawn"
            assert free(reception) == [4, 4]

    asyncio.run(withdraws())
    assert withdrawn(tmp_path) == 2


def test_who_withdraws_while_they_join_has_withdrawn(tmp_path):
    clock, study = Clock(), people_study(p=(0.0,), trials=1)
    take_part(tmp_path, study, short(), until=lambda shown: shown.scene.kind == "box", clock=clock)

    async def both():
        async with opened(tmp_path, study, short(away_minutes=60), clock=clock) as reception:
            (late,) = reception.sessions
            await late.show()  # is held, so that letting go of it takes a moment
            clock.now += 7200
            shown = await reception.enter(None, {})
            joins = reception.act(shown.token, 1, Agree(agreed=True), {})
            return await asyncio.gather(joins, reception.withdraw(shown.token))

    _, shown = asyncio.run(both())
    assert (shown.scene.why, withdrawn(tmp_path)) == ("withdrawn", 1)
    assert len(read_diaries(tmp_path)) == 1

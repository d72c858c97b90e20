"""Who withdraws leaves no trace but the count, whenever the server is killed."""

import asyncio
import shutil
from pathlib import Path

import pytest
from builders import make_trial
from seated import Clock, Player, diary_of, flow, free, go_on, leaves, opened, people_study, short, take_part

from lockprobe.foundation.errors import BadFile
from lockprobe.people.diary import read_diaries
from lockprobe.people.refusals import ActRefused
from lockprobe.people.responses import Agree, Attempt, Next
from lockprobe.people.scenes import Box
from lockprobe.people.withdrawal import finish_withdrawal, note_withdrawal, put, withdrawn
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import Timing, read_timings

STUDY = people_study()


def traces(directory: Path, *words: str) -> list[Path]:
    """Files in whose names or contents one of these words stands."""
    files = [path for path in directory.rglob("*") if path.is_file()]
    return [path for path in files if any(word in path.name or word.encode() in path.read_bytes() for word in words)]


def test_who_withdraws_leaves_no_trace_but_the_count(tmp_path):
    last = take_part(tmp_path, STUDY, short(), people=2, platform=None)
    (third,) = take_part(tmp_path, STUDY, short(), platform={"PROLIFIC_PID": "platformname"}, until=in_the_second_box)
    token = diary_of(tmp_path, third.identity)[0].token
    assert traces(tmp_path, third.identity)
    kept = [trial for trial in load(tmp_path) if third.identity not in trial.agent]

    async def withdraws():
        async with opened(tmp_path, STUDY, short()) as reception:
            shown = await reception.enter(third.token, {})
            shown = await reception.withdraw(shown.token, shown.lease)
            assert (shown.scene.why, shown.identity, shown.may_withdraw) == ("withdrawn", None, False)
            again = await reception.withdraw(shown.token, shown.lease)  # its reply was lost
            assert again.scene == shown.scene
            with pytest.raises(ActRefused) as refusal:
                await reception.act(shown.token, shown.lease, 7, Next(), {})
            assert refusal.value.code == "stale"
            return flow(reception), free(reception)

    progress, places = asyncio.run(withdraws())
    assert traces(tmp_path, third.identity, token, "platformname") == []
    assert load(tmp_path) == kept
    assert {timing.key for timing in read_timings(tmp_path)} == {trial.key for trial in kept}
    assert (progress.withdrawn, progress.consented, places) == (1, 3, [2, 2])
    assert {diary.identity for diary in read_diaries(tmp_path)} == {shown.identity for shown in last}


def in_the_second_box(shown):
    return isinstance(shown.scene, Box) and shown.scene.number == 2 and shown.scene.step == 2


def test_the_journal_goes_on_after_somebody_was_struck(tmp_path):
    (left,) = take_part(tmp_path, STUDY, short())

    async def withdraws():
        async with opened(tmp_path, STUDY, short(), clock=Clock()) as reception:
            await leaves(reception, left.token)
            shown = await reception.enter(left.token, {})  # is a stranger now
            assert shown.scene.kind == "consent"
            shown = await reception.act(shown.token, shown.lease, 1, Agree(agreed=True), {})
            assert shown.identity != left.identity
            await go_on(reception, Player(tmp_path, STUDY, "random"), shown)

    asyncio.run(withdraws())
    assert [trial.key for trial in load(tmp_path)] == [timing.key for timing in read_timings(tmp_path)]
    assert len(load(tmp_path)) == 2
    assert traces(tmp_path, left.identity) == []


class Killed(BaseException):
    """The process is gone."""


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A study that two have played, and what they were shown last; tests copy it."""
    directory = tmp_path_factory.mktemp("played")
    return directory, take_part(directory, STUDY, short(), people=2)


@pytest.mark.parametrize("at", range(1, 40))
def test_a_deletion_that_is_killed_is_finished_at_the_next_opening(tmp_path, monkeypatch, played, at):
    directory, (left, stays) = played
    shutil.copytree(directory, tmp_path, dirs_exist_ok=True)
    count = 0

    def dying(real):
        def called(*arguments, **named):
            nonlocal count
            count += 1
            if count == at:
                raise Killed
            return real(*arguments, **named)

        return called

    async def withdraws():
        async with opened(tmp_path, STUDY, short()) as reception:
            shown = await reception.enter(left.token, {})
            with monkeypatch.context() as patched:
                for name in ("replace", "unlink", "open"):
                    patched.setattr(Path, name, dying(getattr(Path, name)))
                patched.setattr("os.fsync", dying(__import__("os").fsync))
                await reception.withdraw(shown.token, shown.lease)

    try:
        asyncio.run(withdraws())
    except Killed:
        noted = (tmp_path / "people" / "withdrawing.json").exists()
    else:
        noted = True
        assert count < at

    async def opens():
        async with opened(tmp_path, STUDY, short()) as reception:
            return flow(reception)

    progress = asyncio.run(opens())
    assert progress.consented == 2
    if noted or progress.withdrawn:
        assert traces(tmp_path, left.identity) == []
        assert (progress.withdrawn, len(load(tmp_path))) == (1, 2)
    else:
        assert (progress.withdrawn, len(load(tmp_path))) == (0, 4)
    assert {trial.agent for trial in load(tmp_path)} >= {f"participant:{stays.identity}"}


def test_what_killed_writers_left_of_them_goes_too(tmp_path):
    (left,) = take_part(tmp_path, STUDY, short())
    people = tmp_path / "people"
    for path in (people / f"{left.identity}.jsonl", people / "withdrawing.json", tmp_path / "trials.jsonl"):
        path.with_name(f".{path.name}.draft").write_text(left.identity)

    async def withdraws():
        async with opened(tmp_path, STUDY, short()) as reception:
            await leaves(reception, left.token)

    asyncio.run(withdraws())
    assert traces(tmp_path, left.identity) == []
    assert not list(tmp_path.rglob(".*"))


def test_where_it_could_not_be_written_nobody_is_told_that_it_was(tmp_path, monkeypatch):
    (left,) = take_part(tmp_path, STUDY, short())

    def fails(*arguments):
        raise BadFile(tmp_path, "cannot be written")

    async def withdraws():
        async with opened(tmp_path, STUDY, short()) as reception:
            shown = await reception.enter(left.token, {})
            with monkeypatch.context() as patched:
                patched.setattr("lockprobe.studies.records.journal.rewritten", fails)
                with pytest.raises(BadFile):
                    await reception.withdraw(shown.token, shown.lease)
                with pytest.raises(ActRefused):
                    await reception.act(shown.token, shown.lease, shown.turn, Next(), {})
            assert (await reception.withdraw(shown.token, shown.lease)).scene.why == "withdrawn"

    asyncio.run(withdraws())
    assert (traces(tmp_path, left.identity), withdrawn(tmp_path)) == ([], 1)


def cannot(*arguments):
    raise BadFile("here", "cannot be written")


@pytest.mark.parametrize("again", [False, True])
def test_a_deletion_that_failed_is_finished_before_the_next_one(tmp_path, monkeypatch, again):
    fails, other, stays = take_part(tmp_path, STUDY, short(), people=3)

    async def withdraw_both():
        async with opened(tmp_path, STUDY, short()) as reception:
            with monkeypatch.context() as patched:
                patched.setattr("lockprobe.studies.records.journal.rewritten", cannot)
                for token in (fails.token, other.token):  # nothing is noted over what is not finished
                    with pytest.raises(BadFile):
                        await leaves(reception, token)
            shown = await reception.enter(fails.token, {})
            assert (shown.scene.why, withdrawn(tmp_path)) == ("withdrawn", 0)
            if again:
                await reception.withdraw(shown.token, shown.lease)
            await leaves(reception, other.token)
            return flow(reception), free(reception)

    progress, places = asyncio.run(withdraw_both())
    assert (progress.withdrawn, progress.consented, places) == (2, 3, [3, 3])
    assert traces(tmp_path, fails.identity, other.identity) == []
    assert {trial.agent for trial in load(tmp_path)} == {f"participant:{stays.identity}"}


def test_nothing_is_noted_over_a_deletion_that_is_not_finished(tmp_path):
    with Journal.open(tmp_path, STUDY) as journal:
        note_withdrawal(journal, "aaaa")
        with pytest.raises(BadFile, match="an unfinished deletion"):
            note_withdrawal(journal, "bbbb")
        assert finish_withdrawal(journal) == "aaaa"


def test_where_it_could_not_even_be_noted_they_go_on(tmp_path, monkeypatch):
    (left,) = take_part(tmp_path, STUDY, short(), until=in_the_second_box)

    async def withdraws():
        async with opened(tmp_path, STUDY, short()) as reception:
            shown = await reception.enter(left.token, {})
            with monkeypatch.context() as patched:
                patched.setattr("lockprobe.people.withdrawal.put", cannot)
                with pytest.raises(BadFile):
                    await reception.withdraw(shown.token, shown.lease)
            again = await reception.enter(left.token, {})
            assert (again.scene, again.turn, again.may_withdraw) == (shown.scene, shown.turn, True)
            act = Attempt(joint="A", claimed="moved", rt=1.0)
            again = await reception.act(again.token, again.lease, again.turn, act, {})
            assert again.turn == shown.turn + 1
            await reception.withdraw(again.token, again.lease)

    asyncio.run(withdraws())
    assert (traces(tmp_path, left.identity), withdrawn(tmp_path)) == ([], 1)


def test_who_withdraws_while_they_join_has_withdrawn(tmp_path):
    clock, study = Clock(), people_study(p=(0.0,), trials=1)
    take_part(tmp_path, study, short(), until=lambda shown: isinstance(shown.scene, Box), clock=clock)

    async def both():
        async with opened(tmp_path, study, short(away_minutes=60), clock=clock) as reception:
            (late,) = reception._roster
            await late.show()  # is held, so that letting go of it takes a moment
            clock.now += 7200
            shown = await reception.enter(None, {})
            joins = reception.act(shown.token, shown.lease, 1, Agree(agreed=True), {})
            return await asyncio.gather(joins, reception.withdraw(shown.token, shown.lease))

    _, shown = asyncio.run(both())
    assert (shown.scene.why, withdrawn(tmp_path)) == ("withdrawn", 1)
    assert len(list((tmp_path / "people").glob("*.jsonl"))) == 1


@pytest.mark.parametrize("count", ['"x"', "null", "-1", "true", "1.5"])
def test_a_count_that_is_none_is_found_out(tmp_path, count):
    put(tmp_path / "people" / "withdrawn.json", {})
    (tmp_path / "people" / "withdrawn.json").write_text(f'{{"withdrawn": {count}}}')
    with pytest.raises(BadFile, match="withdrawals"):
        withdrawn(tmp_path)


@pytest.mark.parametrize(
    "note", ['{"participant": "../../x", "withdrawn": 1}', "{", "[]", '{"participant": "abcd"}', '{"withdrawn": 1}']
)
def test_a_note_that_is_none_deletes_nothing(tmp_path, note):
    with Journal.open(tmp_path, STUDY) as journal:
        put(tmp_path / "people" / "withdrawing.json", {})
        (tmp_path / "people" / "withdrawing.json").write_text(note)
        with pytest.raises(BadFile):
            finish_withdrawal(journal)
    assert (tmp_path / "people" / "withdrawing.json").exists()


def test_only_theirs_is_struck(tmp_path):
    study = people_study(agents=("participant", "random"))
    mine = [make_trial([0, 1], agent="participant:aaaa", trial=number, budget=2) for number in (1, 2)]
    others = [make_trial([0, 1], agent=agent, budget=2) for agent in ("participant:aaaab", "random")]
    with Journal.open(tmp_path, study) as journal:
        for trial in (mine[0], *others, mine[1]):
            journal.append(trial, Timing(key=trial.key, seconds=1.0, steps=1))
        (tmp_path / "people").mkdir()
        for identity in ("aaaa", "bbbb"):  # of the second there is nothing
            note_withdrawal(journal, identity)
            assert finish_withdrawal(journal) == identity
        assert finish_withdrawal(journal) is None
    assert [trial.agent for trial in load(tmp_path)] == ["participant:aaaab", "random"]
    assert withdrawn(tmp_path) == 2

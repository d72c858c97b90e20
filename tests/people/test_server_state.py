"""People play the trials that strategies play, whatever happens to pages, networks and servers in between."""

import asyncio
from dataclasses import replace

import pytest
from seated import (
    Clock,
    Player,
    as_played,
    diary_of,
    go_on,
    opened,
    people_study,
    refused,
    short,
    take_part,
    to_first,
    under,
    without_page,
)
from stored import acts, records, rewrite_acts, timings

from lockprobe.people.diary import Did
from lockprobe.people.experiment import Experiment
from lockprobe.people.refusals import ActRefused
from lockprobe.people.responses import Agree, Attempt
from lockprobe.people.scenes import Box
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load

CHOICE = Attempt(joint="A", rt=1.0)


@pytest.mark.parametrize(
    ("spec", "flip"),
    [
        ("human-inspired", "outcome-only"),
        ("human-inspired:proximity", "re-observed"),
        ("ideal-observer", "integrated"),
        ("round-robin", "re-observed"),
    ],
)
def test_a_strategy_at_the_page_plays_as_without_it(tmp_path, spec, flip):
    study = people_study(flip=flip, layout="shuffled", assessment=flip != "integrated")
    take_part(tmp_path, study, Experiment(history=False), spec, people=2)
    trials = load(tmp_path)
    assert len(trials) == 4
    for trial in trials:
        alone = without_page(study, trial, spec)
        claims = spec != "round-robin"  # it says nothing of what it is told, and here it is asked
        assert as_played(trial, claims=claims) == as_played(alone, claims=claims)
        assert (trial.ending, trial.opening, trial.channels, trial.labels, trial.listing, trial.key) == (
            alone.ending, alone.opening, alone.channels, alone.labels, alone.listing, alone.key,
        )  # fmt: skip


def test_under_any_condition_the_record_is_that_of_an_agent(tmp_path):
    spec = "human-inspired"
    study = under(
        "truth", "flip?p=0.4 + nudge", "remark?after=0", "distract?p=0.5 + warn", "correction?p=0.4",
        "drop?p=0.3", "delay?lag=2", "yoked?p=0.4", "tremble?p=0.3", "force?at=3",
        "flip?p=0.4&only=blocked + symbolic", trials=11,
    )  # fmt: skip
    take_part(tmp_path, study, short(), spec)
    trials = load(tmp_path)
    assert {trial.condition for trial in trials} == {one.label for one in study.conditions}
    for trial in trials:
        alone = without_page(study, trial, spec)
        says_nothing = trial.condition.startswith(("drop", "delay"))  # of what it is not told, and here it is asked
        assert as_played(trial, claims=not says_nothing) == as_played(alone, claims=not says_nothing)
        assert [(step.remark, step.chosen) for step in trial.steps] == [(one.remark, one.chosen) for one in alone.steps]
        same = ("specs", "doses", "interventions", "channels", "changed", "changed_steps", "opening", "ending", "key")
        assert {name: getattr(trial, name) for name in same} == {name: getattr(alone, name) for name in same}
    by = {trial.condition: trial for trial in trials}
    assert sum(bool(step.remark) for step in by["remark?after=0"].steps) == len(by["remark?after=0"].steps) - 1
    assert by["distract?p=0.5 + warn"].changed["warn"] == len(by["distract?p=0.5 + warn"].steps)
    assert any(step.chosen for step in by["tremble?p=0.3"].steps)


def test_somebody_who_looks_at_pictures_plays_as_without_a_page(tmp_path):
    study = people_study(p=(0.0,), modalities=("rgbd",), plant="fast-twin?width=160&height=120", trials=1, max_steps=4)
    take_part(tmp_path, study, Experiment(practice="chain-2"), "viewer")
    (trial,) = load(tmp_path)
    assert as_played(trial) == as_played(without_page(study, trial, "viewer"))
    assert trial.facts["view"] == "pictures"
    assert {path.name for path in (tmp_path / "pictures").iterdir()} == trial.picture_names


def test_a_record_says_on_what_it_was_played_and_nothing_of_who(tmp_path):
    study = people_study()
    (shown,) = take_part(tmp_path, study, short(), platform={"PROLIFIC_PID": "xyz", "STUDY_ID": "x"})
    trials = load(tmp_path)
    assert {trial.agent for trial in trials} == {f"participant:{shown.identity}"}
    assert [trial.facts["position"] for trial in trials] == [1, 2]
    words = diary_of(tmp_path, shown.identity)[0].words
    assert dict(trials[0].facts) == {
        "view": "panel", "words": words, "page": "1", "position": 1, "design": "within", "history": True,
        "history_open": True, "feedback": False,
    }  # fmt: skip
    assert "xyz" not in str(records(tmp_path))
    assert read_study(tmp_path).agents == ("participant",)
    assert all(map(read_study(tmp_path).asks_for, trials))


def test_times_are_those_of_the_person_and_not_of_playing_it_again(tmp_path):
    clock = Clock()
    (shown,) = take_part(tmp_path, people_study(), short(), clock=clock)
    steps = [line for line in diary_of(tmp_path, shown.identity) if isinstance(line, Did) and line.box == 2]
    before = next(line for line in diary_of(tmp_path, shown.identity) if isinstance(line, Did) and line.scene == "over")
    second = timings(tmp_path)[1]
    assert second.seconds == pytest.approx(steps[-2].at - before.at)  # the last line is the scene after the box
    assert second.steps == len(steps) - 1


@pytest.mark.parametrize(
    ("study", "reloads"),
    [
        (people_study(max_steps=6), True),
        (under("distract?p=0.5 + tremble?p=0.3", "remark?after=0 + correction?p=0.5", max_steps=6), False),
    ],
    ids=["restarted and reloaded", "restarted"],
)
def test_it_goes_on_where_it_stood_after_every_single_act(tmp_path, study, reloads):
    experiment = Experiment(
        checks=[{"after": 0, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}],
        questions=[{"name": "how", "question": "How?"}],
    )
    take_part(tmp_path / "once", study, experiment, "ideal-observer")

    async def broken_off() -> None:
        player, token = Player(tmp_path / "often", study, "ideal-observer"), None
        clock = Clock()
        for _ in range(100):
            async with opened(tmp_path / "often", study, experiment, clock=clock) as reception:
                shown = await reception.enter(token, {})
                if reloads:
                    before = shown
                    shown = await reception.enter(shown.token, {})
                    assert (shown.scene, shown.turn) == (before.scene, before.turn)
                if shown.scene.kind == "debrief":
                    return
                token = shown.token
                shown = await reception.act(token, shown.lease, shown.turn, await player.act(shown), {})
        raise AssertionError(shown)

    asyncio.run(broken_off())
    once, often = (load(tmp_path / name) for name in ("once", "often"))
    assert [as_played(trial) for trial in often] == [as_played(trial) for trial in once]
    assert len(records(tmp_path / "often")) == len(once)


def test_an_act_whose_reply_was_lost_is_answered_again_and_counts_once(tmp_path):
    study = people_study()

    async def doubled() -> None:
        player = Player(tmp_path, study, "human-inspired")
        async with opened(tmp_path, study, short()) as reception:
            shown = await reception.enter(None, {})
            while shown.scene.kind != "debrief":
                act, turn = await player.act(shown), shown.turn
                replies = [await reception.act(shown.token, shown.lease, turn, act, {}) for _ in range(3)]
                assert replies[0] == replies[1] == replies[2]
                shown = replies[0]

    asyncio.run(doubled())
    for trial in load(tmp_path):
        assert as_played(trial) == as_played(without_page(study, trial, "human-inspired"))


@pytest.mark.parametrize("reached", [False, True])
def test_an_act_that_reached_the_disk_or_did_not_before_a_kill_is_sent_again_and_counts_once(tmp_path, reached):
    study = people_study()

    async def killed() -> None:
        async with opened(tmp_path, study, short()) as reception:
            player = Player(tmp_path, study, "human-inspired")
            box = await to_first(Box, reception, await reception.enter(None, {}))
            for _ in range(3):
                act, before = await player.act(box), box
                box = await reception.act(box.token, box.lease, box.turn, act, {})
        whole = acts(tmp_path, box.identity)
        rewrite_acts(tmp_path, box.identity, whole if reached else whole[:-1])
        async with opened(tmp_path, study, short()) as reception:
            again = await reception.act(before.token, before.lease, before.turn, act, {})
            assert (again.scene, again.turn) == (box.scene, box.turn)
            assert len(acts(tmp_path, box.identity)) == len(whole)
            await go_on(reception, player, again)

    asyncio.run(killed())
    for trial in load(tmp_path):
        assert as_played(trial) == as_played(without_page(study, trial, "human-inspired"))


def test_after_a_restart_an_old_page_whose_act_is_refused_does_not_take_the_place_of_the_newer_one(tmp_path):
    async def two() -> None:
        async with opened(tmp_path, people_study(), short()) as reception:
            old = await to_first(Box, reception, await reception.enter(None, {}))
            new = await reception.enter(old.token, {})
            new = await reception.act(new.token, new.lease, new.turn, CHOICE, {})
        async with opened(tmp_path, people_study(), short()) as reception:
            later = CHOICE.model_copy(update={"rt": 2.0})
            assert await refused(reception, old, later) == "stale"
            assert await refused(reception, replace(old, turn=new.turn), later) == "impossible"
            act = CHOICE.model_copy(update={"claimed": "moved"})
            assert (await reception.act(new.token, new.lease, new.turn, act, {})).turn == new.turn + 1
            assert await refused(reception, replace(old, turn=new.turn + 1), act) == "elsewhere"

    asyncio.run(two())


def test_of_the_platform_only_what_was_asked_for_is_kept_and_only_what_it_sends(tmp_path):
    platform = {"PROLIFIC_PID": "5f-a.b_c", "email": "ann@example.org"}
    (shown,) = take_part(tmp_path, people_study(), short(), platform=platform)
    assert diary_of(tmp_path, shown.identity)[0].platform == {"PROLIFIC_PID": "5f-a.b_c"}
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and "ann@" in path.read_text("latin-1")]
    for value in ("", "a b", "<script>", "../x", "a" * 65, "%00", "é", "a\n"):
        with pytest.raises(ActRefused) as refusal:
            take_part(tmp_path, people_study(), short(), platform={"PROLIFIC_PID": value})
        assert refusal.value.code == "incomplete"
        assert value.strip() == "" or value not in str(refusal.value)


def test_another_person_at_the_same_browser_is_another_participant(tmp_path):
    async def one_computer() -> None:
        study = people_study()
        async with opened(tmp_path, study, short()) as reception:
            first = await reception.enter(None, {"PROLIFIC_PID": "ann"})
            first = await reception.act(first.token, first.lease, 1, Agree(agreed=True), {"PROLIFIC_PID": "ann"})
            first = await go_on(reception, Player(tmp_path, study, "random"), first)
            again = await reception.enter(first.token, {"PROLIFIC_PID": "ann"})
            assert (again.token, again.scene.kind) == (first.token, "debrief")
            second = await reception.enter(first.token, {"PROLIFIC_PID": "bob"})
            assert second.token != first.token
            assert second.scene.kind == "consent"

    asyncio.run(one_computer())

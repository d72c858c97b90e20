"""Places are as many as there are; who was away too long makes room; nobody takes part twice."""

import asyncio
from collections import Counter

import pytest
from seated import Clock, Player, diary_of, flow, free, go_on, leaves, opened, people_study, short, take_part, to_first

from lockprobe.people.diary import Released, read_diaries
from lockprobe.people.journey import Journey
from lockprobe.people.responses import Agree, Next
from lockprobe.people.roster import Roster
from lockprobe.people.scenes import Box
from lockprobe.studies.records.read_records import load

HOURS = 3600.0


def at_first_step(shown):
    """Where somebody stops."""
    return isinstance(shown.scene, Box) and shown.scene.step == 2


def slots_given(directory):
    return [slot for diary in read_diaries(directory) for slot in diary.joined.slots]


def test_as_many_take_part_as_there_are_trials_for_and_each_is_played_once(tmp_path):
    study = people_study()
    last = take_part(tmp_path, study, short(), people=7)
    assert sorted(shown.scene.kind for shown in last) == ["closed"] * 3 + ["debrief"] * 4
    assert {shown.scene.why for shown in last if shown.scene.kind == "closed"} == {"full"}
    trials = load(tmp_path)
    assert len(trials) == len({trial.key for trial in trials}) == study.size == len(slots_given(tmp_path))


def test_no_more_take_part_than_the_experimenter_wants(tmp_path):
    last = take_part(tmp_path, people_study(), short(participants=2), people=3)
    assert sorted(shown.scene.kind for shown in last) == ["closed", "debrief", "debrief"]
    (shown,) = take_part(tmp_path, people_study(), short(participants=2))
    assert (shown.scene.why, shown.identity) == ("full", None)
    (shown,) = take_part(tmp_path, people_study(), short(participants=3))
    assert shown.scene.kind == "debrief"


def test_what_is_left_is_given_even_if_it_is_less(tmp_path):
    study = people_study(trials=3)
    take_part(tmp_path, study, short(trials_each=2), people=2)
    (shown,) = take_part(tmp_path, study, short(trials_each=2), platform={"PROLIFIC_PID": "ann"})
    assert len(diary_of(tmp_path, shown.identity)[0].slots) == 2
    assert len(load(tmp_path)) == study.size


def test_nobody_takes_part_twice_under_one_name_of_the_platform(tmp_path):
    names = {"PROLIFIC_PID": "ann", "STUDY_ID": "s"}
    first, second = take_part(tmp_path, people_study(), short(), people=2, platform=names)
    kinds = {first.scene.kind: first, second.scene.kind: second}
    assert kinds["closed"].scene.why == "taken"
    (again,) = take_part(tmp_path, people_study(), short(), platform=names)
    assert again.scene.why == "finished"
    (other,) = take_part(tmp_path, people_study(), short(), platform={"PROLIFIC_PID": "bob", "STUDY_ID": "s"})
    assert other.scene.kind == "debrief"


def test_without_names_of_a_platform_everybody_is_somebody_new(tmp_path):
    last = take_part(tmp_path, people_study(), short(recruitment=[]), people=2, platform={"PROLIFIC_PID": "ann"})
    assert [shown.scene.kind for shown in last] == ["debrief"] * 2
    assert diary_of(tmp_path, last[0].identity)[0].platform == {}


@pytest.mark.parametrize(("away", "kind"), [(23.0, "closed"), (25.0, "debrief")])
def test_who_was_away_too_long_makes_room_for_others(tmp_path, away, kind):
    clock, study = Clock(), people_study(p=(0.0,), trials=1)
    (left,) = take_part(tmp_path, study, short(), until=at_first_step, clock=clock)
    clock.now += away * HOURS
    (comes,) = take_part(tmp_path, study, short(), clock=clock)
    assert comes.scene.kind == kind
    lines = diary_of(tmp_path, left.identity)
    assert isinstance(lines[-1], Released) == (kind == "debrief")


def test_nobody_is_sent_away_as_long_as_there_is_room(tmp_path):
    clock, study = Clock(), people_study(trials=3)
    (left,) = take_part(tmp_path, study, short(), until=at_first_step, clock=clock)
    clock.now += 1000 * HOURS
    take_part(tmp_path, study, short(), clock=clock)
    assert not isinstance(diary_of(tmp_path, left.identity)[-1], Released)


def test_who_comes_back_goes_on_however_late_as_long_as_nobody_needed_the_place(tmp_path):
    clock, study = Clock(), people_study()
    (left,) = take_part(tmp_path, study, short(), until=at_first_step, clock=clock)
    take_part(tmp_path, study, short(), clock=clock)  # finds a free place

    async def comes_back():
        async with opened(tmp_path, study, short(), clock=clock) as reception:
            clock.now += 1000 * HOURS
            first = await reception.enter(left.token, {})
            assert (first.scene, first.turn) == (left.scene, left.turn)
            player = Player(tmp_path, study, "round-robin")
            on = await go_on(reception, player, first, lambda shown: shown.scene.kind == "over")
            clock.now += 1000 * HOURS
            on = await reception.act(on.token, on.lease, on.turn, await player.act(on), {})  # in the same tab
            return await go_on(reception, player, on), flow(reception)

    shown, progress = asyncio.run(comes_back())
    assert shown.scene.kind == "debrief"
    assert (progress.finished, len(load(tmp_path))) == (2, 4)


def test_whose_place_was_given_away_does_not_go_on_in_the_same_tab_or_later_or_with_more_time(tmp_path):
    clock, study = Clock(), people_study(trials=2)
    take_part(tmp_path, study, short(), clock=clock)
    (left,) = take_part(tmp_path, study, short(), until=lambda shown: shown.scene.kind == "over", clock=clock)

    async def comes_back(experiment):
        async with opened(tmp_path, study, experiment, clock=clock) as reception:
            tab = await reception.enter(left.token, {})
            if tab.scene.kind != "closed":
                clock.now += 25 * HOURS
                new = await reception.enter(None, {})
                new = await reception.act(new.token, new.lease, 1, Agree(agreed=True), {})
                assert len(diary_of(tmp_path, new.identity)[0].slots) == 1
                tab = await reception.act(tab.token, tab.lease, tab.turn, Next(), {})
            again = await reception.enter(left.token, {})
            assert tab.scene.why == again.scene.why == "late"
            assert again.identity
            return free(reception)

    for experiment in (short(), short(away_minutes=100_000)):
        assert asyncio.run(comes_back(experiment)) == [0, 0]
    assert len(load(tmp_path)) == 3  # what was finished stays


def test_who_has_just_come_back_is_not_sent_away_for_a_newcomer(tmp_path):
    clock, study = Clock(), people_study(p=(0.0,), trials=1)
    (left,) = take_part(tmp_path, study, short(), until=at_first_step, clock=clock)

    async def both():
        async with opened(tmp_path, study, short(), clock=clock) as reception:
            clock.now += 25 * HOURS
            back = await reception.enter(left.token, {})
            assert (await reception.enter(None, {})).scene.why == "full"
            return await go_on(reception, Player(tmp_path, study, "round-robin"), back)

    assert asyncio.run(both()).scene.kind == "debrief"


def test_who_has_played_all_boxes_is_never_too_late(tmp_path):
    clock, study = Clock(), people_study()
    asking = short(questions=[{"name": "how", "question": "How?"}])
    (left,) = take_part(tmp_path, study, asking, until=lambda shown: shown.scene.kind == "ask", clock=clock)
    clock.now += 1000 * HOURS

    async def comes_back():
        async with opened(tmp_path, study, asking, clock=clock) as reception:
            return await reception.enter(left.token, {})

    assert asyncio.run(comes_back()).scene.kind == "ask"


def test_what_somebody_left_is_played_by_others_and_no_luck_is_met_twice(tmp_path):
    clock, study = Clock(), people_study(p=(0.0, 0.2, 0.4), trials=4)
    take_part(tmp_path, study, short(), people=2, until=at_first_step, clock=clock)
    clock.now += 48 * HOURS
    take_part(tmp_path, study, short(), people=6, clock=clock)
    trials = load(tmp_path)
    assert len({trial.key for trial in trials}) == len(trials) == study.size
    by_agent = {trial.agent for trial in trials}
    for agent in by_agent:
        lucks = [(trial.repetition, trial.trial) for trial in trials if trial.agent == agent]
        assert len(set(lucks)) == len(lucks)


def test_many_at_once_share_out_what_is_left_without_a_trial_twice(tmp_path):
    study = people_study(trials=5)

    async def rush():
        async with opened(tmp_path, study, short()) as reception:
            everybody = [await reception.enter(None, {}) for _ in range(12)]
            return await asyncio.gather(
                *(reception.act(one.token, one.lease, 1, Agree(agreed=True), {}) for one in everybody)
            )

    kinds = [shown.scene.kind for shown in asyncio.run(rush())]
    assert kinds.count("closed") == 7
    assert len(set(slots_given(tmp_path))) == len(slots_given(tmp_path)) == 10


def test_nobody_is_sent_away_for_somebody_who_cannot_join(tmp_path):
    clock, study, name = Clock(), people_study(trials=2), {"PROLIFIC_PID": "ann"}
    (left,) = take_part(tmp_path, study, short(), until=at_first_step, clock=clock)
    take_part(tmp_path, study, short(), clock=clock, platform=name)
    clock.now += 48 * HOURS

    async def again():
        async with opened(tmp_path, study, short(), clock=clock) as reception:
            shown = await reception.enter(None, name)
            return await reception.act(shown.token, shown.lease, 1, Agree(agreed=True), name)

    assert asyncio.run(again()).scene.why == "finished"
    assert not isinstance(diary_of(tmp_path, left.identity)[-1], Released)


@pytest.mark.slow
def test_where_plants_have_cameras_only_so_many_trials_are_held(tmp_path, monkeypatch):
    monkeypatch.setattr("lockprobe.people.roster._MOST_WITH_CAMERA", 2)
    study = people_study(p=(0.0,), plant="fast-twin?width=64&height=64", modalities=("rgb",), max_steps=2)

    async def four():
        async with opened(tmp_path, study, short()) as reception:
            people = []
            for _ in range(4):
                people.append(await to_first(Box, reception, await reception.enter(None, {})))
                assert sum(seat.holds for seat in reception._roster) <= 2
            held = [seat.journey.joined.identity for seat in reception._roster if seat.holds]
            assert held == [shown.identity for shown in people[2:]]  # those who did something last
            for shown in people:
                again = await reception.enter(shown.token, {})
                assert again.scene == shown.scene

    asyncio.run(four())


def test_as_long_as_anything_is_left_somebody_can_join(tmp_path):
    study = people_study(trials=1)
    for kind in ("debrief", "debrief", "closed"):
        (shown,) = take_part(tmp_path, study, short(trials_each=1))
        assert shown.scene.kind == kind


def test_orders_stay_balanced_when_everybody_leaves_after_a_box(tmp_path):
    clock, study = Clock(), people_study(p=(0.0, 0.2, 0.4, 0.5), trials=8, max_steps=2)
    for _ in range(8):  # each is sent away for the next
        take_part(tmp_path, study, short(participants=1), until=lambda one: one.scene.kind == "over", clock=clock)
        clock.now += 48 * HOURS
    joined = [diary.joined for diary in read_diaries(tmp_path)]
    assert Counter(one.slots[0].condition for one in joined) == {one.label: 2 for one in study.conditions}
    assert Counter(trial.p for trial in load(tmp_path)) == dict.fromkeys(study.p, 2)
    assert set(Counter(tuple(slot.condition for slot in one.slots) for one in joined).values()) == {2}


def test_joining_looks_at_nobody_else_however_many_have_joined(tmp_path, monkeypatch):
    looked = []
    kept = Journey.slots_kept.fget
    monkeypatch.setattr(Journey, "slots_kept", property(lambda self: looked.append(self.joined.identity) or kept(self)))
    monkeypatch.setattr(Roster, "__iter__", lambda self: looked.append("all") or iter(tuple(self._sessions.values())))

    async def come():
        async with opened(tmp_path, people_study(trials=40), short()) as reception:
            looked.clear()
            for number in range(20):
                shown = await reception.enter(None, {"PROLIFIC_PID": f"p{number}"})
                shown = await reception.act(
                    shown.token, shown.lease, 1, Agree(agreed=True), {"PROLIFIC_PID": f"p{number}"}
                )
                assert shown.identity
            once = list(looked)
            await leaves(reception, shown.token)
            after = reception._roster.assigned()
            reception._roster._given = None
            assert reception._roster.assigned() == after
            return once

    once = asyncio.run(come())
    assert set(once) == {"all"}
    assert len(once) <= 2  # when the first one comes, and once in a while

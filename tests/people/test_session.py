"""What one participant does is on disk before more is shown, or it has not been done."""

import asyncio
from dataclasses import dataclass, replace

import pytest
from pydantic import ValidationError
from seated import (
    Clock,
    Player,
    as_played,
    diary_of,
    flow,
    free,
    go_on,
    opened,
    people_study,
    refused,
    right_answers,
    short,
    sitting,
    take_part,
    to_first,
    without_page,
)
from seen import PhotographedPlant
from stored import acts, records, rewrite_acts

from lockprobe.foundation.errors import BadFile
from lockprobe.people.diary import Broken, Did
from lockprobe.people.experiment import Experiment
from lockprobe.people.responses import Agree, Answer, Answers, Attempt, Next
from lockprobe.people.scenes import (
    Ask,
    Box,
    Check,
    Closed,
    ComprehensionQuestions,
    Debrief,
    InstructionPage,
    TrialOver,
)
from lockprobe.plants import catalogue
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import Timing
from lockprobe.trial.condition import Condition

STUDY = people_study(max_steps=5)
ASKING = {
    "checks": [{"after": 0, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}],
    "questions": [
        {"name": "how", "question": "How?"},
        {"name": "age", "question": "Age?", "options": ["young", "old"], "required": True},
        {"name": "why", "question": "Why?", "required": True},
    ],
}


def test_an_answer_is_one_of_the_options_or_words_and_is_kept_as_it_is(tmp_path):
    text = "<script>alert('1')</script>\n{budget} ../../x \x00 é 鍵"

    async def answers(reception, shown):
        shown = await to_first(Check, reception, shown)
        for wrong in (Answer(answer="green", rt=1.0), Answer(answer="", rt=1.0), Next()):
            assert await refused(reception, shown, wrong) == "impossible"
        shown = await reception.act(shown.token, shown.lease, shown.turn, Answer(answer="red", rt=1.0), {})
        shown = await to_first(Ask, reception, shown)
        assert shown.scene.longest == 2000
        Answer(answer="a" * 2000, rt=1.0)
        with pytest.raises(ValidationError):
            Answer(answer="a" * 2001, rt=1.0)
        for answer in (text, "old", "because"):
            shown = await reception.act(shown.token, shown.lease, shown.turn, Answer(answer=answer, rt=7.25), {})
            assert (
                shown.scene.kind != "ask" or await refused(reception, shown, Answer(answer=" ", rt=1.0)) == "impossible"
            )
        assert await refused(reception, shown, Next()) == "impossible"
        return shown

    shown = sitting(tmp_path, STUDY, answers, experiment=short(**ASKING))
    assert shown.scene.kind == "debrief"
    lines = [line for line in diary_of(tmp_path, shown.identity) if isinstance(line, Did)]
    assert [(line.item, line.act.answer) for line in lines if line.scene == "ask"] == [
        ("how", text), ("age", "old"), ("why", "because"),
    ]  # fmt: skip
    assert [(line.item, line.right) for line in lines if line.scene == "check"] == [("1", False)]
    assert not any("<script>" in str(record) for record in records(tmp_path))


def wrong_answers(scene):
    """Answers to questions on the instructions, the first of which is wrong."""
    right = right_answers(scene)
    other = next(option for option in scene.questions[0].options if option != right.answers[0])
    return right.model_copy(update={"answers": (other, *right.answers[1:])})


def test_wrong_answers_on_the_instructions_lead_back_to_them_until_they_are_right(tmp_path):
    async def answers(reception, shown):
        for _ in range(2):
            shown = await to_first(ComprehensionQuestions, reception, shown)
            act = wrong_answers(shown.scene)
            shown = await reception.act(shown.token, shown.lease, shown.turn, act, {})
            assert isinstance(shown.scene, InstructionPage)
            assert shown.scene.notice
        shown = await to_first(ComprehensionQuestions, reception, shown)
        right = right_answers(shown.scene)
        for impossible in (Next(), Answers(answers=(), rt=1.0), Answers(answers=("other", *right.answers[1:]), rt=1.0)):
            assert await refused(reception, shown, impossible) == "impossible"
        return await reception.act(shown.token, shown.lease, shown.turn, right, {})

    shown = sitting(tmp_path, STUDY, answers, experiment=Experiment())
    assert shown.scene.practice
    rounds = [did for did in diary_of(tmp_path, shown.identity)[1:] if did.scene == "comprehension"]
    assert [(did.item, did.right) for did in rounds] == [("1", False), ("2", False), ("3", True)]


def test_after_the_limit_of_rounds_the_session_ends_and_its_places_are_free(tmp_path):
    experiment = Experiment(comprehension={"rounds": 1}, left_url="https://example.org/no", left_code="S1")

    async def fails(reception, shown):
        before = free(reception)
        shown = await to_first(ComprehensionQuestions, reception, shown)
        shown = await reception.act(shown.token, shown.lease, shown.turn, wrong_answers(shown.scene), {})
        assert (shown.scene.why, shown.scene.completion_code) == ("screened", "S1")
        assert shown.progress is None
        assert await refused(reception, shown, Next()) == "impossible"
        return shown, before, free(reception), flow(reception)

    shown, before, after, progress = sitting(tmp_path, STUDY, fails, experiment=experiment)
    assert (before, after) == ([3, 3], [4, 4])
    assert (progress.screened, progress.left_open, progress.finished) == (1, 0, 0)
    assert load(tmp_path) == []

    async def comes_back():
        async with opened(tmp_path, STUDY, experiment) as reception:
            return await reception.enter(shown.token, {})

    assert asyncio.run(comes_back()).scene == shown.scene


IDS = {"PROLIFIC_PID": "5f1"}
CODES = {"completion_code": "C1", "left_code": "S1"}
CHECK = {"after": 1, "question": "Blue?", "options": ["red", "blue"], "right": "blue"}


@pytest.mark.parametrize(
    ("to", "settings", "scene"),
    [
        (Debrief, {}, ("finished", "C1")),
        (Debrief, {"checks": [CHECK]}, ("finished", "C1")),
        (Closed, {"comprehension": {"rounds": 1}}, ("screened", "S1")),
        (TrialOver, {}, ("taken", "")),
    ],
)
def test_who_comes_back_in_another_browser_reads_their_code_again_and_no_more(tmp_path, to, settings, scene):
    experiment, wrong = short(**CODES, **settings), "rounds" in settings.get("comprehension", {})

    async def comes_back():
        async with opened(tmp_path, STUDY, experiment) as reception:
            stranger = await reception.enter(None, IDS)  # opens the page twice before anybody agrees
            shown = await reception.enter(None, IDS)
            shown = await reception.act(shown.token, shown.lease, 1, Agree(agreed=True), IDS)
            if wrong:
                shown = await to_first(ComprehensionQuestions, reception, shown)
                shown = await reception.act(shown.token, shown.lease, shown.turn, wrong_answers(shown.scene), IDS)
            shown = await to_first(to, reception, shown)
            agrees = await reception.act(stranger.token, stranger.lease, 1, Agree(agreed=True), IDS)
            return shown, await reception.enter(shown.token, IDS), await reception.enter(None, IDS), agrees

    shown, reloaded, elsewhere, agrees = asyncio.run(comes_back())
    assert (reloaded.scene, reloaded.identity) == (shown.scene, shown.identity)
    assert (elsewhere.scene.why, elsewhere.scene.completion_code) == scene
    assert agrees.scene == elsewhere.scene
    assert (elsewhere.identity, elsewhere.progress) == (None, None)


def test_a_question_that_is_not_required_can_be_passed_over(tmp_path):
    async def passes(reception, shown):
        shown = await to_first(Ask, reception, shown)
        return await reception.act(shown.token, shown.lease, shown.turn, Answer(answer="", rt=1.0), {})

    assert sitting(tmp_path, STUDY, passes, experiment=short(**ASKING)).scene.name == "age"


def test_what_the_last_action_did_is_said_where_it_is_asked_and_only_there(tmp_path):
    async def first_steps(reception, shown):
        shown = await to_first(Box, reception, shown)
        label = shown.scene.panel.joints[0].label
        claimed = Attempt(joint=label, claimed="moved", rt=1.0, claimed_rt=1.0)
        assert await refused(reception, shown, claimed) == "impossible"
        assert await refused(reception, shown, Attempt(joint=label, rt=1.0, claimed_rt=1.0)) == "impossible"
        shown = await reception.act(shown.token, shown.lease, shown.turn, Attempt(joint=label, rt=1.0), {})
        assert shown.scene.ask
        assert await refused(reception, shown, Attempt(joint=label, rt=1.0)) == "impossible"
        return await reception.act(shown.token, shown.lease, shown.turn, claimed, {})

    assert sitting(tmp_path, STUDY, first_steps).scene.step == 3


def test_a_step_is_on_disk_when_it_is_shown_with_its_times_and_what_was_told(tmp_path):
    async def one_step(reception, shown):
        shown = await to_first(Box, reception, shown)
        act = Attempt(joint=shown.scene.panel.joints[1].label, rt=1234.5)
        shown = await reception.act(shown.token, shown.lease, shown.turn, act, {})
        line = acts(tmp_path, shown.identity)[-1]
        assert line["act"] == act.model_dump()
        assert (line["box"], line["step"], line["turn"]) == (1, 1, shown.turn - 1)
        assert line["told"].startswith(f"You attempted {act.joint}.")
        assert line["shown"] == " ".join(shown.scene.panel.report)
        assert line["ended"] is None

    sitting(tmp_path, STUDY, one_step)


def test_a_trial_that_could_not_be_written_down_is_written_down_later(tmp_path, monkeypatch):
    def fails(journal, trial, timing):
        raise BadFile(tmp_path, "cannot be written")

    async def full_disk(reception, shown):
        player = Player(tmp_path, STUDY, "round-robin")
        with monkeypatch.context() as patched:
            patched.setattr("lockprobe.studies.records.journal.Journal.append", fails)
            with pytest.raises(BadFile):
                await go_on(reception, player, shown)
        assert load(tmp_path) == []
        shown = await reception.enter(shown.token, {})
        assert shown.scene.kind == "over"
        assert len(load(tmp_path)) == 1
        await go_on(reception, player, shown)

    sitting(tmp_path, STUDY, full_disk)
    assert len(load(tmp_path)) == len(records(tmp_path)) == 2


def test_what_would_be_another_history_is_not_shown(tmp_path):
    async def first(reception, shown):
        shown = await to_first(Box, reception, shown)
        act = Attempt(joint=shown.scene.panel.joints[1].label, rt=1.0)
        return await reception.act(shown.token, shown.lease, shown.turn, act, {})

    shown = sitting(tmp_path, STUDY, first)
    *before, last = acts(tmp_path, shown.identity)
    rewrite_acts(tmp_path, shown.identity, [*before, last | {"told": last["told"].replace("At 1", "At 0")}])

    async def later():
        async with opened(tmp_path, STUDY, short()) as reception:
            await reception.enter(shown.token, {})

    with pytest.raises(BadFile, match="as it was shown before"):
        asyncio.run(later())


def test_a_trial_that_waits_for_nobody_is_let_go_of_and_goes_on(tmp_path, monkeypatch):
    closed = []

    class Plant(PhotographedPlant):
        def close(self):
            closed.append(self)

    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: Plant(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)
    clock = Clock()

    async def waits(reception, shown):
        shown = await to_first(Box, reception, shown)
        closed.clear()  # of the example for the instructions
        clock.now += 300
        await reception.enter(None, {})
        assert closed == []
        clock.now += 400
        await reception.enter(None, {})
        assert len(closed) == 1
        act = Attempt(joint=shown.scene.panel.joints[1].label, rt=1.0)
        return await reception.act(shown.token, shown.lease, shown.turn, act, {})

    assert sitting(tmp_path, STUDY, waits, clock=clock).scene.step == 2
    assert len(closed) == 2


def test_the_practice_is_no_trial(tmp_path):
    async def practises(reception, shown):
        return await to_first(Box, reception, shown)

    shown = sitting(tmp_path, STUDY, practises, experiment=Experiment())
    assert (shown.scene.practice, shown.scene.number, len(shown.scene.panel.joints)) == (True, 0, 4)

    async def done(reception, shown):
        player = Player(tmp_path / "b", STUDY, "round-robin")
        return await go_on(reception, player, shown, lambda one: one.scene.kind == "over")

    shown = sitting(tmp_path / "b", STUDY, done, experiment=Experiment())
    assert shown.scene.practice
    assert records(tmp_path / "b") == []


def test_an_act_that_is_broken_off_has_been_done_or_not(tmp_path):
    async def broken_off(reception, shown):
        player, done = Player(tmp_path, STUDY, "round-robin"), set()
        for moments in range(40):
            if shown.scene.kind == "debrief":
                break
            act = await player.act(shown)
            task = asyncio.create_task(reception.act(shown.token, shown.lease, shown.turn, act, {}))
            for _ in range(moments % 7):
                await asyncio.sleep(0)
            done.add(not task.cancel())
            await asyncio.gather(task, return_exceptions=True)
            turn, back = shown.turn, await reception.enter(shown.token, {})
            assert back.turn in (turn, turn + 1)
            shown = await reception.act(back.token, back.lease, turn, act, {})  # the page sends it again
            assert shown.turn == turn + 1
        assert done == {True, False}

    sitting(tmp_path, STUDY, broken_off)
    trials = load(tmp_path)
    assert [len(trial.steps) for trial in trials if trial.ending == "budget"]
    for trial in trials:
        assert as_played(trial, claims=False) == as_played(without_page(STUDY, trial, "round-robin"), claims=False)


def test_what_is_finished_on_record_is_never_written_over(tmp_path, monkeypatch):
    take_part(tmp_path / "there", STUDY, short())
    comes = load(tmp_path / "there")[0]
    monkeypatch.setattr("lockprobe.people.session.Session._is_played", lambda seat: False)

    async def plays(reception, shown):
        shown = await to_first(Box, reception, shown)
        reception._opened.journal.append(comes, Timing(key=comes.key, seconds=1.0, steps=len(comes.steps)))
        return await to_first(Debrief, reception, shown)

    shown = sitting(tmp_path / "here", STUDY, plays)
    slots = diary_of(tmp_path / "here", shown.identity)[0].slots
    assert (comes.condition, comes.repetition, comes.trial) == (slots[0].condition, slots[0].repetition, slots[0].trial)
    assert [trial.agent for trial in load(tmp_path / "here")] == [comes.agent, f"participant:{shown.identity}"]
    assert len(records(tmp_path / "here")) == 2


STUDY = people_study(max_steps=5)


class _Fragile(SymbolicPlant):
    """Breaks at some of all attempts, and cannot be seen where it is dark."""

    attempts = 0
    breaks: tuple[int, ...] = ()
    dark = False

    def observe(self):
        if type(self).dark:
            raise OSError("no light")
        return super().observe()

    def attempt(self, joint):
        type(self).attempts += 1
        if type(self).attempts in type(self).breaks:
            raise OSError("stuck")
        return super().attempt(joint)


@pytest.fixture
def plant(monkeypatch):
    class Plant(_Fragile):
        pass

    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: Plant(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)
    return Plant


def test_a_box_that_breaks_is_no_failure_and_the_next_one_comes(tmp_path, plant):
    plant.breaks = (4,)  # one attempt is that of the example

    async def breaks(reception, shown):
        player = Player(tmp_path, STUDY, "round-robin")
        shown = await go_on(reception, player, shown, lambda one: one.scene.kind == "over")
        assert (shown.scene.number, shown.scene.solved) == (1, None)
        assert sum(free(reception)) == 7
        return await go_on(reception, player, shown)

    shown = sitting(tmp_path, STUDY, breaks)
    first, second = load(tmp_path)
    assert (first.ending, first.error.boundary, len(first.steps), first.owed_again) == ("error", "plant", 2, True)
    assert second.ending in ("solved", "budget")
    ended = [line.ended for line in diary_of(tmp_path, shown.identity) if isinstance(line, Did) and line.ended]
    assert ended == ["error", second.ending]


def test_a_box_that_cannot_be_shown_is_passed_over(tmp_path, plant):
    async def dark(reception, shown):
        player = Player(tmp_path, STUDY, "round-robin")
        plant.dark = True
        shown = await go_on(reception, player, shown, lambda one: one.scene.kind == "over")
        plant.dark = False
        return await go_on(reception, player, shown)

    shown = sitting(tmp_path, STUDY, dark)
    assert [trial.ending == "error" for trial in load(tmp_path)] == [True, False]
    assert [(line.box, line.turn) for line in diary_of(tmp_path, shown.identity) if isinstance(line, Broken)] == [
        (1, 4)
    ]
    turns = [line.turn for line in diary_of(tmp_path, shown.identity)[1:]]
    assert turns == list(range(2, 2 + len(turns)))


@dataclass(frozen=True, kw_only=True)
class Insisting:
    """Somebody's own intervention, which asks from the second step on for what no page asks."""

    def brief(self, briefing, past, task, rng):
        return replace(briefing.remarking("Look."), instruction="Open it." * (len(past) > 1))


def test_a_box_in_which_more_is_asked_than_the_page_can_ask_breaks_and_the_next_one_comes(tmp_path):
    study = replace(STUDY, conditions=(Condition(interventions=(Insisting(),), name="insisting"), Condition()))
    take_part(tmp_path, study, short())
    insisting, true = sorted(load(tmp_path), key=lambda trial: trial.condition)
    assert (insisting.ending, insisting.error.boundary, len(insisting.steps)) == ("error", "channel", 1)
    assert (insisting.steps[0].remark, insisting.owed_again) == ("Look.", True)
    assert true.ending in ("solved", "budget")


def test_a_page_that_shows_a_box_which_broke_in_the_meantime_has_to_ask_anew(tmp_path, plant):
    async def broke(reception, shown):
        shown = await to_first(Box, reception, shown)
        for seat in reception._roster:
            await seat.let_go()
        plant.dark = True
        act = Attempt(joint=shown.scene.panel.joints[0].label, rt=1.0)
        assert await refused(reception, shown, act) == "stale"
        return await reception.enter(shown.token, {})

    assert sitting(tmp_path, STUDY, broke).scene.kind == "over"

"""People play the trials that strategies play, whatever happens to pages, networks, disks and servers in between.

What one participant does is on disk before more is shown, or it has not been done.
"""

import asyncio

import pytest
from pydantic import ValidationError
from seated import (
    GO_ON,
    Player,
    an_act,
    as_played,
    diary_of,
    free,
    go_on,
    opened,
    people_study,
    refused,
    short,
    sitting,
    take_part,
    to_first,
    under,
    without_page,
)
from stored import acts, records, timings

from lockprobe.people.diary import Agree, Answers, Attempt
from lockprobe.people.experiment import Experiment
from lockprobe.people.scenes import ActRefused
from lockprobe.plants import catalogue
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.read_records import load

STUDY = people_study(max_steps=5)
CHECK = {"after": 0, "question": "Blue?", "options": ["blue", "red"], "right": "blue"}
ASKING = {
    "checks": [CHECK],
    "questions": [
        {"name": "how", "question": "How?"},
        {"name": "age", "question": "Age?", "options": ["young", "old"], "required": True},
        {"name": "why", "question": "Why?", "required": True},
    ],
}
CONDITIONS = (
    "truth", "flip?p=0.4 + nudge", "distract?p=0.5 + warn", "correction?p=0.4", "drop?p=0.3",
    "delay?lag=2", "tremble?p=0.3", "tremble?p=1&at=3", "flip?p=0.4&only=blocked + symbolic",
)  # fmt: skip
SILENT = ("round-robin", "random")
"""Strategies that say nothing of what they are told, and are asked here."""


@pytest.mark.parametrize(
    ("spec", "study"),
    [
        ("human-inspired", people_study(flip="outcome-only", layout="shuffled")),
        ("human-inspired:proximity", people_study(layout="shuffled")),
        ("ideal-observer", people_study(flip="integrated", layout="shuffled", assessment=False)),
        ("round-robin", people_study(layout="shuffled")),
        ("human-inspired", under(*CONDITIONS, trials=11)),
    ],
)
def test_a_strategy_at_the_page_plays_as_without_it_under_any_condition(tmp_path, spec, study):
    take_part(tmp_path, study, Experiment(history=False), spec)
    trials = load(tmp_path)
    assert {trial.condition for trial in trials} == {one.label for one in study.conditions}
    for trial in trials:
        alone = without_page(study, trial, spec)
        claims = spec not in SILENT and not trial.condition.startswith(("drop", "delay"))  # of which nothing is told
        assert as_played(trial, claims=claims) == as_played(alone, claims=claims)
        assert [(step.remark, step.chosen) for step in trial.steps] == [(one.remark, one.chosen) for one in alone.steps]
        same = (
            "specs", "doses", "interventions", "channels", "changed", "opening", "ending", "key", "labels", "listing",
        )  # fmt: skip
        assert {name: getattr(trial, name) for name in same} == {name: getattr(alone, name) for name in same}


def test_a_record_says_on_what_it_was_played_how_long_it_took_and_nothing_of_who(tmp_path):
    platform = {"PROLIFIC_PID": "xyz", "STUDY_ID": "x", "email": "ann@example.org"}
    (shown,) = take_part(tmp_path, people_study(), short(), platform=platform)
    trials, (joined, *lines) = load(tmp_path), diary_of(tmp_path, shown.participant)
    assert shown.progress == {"share": 1.0, "done": 2, "of": 2}
    assert {trial.agent for trial in trials} == {f"participant:{shown.participant}"}
    assert [trial.facts["position"] for trial in trials] == [1, 2]
    assert dict(trials[0].facts) == {
        "view": "panel", "words": joined.words, "page": "1", "position": 1, "history": True, "feedback": False,
    }  # fmt: skip
    assert joined.platform == {"PROLIFIC_PID": "xyz", "STUDY_ID": "x"}
    assert "xyz" not in str(records(tmp_path))
    assert not [path for path in tmp_path.rglob("*") if path.is_file() and "ann@" in path.read_text("latin-1")]
    assert read_study(tmp_path).agents == ("participant",)
    steps = [line for line in lines if line.scene == "box" and line.box == 2]
    over = next(line for line in lines if line.scene == "over")
    assert over.box == 1
    assert timings(tmp_path)[1] == pytest.approx(steps[-1].at - over.at)
    assert timings(tmp_path, "steps")[1] == len(steps)


@pytest.mark.parametrize("turns", [0, 3, 9])
def test_an_act_that_is_broken_off_at_any_moment_is_sent_again_and_counts_once(tmp_path, turns):
    """However many turns of the event loop it has had."""

    async def broken_off(reception, shown):
        player = Player(tmp_path, STUDY, "human-inspired")
        while shown.scene.kind != "debrief":
            act = await player.act(shown)
            task = asyncio.create_task(reception.act(shown.token, shown.turn, act, {}))
            for _ in range(turns):
                await asyncio.sleep(0)
            task.cancel()
            await asyncio.gather(task, return_exceptions=True)
            back = await reception.enter(shown.token, {})
            assert back.turn in (shown.turn, shown.turn + 1)
            replies = [await reception.act(shown.token, shown.turn, act, {}) for _ in range(2)]
            assert replies[0] == replies[1]
            assert replies[0].turn == shown.turn + 1
            shown = replies[0]

    sitting(tmp_path, STUDY, broken_off)
    assert len(load(tmp_path)) == len(records(tmp_path)) == 2
    for trial in load(tmp_path):
        assert as_played(trial) == as_played(without_page(STUDY, trial, "human-inspired"))


def test_another_person_at_the_same_browser_is_another_participant(tmp_path):
    async def one_computer(reception, shown):
        ann, bob = {"PROLIFIC_PID": "ann"}, {"PROLIFIC_PID": "bob"}
        first = await reception.enter(None, ann)
        first = await reception.act(first.token, 1, Agree(agreed=True), ann)
        again, second = await reception.enter(first.token, ann), await reception.enter(first.token, bob)
        assert (again.token, again.scene) == (first.token, first.scene)
        assert (second.token == first.token, second.scene.kind) == (False, "consent")

    sitting(tmp_path, STUDY, one_computer)


def test_an_answer_is_one_of_the_options_or_words_and_is_kept_as_it_is(tmp_path):
    text = "<script>alert('1')</script>\n{budget} ../../x \x00 é 鍵"

    async def answers(reception, shown):
        shown = await to_first("check", reception, shown)
        for wrong in (says("green"), says(""), says("red", "red"), GO_ON):
            assert await refused(reception, shown, wrong) == "impossible"
        shown = await reception.act(shown.token, shown.turn, says("red"), {})
        shown = await to_first("ask", reception, shown)
        assert shown.scene.longest == 2000
        with pytest.raises(ValidationError):
            says("a" * 2001)
        for answer in (text, "old", "because"):
            shown = await reception.act(shown.token, shown.turn, says(answer), {})
            if shown.scene.kind == "ask":
                assert await refused(reception, shown, says(" ")) == "impossible"
        assert await refused(reception, shown, GO_ON) == "impossible"
        return shown

    shown = sitting(tmp_path, STUDY, answers, experiment=short(**ASKING))
    assert shown.scene.kind == "debrief"
    lines = diary_of(tmp_path, shown.participant)[1:]
    said = [(line.item, *line.act.answers, line.right) for line in lines if line.scene in ("check", "ask")]
    assert said == [("1", "red", False), ("how", text, None), ("age", "old", None), ("why", "because", None)]
    assert not any("<script>" in str(record) for record in records(tmp_path))


def says(*answers):
    return Answers(answers=answers, rt=7.25)


def test_wrong_answers_on_the_instructions_lead_back_to_them_until_they_are_right(tmp_path):
    async def answers(reception, shown):
        for _ in range(2):
            shown = await to_first("comprehension", reception, shown)
            right = an_act(shown.scene).answers
            wrong = next(option for option in shown.scene.questions[0].options if option != right[0])
            shown = await reception.act(shown.token, shown.turn, says(wrong, *right[1:]), {})
            assert (shown.scene.kind, bool(shown.scene.notice)) == ("page", True)
        shown = await to_first("comprehension", reception, shown)
        for impossible in (GO_ON, says("other", *right[1:])):
            assert await refused(reception, shown, impossible) == "impossible"
        return await reception.act(shown.token, shown.turn, says(*right), {})

    shown = sitting(tmp_path, STUDY, answers, experiment=Experiment())
    assert (shown.scene.practice, shown.scene.number, len(shown.scene.panel.joints)) == (True, 0, 4)
    rounds = [did for did in diary_of(tmp_path, shown.participant)[1:] if did.scene == "comprehension"]
    assert [(did.item, did.right) for did in rounds] == [("1", False), ("2", False), ("3", True)]


@pytest.mark.parametrize(
    ("to", "settings", "scene"),
    [
        ("debrief", {}, ("finished", "C1")),
        ("debrief", {"checks": [CHECK | {"after": 1}]}, ("finished", "C1")),
        ("over", {}, ("taken", "")),
    ],
)
def test_who_comes_back_in_another_browser_reads_their_code_again_and_no_more(tmp_path, to, settings, scene):
    experiment, ids = short(completion_code="C1", **settings), {"PROLIFIC_PID": "5f1"}

    async def comes_back():
        async with opened(tmp_path, STUDY, experiment) as reception:
            stranger = await reception.enter(None, ids)  # opens the page twice before anybody agrees
            shown = await reception.enter(None, ids)
            shown = await reception.act(shown.token, 1, Agree(agreed=True), ids)
            shown = await to_first(to, reception, shown)
            agrees = await reception.act(stranger.token, 1, Agree(agreed=True), ids)
            assert free(reception) == [3, 3]
            return shown, await reception.enter(shown.token, ids), await reception.enter(None, ids), agrees

    shown, reloaded, elsewhere, agrees = asyncio.run(comes_back())
    assert (reloaded.scene, reloaded.participant) == (shown.scene, shown.participant)
    assert (elsewhere.scene.why, elsewhere.scene.code) == scene
    assert agrees.scene == elsewhere.scene
    assert (elsewhere.participant, elsewhere.progress) == (None, None)


def test_a_step_is_on_disk_when_it_is_shown_and_says_what_the_last_one_did_where_that_is_asked(tmp_path):
    async def first_steps(reception, shown):
        shown = await to_first("box", reception, shown)
        label = shown.scene.panel.joints[1].label
        claimed = Attempt(joint=label, claimed="moved", rt=1.0, claimed_rt=1.0)
        assert await refused(reception, shown, claimed) == "impossible"
        assert await refused(reception, shown, Attempt(joint=label, rt=1.0, claimed_rt=1.0)) == "impossible"
        act = Attempt(joint=label, rt=1234.5, pointer="pen", viewport=(640, 480))
        shown = await reception.act(shown.token, shown.turn, act, {})
        line = acts(tmp_path, shown.participant)[-1]
        assert line["act"] == Attempt(joint=label, rt=1234.5).model_dump()
        assert (line["box"], line["step"], line["turn"], line["ended"]) == (1, 1, shown.turn - 1, None)
        assert line["told"].startswith(f"You attempted {label}.")
        assert line["shown"] == " ".join(shown.scene.panel.report)
        assert shown.scene.ask
        assert await refused(reception, shown, act) == "impossible"
        assert await refused(reception, shown, claimed.model_copy(update={"joint": "Z"})) == "impossible"
        assert await refused(reception, shown, GO_ON) == "impossible"
        return await reception.act(shown.token, shown.turn, claimed, {})

    assert sitting(tmp_path, STUDY, first_steps, experiment=short(device=False)).scene.step == 3


@pytest.fixture
def plant(monkeypatch):
    """Breaks at some of all attempts, and cannot be seen where it is dark."""

    class Plant(SymbolicPlant):
        attempts, breaks, dark = 0, (), False

        def observe(self):
            if Plant.dark:
                raise OSError("no light")
            return super().observe()

        def attempt(self, joint):
            Plant.attempts += 1
            if Plant.attempts in Plant.breaks:
                raise OSError("stuck")
            return super().attempt(joint)

    source = catalogue.PlantSource(spec="symbolic", make=lambda box, labels, rng: Plant(box))
    monkeypatch.setattr("lockprobe.plants.catalogue.resolve_plant", lambda spec: source)
    return Plant


def test_a_box_that_breaks_is_no_failure_and_the_next_one_comes(tmp_path, plant):
    plant.breaks = (3,)

    async def breaks(reception, shown):
        player = Player(tmp_path, STUDY, "round-robin")
        shown = await go_on(reception, player, shown, lambda one: one.scene.kind == "over")
        assert (shown.scene.number, shown.scene.solved) == (1, None)
        assert sum(free(reception)) == 7
        return await go_on(reception, player, shown)

    shown = sitting(tmp_path, STUDY, breaks)
    first, second = load(tmp_path)
    assert (first.ending, first.error.boundary, len(first.steps), first.owed_again) == ("error", "plant", 2, True)
    ended = [line.ended for line in diary_of(tmp_path, shown.participant)[1:] if line.ended]
    assert ended == ["error", second.ending]


@pytest.mark.parametrize("when", ["at first", "in the meantime"])
def test_a_box_that_cannot_be_shown_is_passed_over_and_a_page_that_shows_it_has_to_ask_anew(tmp_path, plant, when):
    async def dark(reception, shown):
        if when == "in the meantime":
            shown = await to_first("box", reception, shown)
            for session in reception.sessions:
                await session.let_go()
            plant.dark = True
            assert await refused(reception, shown, an_act(shown.scene)) == "stale"
            shown = await reception.enter(shown.token, {})
        plant.dark = True
        shown = await to_first("over", reception, shown)
        plant.dark = False
        return await to_first("debrief", reception, shown)

    shown = sitting(tmp_path, STUDY, dark)
    assert [trial.ending == "error" for trial in load(tmp_path)] == [True, False]
    lines = diary_of(tmp_path, shown.participant)[1:]
    assert [line.box for line in lines if line.act is None] == [1]
    assert [line.turn for line in lines] == list(range(2, 2 + len(lines)))


async def test_nobody_acts_before_they_agree_and_a_code_that_is_wrong_admits_nobody(tmp_path):
    async with opened(tmp_path, STUDY, short(join_code="open-sesame")) as reception:
        for platform in ({}, {"code": "guessed"}):
            with pytest.raises(ActRefused, match="code in the URL"):
                await reception.enter(None, platform)
        code = {"code": "open-sesame"}
        shown = await reception.enter(None, code)
        assert await refused(reception, shown, GO_ON) == "impossible"
        assert await refused(reception, shown, Agree(agreed=True)) == "incomplete"
        with pytest.raises(ActRefused, match="no token"):
            await reception.act(None, 1, Agree(agreed=True), code)
        await reception.act(shown.token, 1, Agree(agreed=True), code)

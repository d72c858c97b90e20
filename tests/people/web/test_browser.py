"""People at the page: strategies that see what it shows and choose there play as they do without it."""

import asyncio
from dataclasses import dataclass, replace

import pytest
from browser import (
    Tab,
    assert_no_script_ran,
    attend,
    bare,
    browser,
    joined,
    needs_a_browser,
    new_tab,
    plan_of,
    run,
    served,
    trials_of,
    violations,
    without_the_page,
)
from seated import diaries_of, people_study, under

from lockprobe.people.experiment import read_words
from lockprobe.trial.condition import Condition

pytestmark = needs_a_browser

WORDS = read_words("en")
CHECK = {"after": 1, "question": "Choose blue.", "options": ["red", "blue"], "right": "blue"}
ASK = {"name": "how", "question": "How did you go about it?"}
SCRIPT = '<img src=x onerror="window.hurt = 1"><script>window.hurt = 1</script>'


def a_study(**settings):
    return people_study(**{"max_steps": 9, **settings})


def at_the_page(directory, study, does, **experiment):
    """What ``does`` with a tab and the address of the study comes to."""

    async def visit():
        async with browser() as chromium, served(directory, study, **experiment) as url:
            tab = await new_tab(chromium)
            tab.language = experiment.get("language", "en")
            return await does(tab, f"{url}?PROLIFIC_PID=w1")

    return run(visit())


def playing(directory, study, strategy):
    """A person who takes part as a strategy, from one look to another, and knows what was shown between."""
    kept = {"reader": None, "luck": None}

    async def goes_on(tab, look, until=lambda look: False):
        look, kept["reader"], kept["luck"] = await attend(
            tab, look, directory, study, strategy, "w1", until=until, **kept
        )
        return look

    return goes_on


def check_equal(directory, study, strategy, boxes, *, claims=True):
    """Every box is, step by step, what the strategy plays without a page, and every act is there once."""
    trials = trials_of(directory)
    assert len(trials) == boxes
    for number in range(1, boxes + 1):
        plan = plan_of(directory, study, "w1", number)
        mine = trials[plan.key]
        assert mine.agent == f"participant:{joined(directory, 'w1').identity}"
        assert mine.facts["position"] == number
        assert bare(mine, claims=claims) == bare(without_the_page(plan, strategy), claims=claims)
    (diary,) = diaries_of(directory)
    assert [line.turn for line in diary[1:]] == list(range(2, 1 + len(diary)))


def at_step(number, step):
    return lambda look: (look.scene, look.box, look.step[:1]) == ("box", number, (step,))


def test_whatever_happens_to_the_page_no_action_counts_twice(tmp_path):
    study = a_study()
    goes_on = playing(tmp_path, study, "human-inspired")

    async def interrupted(tab, address):
        context, tab.answers = tab.page.context, {"Choose blue.": "blue"}
        look = await goes_on(tab, await tab.open(address), at_step(1, 3))

        await tab.page.reload()  # loaded again
        assert await tab.look() == look
        look = await goes_on(tab, look, at_step(1, 4))

        await tab.page.goto("about:blank")  # away, and back with the button
        await tab.page.go_back()
        assert (await tab.look()).turn == look.turn
        look = await goes_on(tab, look, at_step(1, 5))

        await context.set_offline(True)  # no network at the moment of the act; then there is
        doing = asyncio.create_task(goes_on(tab, look, at_step(1, 6)))
        await tab.page.wait_for_selector("#trouble p")
        assert not doing.done()
        await context.set_offline(False)
        look = await doing

        await context.route("**/api/act", _losing_its_reply, times=1)  # what is done arrives, and its reply does not
        look = await goes_on(tab, look, at_step(1, 7))
        return await goes_on(tab, await _two_tabs(context, tab, look, address, goes_on))

    shown = {"practice": "chain-3", "checks": [CHECK], "questions": [ASK]}
    assert at_the_page(tmp_path, study, interrupted, **shown).scene == "debrief"
    check_equal(tmp_path, study, "human-inspired", 2)
    (diary,) = diaries_of(tmp_path)
    answers = {line.item: line for line in diary[1:] if line.item}
    assert (answers["1"].right, answers["how"].act.answers) == (True, ("words",))
    assert all(0 < line.act.rt < 60_000 for line in diary[1:] if line.scene == "box")


async def _losing_its_reply(route):
    assert (await route.fetch()).status == 200
    await route.abort()


async def _two_tabs(context, tab, look, address, goes_on):
    """The later tab plays; the earlier learns it from what it does, which does not count."""
    other = Tab(await context.new_page())
    assert await other.open(address) == look
    later = await goes_on(other, look, at_step(1, 8))
    await tab.page.locator("[data-claim=moved]").click()
    await tab.page.locator("button[data-joint=A]").click()
    again = await tab.look(after=look.turn)
    assert again == later  # nothing was done
    await other.page.close()
    return again


def test_a_box_in_pictures_is_played_with_the_buttons_beside_them(tmp_path):
    pytest.importorskip("mujoco")
    pictures = {"plant": "fast-twin?width=160&height=120", "modalities": ("rgb",)}
    study = a_study(name="modalities", p=(0.0,), trials=1, max_steps=3, **pictures)

    async def views(tab, address):
        goes_on = playing(tmp_path, study, "random")
        look = await goes_on(tab, await tab.open(address), at_step(1, 2))
        assert await violations(tab.page) == []
        return await goes_on(tab, look)

    assert at_the_page(tmp_path, study, views).scene == "debrief"
    (trial,) = trials_of(tmp_path).values()
    assert (trial.facts["view"], len(trial.picture_names) > 1) == ("pictures", True)
    assert {path.name for path in (tmp_path / "pictures").iterdir()} == trial.picture_names


@dataclass(frozen=True, kw_only=True)
class Shouting:
    """Somebody's own intervention."""

    def brief(self, briefing, past, task, rng):
        return replace(briefing.remarking(SCRIPT), warning=SCRIPT)


@dataclass(frozen=True, kw_only=True)
class Painting:
    """Somebody's own words."""

    after_words = True

    def perceive(self, percept, past, task, rng):
        return replace(percept, text=SCRIPT)


def test_what_somebody_writes_or_a_condition_says_is_text_wherever_it_is_shown(tmp_path):
    acting = Condition(interventions=(Shouting(), Painting()), name="<img src=x>")
    study = replace(under("truth", trials=1), conditions=(acting,))

    async def writes(tab, address):
        goes_on, tab.answers = playing(tmp_path, study, "random"), {ASK["question"]: SCRIPT}
        look = await goes_on(tab, await tab.open(f"{address}&x={SCRIPT}"), at_step(1, 2))
        assert [look.remark, look.warning, look.report] == [SCRIPT] * 3
        assert look.history == [f"{SCRIPT} {SCRIPT}"]
        await goes_on(tab, look)
        await assert_no_script_ran(tab.page)

    at_the_page(tmp_path, study, writes, questions=[ASK])
    assert "<img src=x onerror=" in str(diaries_of(tmp_path))


def test_who_leaves_a_question_out_is_told_and_who_answers_wrong_reads_again(tmp_path):
    first = WORDS.comprehension.questions[0]

    async def answers(tab, address):
        look = await tab.open(address)
        while look.scene != "comprehension":
            look = await tab.go_on(look)
        await tab.press("[data-act=answers]")
        assert await tab.page.locator(".missing").inner_text() == WORDS.page["all_required"]
        tab.answers = {first.question: next(one for one in first.options if one != first.right)}
        look = await tab.go_on(look)
        assert (look.scene, look.heading) == ("page", WORDS.instructions[0].title)
        assert first.question in await tab.page.locator(".notice").inner_text()
        tab.answers = {}
        while look.scene != "box":
            look = await tab.go_on(look)
            assert not await tab.page.locator(".notice").count()

    at_the_page(tmp_path, people_study(), answers, comprehension=True)
    rounds = [one.right for one in diaries_of(tmp_path)[0][1:] if one.scene == "comprehension"]
    assert rounds == [False, True]

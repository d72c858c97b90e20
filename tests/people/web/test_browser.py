"""People at the page in a real browser: what is shown is what was told, whatever happens to it, and for everybody:
small screens, no mouse, screen readers."""

import asyncio
from collections import Counter
from dataclasses import dataclass, replace

import pytest
from browser import ACTS, Tab, at_the_page, needs_a_browser, violations
from painted import painted_twins
from seated import people_study, under

from lockprobe import load
from lockprobe.people.diary import read_diaries
from lockprobe.people.experiment import read_words
from lockprobe.trial.condition import Condition

pytestmark = needs_a_browser

WORDS = read_words("en")
CHECK = {"after": 0, "question": "Choose blue.", "options": ["red", "blue"], "right": "blue"}
HOW = {"name": "how", "question": "How did you go about it?"}
WHICH = {"name": "which", "question": "Which?", "options": ["one", "two"]}
WHOLE = {
    "checks": [CHECK],
    "questions": [HOW, WHICH],
    "completion_url": "https://example.org/done",
    "completion_code": "C0DE",
    "left_code": "GONE",
}
SCRIPT = '<img src=x onerror="window.hurt = 1"><script>window.hurt = 1</script>'


def check_as_shown(directory, tab):
    """Every attempt is written down and on record once, as it was made and as it was shown."""
    (diary,) = read_diaries(directory)
    assert [did.turn for did in diary.lines] == [*range(2, diary.turn)]
    steps = [did for did in diary.lines if did.scene == "box"]
    assert [(did.box, did.step, did.act.joint, did.shown) for did in steps] == tab.done
    assert all(0 < did.act.rt < 60_000 for did in steps)
    trials = {trial.facts["position"]: trial for trial in load(directory)}
    for box, trial in trials.items():
        assert [step.decision.joint for step in trial.steps] == [joint for of, _, joint, _ in tab.done if of == box]
    assert len(trials) == len(load(directory)) == len(diary.joined.slots)


def at_step(step):
    return lambda look: (look.scene, look.box) == ("box", 1) and look.step == step


def test_whatever_happens_to_the_page_no_action_counts_twice(tmp_path):
    async def losing_its_reply(route):
        assert (await route.fetch()).status == 200
        await route.abort()

    async def interrupted(tab, address):
        context, tab.answers = tab.page.context, {"Choose blue.": "blue"}
        look = await tab.play(await tab.open(address), at_step(2))

        await tab.page.reload()  # loaded again
        assert await tab.look() == look
        look = await tab.play(look, at_step(3))

        await tab.page.goto("about:blank")  # away, and back with the button
        await tab.page.go_back()
        assert (await tab.look()).turn == look.turn

        await context.set_offline(True)  # no network at the moment of the act; then there is
        doing = asyncio.create_task(tab.play(look, at_step(4)))
        await tab.page.wait_for_selector("#trouble p")
        assert not doing.done()
        await context.set_offline(False)
        look = await doing

        await context.route("**/api/act", losing_its_reply, times=1)  # what is done arrives, and its reply does not
        look = await tab.play(look, at_step(5))

        other = Tab(await context.new_page())  # the later tab plays; the earlier learns it, and its act does not count
        assert await other.open(address) == look
        later = await other.play(look, at_step(6))
        tab.done += other.done
        await tab.press("[data-claim=moved]")
        await tab.press("button[data-joint=A]")
        again = await tab.look(after=look.turn)
        assert again == later  # nothing was done
        await other.page.close()
        look = await tab.play(again)
        check_as_shown(tmp_path, tab)
        return look

    study = people_study(p=(0.0,), trials=1, max_steps=7)
    assert at_the_page(tmp_path, study, interrupted, checks=[CHECK], questions=[HOW]).scene == "debrief"
    answers = {line.item: line for line in read_diaries(tmp_path)[0].lines if line.item}
    assert (answers["1"].right, answers["how"].act.answers) == (True, ("words",))


def test_a_box_in_pictures_is_played_with_the_buttons_beside_them(tmp_path, monkeypatch):
    painted_twins(monkeypatch)
    pictures = {"plant": "fast-twin?width=160&height=120", "modalities": ("rgb",)}

    async def views(tab, address):
        look = await tab.play(await tab.open(address), at_step(2))
        assert await tab.page.locator("[data-view=pictures] img").count() == 1
        assert await violations(tab.page) == []
        return await tab.play(look)

    assert at_the_page(tmp_path, people_study(p=(0.0,), trials=1, max_steps=3, **pictures), views).scene == "debrief"
    (trial,) = load(tmp_path)
    assert (trial.facts["view"], len(trial.picture_names) > 1) == ("pictures", True)
    assert {path.name for path in (tmp_path / "pictures").iterdir()} == trial.picture_names


@dataclass(frozen=True, kw_only=True)
class Shouting:
    """Somebody's own intervention."""

    def brief(self, briefing, past, task, rng):
        return replace(briefing.remarking(SCRIPT), warning=SCRIPT)


def test_what_somebody_writes_or_a_condition_says_is_text_wherever_it_is_shown(tmp_path):
    acting = Condition(interventions=(Shouting(),), name="<img src=x>")
    study = replace(under("truth", trials=1, max_steps=3), conditions=(acting,))

    async def writes(tab, address):
        tab.answers = {HOW["question"]: SCRIPT}
        look = await tab.play(await tab.open(f"{address}&x={SCRIPT}"), at_step(2))
        assert [look.remark, look.warning] == [SCRIPT] * 2
        assert (await tab.play(look)).scene == "debrief"
        assert await tab.page.evaluate("() => window.hurt") is None
        assert not await tab.page.locator("img[src=x]").count()
        check_as_shown(tmp_path, tab)

    at_the_page(tmp_path, study, writes, questions=[HOW])
    assert "<img src=x onerror=" in str(read_diaries(tmp_path))


def test_who_leaves_a_question_out_is_told_and_who_answers_wrong_reads_again(tmp_path):
    first = WORDS.comprehension.questions[0]

    async def answers(tab, address):
        look = await tab.play(await tab.open(address), lambda look: look.scene == "comprehension")
        await tab.press("[data-act=answers]")
        assert await tab.page.locator(".missing").inner_text() == WORDS.page["all_required"]
        tab.answers = {first.question: next(one for one in first.options if one != first.right)}
        look = await tab.go_on(look)
        assert (look.scene, look.heading) == ("page", WORDS.instructions[0].title)
        assert first.question in await tab.page.locator(".notice").inner_text()

    at_the_page(tmp_path, people_study(), answers)


TARGETS = """() => [...document.querySelectorAll("button, a, summary, [data-option], textarea")]
  .filter((part) => part.checkVisibility() && !part.closest("dialog:not([open])"))
  .map((part) => [part.innerText, part.getBoundingClientRect()])
  .filter(([_, at]) => at.width < 43.9 || at.height < 43.9)
  .map(([text, at]) => `${text}: ${at.width} x ${at.height}`)"""


@pytest.mark.slow
def test_every_scene_on_a_phone_in_german_and_read_aloud(tmp_path):
    async def on_a_phone(tab, address):
        page, told, seen_so_far = tab.page, [], Counter()
        page.on("console", lambda message: told.append(message.text))
        page.on("pageerror", lambda error: told.append(str(error)))
        look, seen = await tab.open(address), []
        while not seen or seen[-1] != "debrief":
            seen.append(look.scene)
            wide = await page.evaluate("() => document.documentElement.scrollWidth")
            assert wide <= 360, f"{look.scene} is {wide} pixels wide"
            assert await page.evaluate(TARGETS) == [], look.scene
            # A box before and after the first report: then it repeats, and so do further boxes.
            kind = (look.scene, look.box > 0 if look.scene == "box" else look.heading)
            seen_so_far[kind] += 1
            if seen_so_far[kind] <= 2:
                assert await violations(page) == [], look.scene
            look = look if look.scene == "debrief" else await tab.go_on(look)
        assert set(seen) == {"consent", "page", "comprehension", "box", "over", "check", "ask", "debrief"}
        assert told == []

    phone = {"viewport": {"width": 360, "height": 740}, "locale": "de-DE"}
    study, shown = people_study(p=(0.4,), trials=2, seed=11, max_steps=4), {"practice": "chain-3", "language": "de"}
    at_the_page(tmp_path, study, on_a_phone, touch=True, context=phone, **shown, **WHOLE)


class Keyboard:
    """Somebody who has no mouse: Tab, Enter, arrows."""

    def __init__(self, page):
        self.page = page
        self.press = page.keyboard.press

    async def tab_to(self, part):
        for _ in range(40):
            if await self.page.evaluate("part => document.activeElement.matches(part)", part):
                outline = await self.page.evaluate("() => getComputedStyle(document.activeElement).outlineStyle")
                assert outline != "none", f"{part} does not show that it has the focus"
                return
            await self.press("Tab")
        raise AssertionError(f"{part} cannot be reached")

    async def enter(self, part, key="Enter"):
        await asyncio.sleep(0.22)  # the same key within 0.2 s is taken for one that bounced
        await self.tab_to(part)
        await self.press(key)

    async def answer(self, look):
        """Do what has to be done in a scene."""
        if look.asks:
            await self.enter("[data-claim=blocked]")
        if look.scene == "comprehension":
            for one in WORDS.comprehension.questions:
                number = await self.page.locator("fieldset", has_text=one.question).get_attribute("data-question")
                await self.enter(f"fieldset[data-question='{number}'] input", "Space")
                for _ in range(one.options.index(one.right)):
                    await self.press("ArrowDown")
        elif look.options:
            await self.tab_to("input")
            await self.press("ArrowDown")
        if look.written:
            await self.tab_to("textarea")
            await self.page.keyboard.type("by trying")
        act = f"[data-act={ACTS.get(look.scene, 'next')}]"
        await self.enter("button[data-joint=B]" if look.scene == "box" else act)


def test_the_keyboard_alone_is_enough(tmp_path):
    async def without_a_mouse(tab, address):
        page, keyboard, bars = tab.page, Keyboard(tab.page), []
        look = await tab.open(address)
        while look.scene != "debrief":
            await keyboard.answer(look)
            look = await tab.look(after=look.turn)
            bars.append(float(await page.locator("progress").get_attribute("value")))
        assert (bars, bars[-1]) == (sorted(bars), 1.0)
        await keyboard.tab_to("[data-act=leave]")
        await keyboard.enter("[data-act=withdraw]")
        await page.wait_for_selector("dialog[open]")
        assert await violations(page) == []
        for _ in range(5):  # the dialog keeps the focus
            await keyboard.press("Tab")
            focus = "document.activeElement"
            assert await page.evaluate(f"() => {focus} === document.body || {focus}.closest('dialog') !== null")
        await keyboard.press("Escape")
        assert not await page.locator("dialog[open]").count()
        assert len(read_diaries(tmp_path)) == 1
        await keyboard.enter("[data-act=withdraw]")
        await keyboard.enter("[data-act=withdraw-yes]")
        await page.wait_for_selector("[data-scene=closed]")
        assert await page.locator("[data-code=GONE]").is_visible()
        assert read_diaries(tmp_path) == []

    study = people_study(p=(0.4,), trials=1, seed=11, max_steps=2)
    at_the_page(tmp_path, study, without_a_mouse, **WHOLE)

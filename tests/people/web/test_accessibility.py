"""The page for everybody: small screens, no mouse, screen readers, slow lines; and what it tells a browser."""

import asyncio
from collections import Counter
from dataclasses import replace

import pytest
from browser import ACTS, browser, needs_a_browser, new_tab, run, served, violations
from seated import diaries_of, people_study

from lockprobe.people.experiment import read_words

pytestmark = needs_a_browser

STUDY = people_study(p=(0.4,), trials=2, seed=11, max_steps=4)
SHORT = replace(STUDY, max_steps=2)
CHECK = {"after": 0, "question": "Choose blue.", "options": ["red", "blue"], "right": "blue"}
ASKED = [{"name": "how", "question": "How?"}, {"name": "which", "question": "Which?", "options": ["one", "two"]}]
WHOLE = {
    "checks": [CHECK],
    "questions": ASKED,
    "completion_url": "https://example.org/done",
    "completion_code": "C0DE",
    "left_code": "GONE",
}

TARGETS = """() => [...document.querySelectorAll("button, a, summary, [data-option], textarea")]
  .filter((part) => part.checkVisibility() && !part.closest("dialog:not([open])"))
  .map((part) => [part.innerText, part.getBoundingClientRect()])
  .filter(([_, at]) => at.width < 43.9 || at.height < 43.9)
  .map(([text, at]) => `${text}: ${at.width} x ${at.height}`)"""


@pytest.mark.slow
def test_every_scene_on_a_phone_in_german_and_read_aloud(tmp_path):
    async def on_a_phone():
        context = {"viewport": {"width": 360, "height": 740}, "locale": "de-DE"}
        shown = {"practice": "chain-3", "language": "de", **WHOLE}
        async with browser() as chromium, served(tmp_path, STUDY, **shown) as url:
            tab = await new_tab(chromium, touch=True, **context)
            tab.language = "de"
            page, told, seen_so_far = tab.page, [], Counter()
            page.on("console", lambda message: told.append(message.text))
            page.on("pageerror", lambda error: told.append(str(error)))

            look, seen = await tab.open(f"{url}?PROLIFIC_PID=w1"), []
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
                if look.scene == "box":
                    await tab.choose("A", "moved" if look.asks else None)
                    look = await tab.look(after=look.turn)
                elif look.scene != "debrief":
                    look = await tab.go_on(look)
            assert set(seen) == {"consent", "page", "comprehension", "box", "over", "check", "ask", "debrief"}
            assert told == []

    run(on_a_phone())


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

    async def enter(self, part):
        await asyncio.sleep(0.22)  # the same key within 0.2 s is taken for one that bounced
        await self.tab_to(part)
        await self.press("Enter")

    async def answer(self, look):
        """Do what has to be done in a scene."""
        if look.asks:
            await self.enter("[data-claim=blocked]")
        if look.scene == "comprehension":
            for one in read_words("en").comprehension.questions:
                field = self.page.locator("fieldset", has_text=one.question)
                if not await field.count():
                    continue
                number = await field.get_attribute("data-question")
                await self.tab_to(f"fieldset[data-question='{number}'] input")
                await asyncio.sleep(0.22)  # the same key within 0.2 s is taken for one that bounced
                await self.press("Space")
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
    async def without_a_mouse():
        async with browser() as chromium, served(tmp_path, SHORT, practice="chain-3", **WHOLE) as url:
            tab = await new_tab(chromium)
            page, keyboard, bars = tab.page, Keyboard(tab.page), []
            look = await tab.open(f"{url}?PROLIFIC_PID=w1")
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
                assert await page.evaluate(
                    "() => document.activeElement === document.body || document.activeElement.closest('dialog') !== null"
                )
            await keyboard.press("Escape")
            assert not await page.locator("dialog[open]").count()
            assert len(diaries_of(tmp_path)) == 1
            await keyboard.enter("[data-act=withdraw]")
            await keyboard.enter("[data-act=withdraw-yes]")
            await page.wait_for_selector("[data-scene=closed]")
            assert await page.locator("[data-code=GONE]").is_visible()
            assert diaries_of(tmp_path) == []

    run(without_a_mouse())

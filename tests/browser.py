"""Real browsers at the participants' page: somebody sees what it shows, and clicks, presses keys or touches."""

import asyncio
import atexit
import re
import shutil
from contextlib import asynccontextmanager
from functools import cache
from types import SimpleNamespace

import pytest
from axe_playwright_python.async_playwright import Axe
from playwright.async_api import async_playwright

from lockprobe.people.experiment import Experiment, read_words
from lockprobe.people.web.address import Address
from lockprobe.people.web.app import opened

BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
"""The first of these that is here is taken. The shell is the same engine without windows, at half the time."""

CHROMIUM = next(filter(None, map(shutil.which, BROWSERS)), None)

needs_a_browser = pytest.mark.skipif(CHROMIUM is None, reason="no chromium: browser tests are skipped")

UNSEEN = (
    # Lists below the address bar are pages as well: hidden, and made anew for every context, which takes a second.
    "WebUIOmniboxPopup", "WebUIOmniboxAimPopup", "WebUIOmniboxFullPopup",
    # Playwright turns these off, and a second list replaces its own.
    "AimEnabled", "AvoidUnnecessaryBeforeUnloadCheckSync", "DestroyProfileOnBrowserClose", "HttpsFirstBalancedModeAutoEnable",
    "HttpsUpgrades", "LensOverlay", "MediaRouter", "NetworkTimeServiceQuerying", "OptimizationHints", "PaintHolding",
    "PreconnectToSearch", "ThirdPartyStoragePartitioning",
)  # fmt: skip
"""Features of Chromium that no test looks at."""

CHEAP = ["--no-sandbox", "--disable-gpu", f"--disable-features={','.join(UNSEEN)}"]
"""What Chromium is started with: most of its time would go into what nobody sees."""

ACTS = {"consent": "agree", "comprehension": "answers", "check": "answers", "ask": "answers"}
"""Scene -> what the button does that answers it, where that is not to go on."""

PATIENCE = 60_000
"""Milliseconds in which the next scene has to come."""

LOOK = """turn => {
  const main = document.getElementById("scene");
  const shown = Number(main?.dataset.turn ?? -1);
  const head = main?.querySelector("h1");
  if (shown <= turn || !head) return null;
  const text = (part) => main.querySelector(part)?.innerText.trim() ?? "";
  const number = (words) => Number(words.match(/\\d+/)?.[0] ?? 0);
  return {
    turn: shown, scene: main.dataset.scene, heading: head.innerText, box: number(head.innerText),
    step: number(text(".where")), report: text(".report"), remark: text(".remark"), warning: text(".warning"),
    joints: [...main.querySelectorAll("button[data-joint]")].map((one) => [one.dataset.joint, one.ariaLabel]),
    history: [...main.querySelectorAll(".history li")].map((line) => line.textContent).reverse(),
    spoken: document.getElementById("spoken").textContent,
    asks: main.querySelector("[data-claim]") !== null,
    written: main.querySelector("textarea") !== null,
    options: [...main.querySelectorAll("[data-option]")].map((option) => option.innerText.trim()),
  };
}"""
"""What the page shows, as soon as that is a later scene: words as they are read, and of joints what is read aloud.

The practice box is 0.
"""


class Tab:
    """One tab, and whoever sits before it, who attempts one joint after the other.

    Attributes:
        page: Playwright's page.
        touch: Whether parts are chosen with a finger.
        words: The texts.
        answers: Question -> what is answered; the first option and ``words`` where there is nothing.
        done: Box, step and joint of each attempt, and what could be read of it afterwards, empty at the end of a box.
    """

    def __init__(self, page, *, touch=False, language="en"):
        self.page, self.touch, self.words = page, touch, read_words(language)
        self.answers, self.done = {}, []

    async def open(self, url):
        """Load the page, and see what it shows first."""
        await self.page.goto(url)
        return await self.look()

    async def look(self, after=-1):
        """The first scene that is shown after a turn."""
        seen = await self.page.wait_for_function(LOOK, arg=after, timeout=PATIENCE, polling=40)
        return SimpleNamespace(**await seen.json_value())

    async def press(self, part):
        """Choose a part of the page, with the mouse or a finger."""
        if self.touch:
            await asyncio.sleep(0.55)  # two taps nearby within half a second are a double tap
            await self.page.locator(part).tap()
        else:
            await self.page.locator(part).click()

    async def go_on(self, look):
        """Do what has to be done in a scene; the next scene."""
        if look.asks:
            await self.press("[data-claim=moved]")
        if look.scene == "comprehension":
            for one in self.words.comprehension.questions:
                question = self.page.locator("fieldset.question", has_text=one.question)
                option = self.answers.get(one.question, one.right)
                await question.locator(f'[data-option="{option}"]').click()
        elif look.options:
            await self.page.locator(f'[data-option="{self.answers.get(look.heading, look.options[0])}"]').click()
        if look.written:
            await self.page.locator("textarea").fill(self.answers.get(look.heading, "words"))
        if look.scene != "box":
            await self.press(f"[data-act={ACTS.get(look.scene, 'next')}]")
            return await self.look(after=look.turn)
        labels = [label for label, said in look.joints if label in said]
        assert len(labels) == len(look.joints)
        joint = sorted(labels)[look.step % len(labels)]
        await self.press(f"button[data-joint={joint}]")
        after = await self.look(after=look.turn)
        read = re.sub(r"\s+", " ", f"{after.report} {after.remark}".strip()) if after.scene == "box" else ""
        assert read in after.spoken  # what is shown is read aloud
        assert not read or after.history == [*look.history, read]  # and stays in view as it was told
        self.done.append((look.box, look.step, joint, read))
        return after

    async def play(self, look, until=lambda look: False):
        """Take part to the end, or until something is shown."""
        while look.scene not in ("debrief", "closed") and not until(look):
            look = await self.go_on(look)
        return look


async def violations(page):
    """What axe finds, in one line each."""
    if not await page.evaluate("'axe' in window"):
        await page.evaluate(Axe().axe_script)  # once per document: half a megabyte of source
    find = "options => axe.run(options).then(found => found.violations)"
    return [
        f"{rule['id']}: {node['html'][:200]} {node.get('failureSummary', '')[:300]}"
        for rule in await page.evaluate(find, {"resultTypes": ["violations"]})
        for node in rule["nodes"]
    ]


@cache
def _runner():
    """The event loop of all browser tests of this process: Playwright and Chromium belong to the loop they start in."""
    return asyncio.Runner()


def run(test):
    """``asyncio.run`` in the loop of the browser."""
    return _runner().run(test)


_started = []
"""Playwright and Chromium once they run: to start them takes seconds."""


@asynccontextmanager
async def browser():
    """A headless Chromium, the same in all tests of this process; what was opened in it is closed at the end."""
    if not _started:
        playwright = await async_playwright().start()
        made = await playwright.chromium.launch(executable_path=CHROMIUM, args=CHEAP)
        _started.extend((playwright, made))
        atexit.register(_end)
    made = _started[1]
    try:
        yield made
    finally:
        for context in made.contexts:
            await context.close()


def _end():
    async def ends():
        playwright, made = _started
        await made.close()
        await playwright.stop()

    with _runner() as runner:
        runner.run(asyncio.wait_for(ends(), 10))


def at_the_page(directory, study, does, *, touch=False, context=None, **settings):
    """What ``does`` with a tab, a browser of its own as far as cookies go, and the address of the study comes to."""
    experiment = Experiment(**{"practice": "", **settings})
    served = opened(directory, study, experiment, read_words(experiment.language), Address(port=0))

    async def visit():
        async with browser() as chromium, served as (where, _):
            made = await chromium.new_context(has_touch=touch, reduced_motion="reduce", **(context or {}))
            made.set_default_timeout(PATIENCE)
            tab = Tab(await made.new_page(), touch=touch, language=experiment.language)
            return await does(tab, f"{where.url}?PROLIFIC_PID=w1")

    return run(visit())

"""Real browsers at the participants' page: a visitor sees what it shows, and clicks, presses keys or touches.

A strategy plays by what the page *shows*: it reads words, names of joints for screen readers, and pictures.
"""

import asyncio
import atexit
import base64
import re
import shutil
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from functools import cache, partial

import pytest
from axe_playwright_python.async_playwright import Axe
from playwright.async_api import async_playwright
from seated import diaries_of

from lockprobe.agents.catalogue import resolve
from lockprobe.people.experiment import Experiment, filled, read_words
from lockprobe.people.web.address import Address
from lockprobe.people.web.app import opened
from lockprobe.studies.records.read_records import load, replaced_records
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.luck import Luck
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import Percept, Situation, Task, Turn

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
  return {
    turn: shown, scene: main.dataset.scene, heading: head.innerText, where: text(".where"), report: text(".report"),
    remark: text(".remark"), warning: text(".warning"),
    view: main.querySelector("[data-view]")?.dataset.view ?? "",
    joints: [...main.querySelectorAll("button[data-joint]")].map((button) => button.getAttribute("aria-label")),
    history: [...main.querySelectorAll(".history li")].map((line) => line.textContent).reverse(),
    pictures: [...main.querySelectorAll("img")].map((image) => image.src),
    spoken: document.getElementById("spoken").textContent,
    asks: main.querySelector("[data-claim]") !== null,
    written: main.querySelector("textarea") !== null,
    options: [...main.querySelectorAll("[data-option]")].map((option) => option.innerText.trim()),
  };
}"""
"""What the page shows, as soon as that is a later scene."""


@dataclass(frozen=True)
class Look:
    """What a page shows: words as they are read, and of joints what is read aloud."""

    turn: int
    scene: str
    heading: str
    where: str
    report: str
    remark: str
    warning: str
    view: str
    joints: list[str]
    history: list[str]
    pictures: list[str]
    spoken: str
    asks: bool
    written: bool
    options: list[str]

    @property
    def box(self):
        """Which box, from 1; 0 is the practice box."""
        return int((re.search(r"\d+", self.heading) or "0")[0])

    @property
    def step(self):
        """Which step, and of how many."""
        return tuple(int(number) for number in re.findall(r"\d+", self.where))


async def new_tab(chromium, *, touch=False, **settings):
    """Somebody new: a browser of their own, as far as cookies go, and one tab in it."""
    context = await chromium.new_context(has_touch=touch, **{"reduced_motion": "reduce", **settings})
    context.set_default_timeout(PATIENCE)
    return Tab(await context.new_page(), touch=touch)


@dataclass
class Tab:
    """One tab, and whoever sits before it.

    Attributes:
        page: Playwright's page.
        touch: Whether parts are chosen with a finger.
        language: Of the texts.
        answers: Question -> what is answered; the first option and ``words`` where there is nothing.
    """

    page: object
    touch: bool = False
    language: str = "en"
    answers: dict = field(default_factory=dict)

    async def open(self, url):
        """Load the page, and see what it shows first."""
        await self.page.goto(url)
        return await self.look()

    async def look(self, after=-1):
        """The first scene that is shown after a turn."""
        seen = await self.page.wait_for_function(LOOK, arg=after, timeout=PATIENCE, polling=40)
        return Look(**await seen.json_value())

    async def press(self, part):
        """Choose a part of the page, with the mouse or a finger."""
        if self.touch:
            await asyncio.sleep(0.55)  # two taps nearby within half a second are a double tap
            await self.page.locator(part).tap()
        else:
            await self.page.locator(part).click()

    async def choose(self, joint, claimed):
        """Say what the last action did, if that is asked, and choose a joint."""
        if claimed is not None:
            await self.press(f"[data-claim={claimed}]")
        await self.press(f"button[data-joint={joint}]")

    async def go_on(self, look):
        """Do what has to be done in a scene that is no box; the next scene."""
        if look.scene == "comprehension":
            for one in read_words(self.language).comprehension.questions:
                question = self.page.locator("fieldset.question", has_text=one.question)
                if await question.count():
                    option = self.answers.get(one.question, one.right)
                    await question.locator(f'[data-option="{option}"]').click()
        elif look.options:
            option = self.answers.get(look.heading, look.options[0])
            await self.page.locator(f'[data-option="{option}"]').click()
        if look.written:
            await self.page.locator("textarea").fill(self.answers.get(look.heading, "words"))
        await self.press(f"[data-act={ACTS.get(look.scene, 'next')}]")
        return await self.look(after=look.turn)


async def assert_no_script_ran(page):
    """No script came to life in it, of those that set ``window.hurt``, and no picture of theirs."""
    assert await page.evaluate("() => window.hurt") is None
    assert not await page.locator("img[src=x]").count()


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


class Reader:
    """What a page has shown of one box so far, as the situation of an agent."""

    def __init__(self, words):
        self._words = words.page
        self._past = ()
        self._before = None
        self._reports = []
        self.decision = None

    def situation(self, look):
        """The situation in which the page asks for a joint."""
        named = [self._named(joint) for joint in look.joints]
        labels = tuple(label for label, _, _ in named)
        (target,) = [label for label, is_target, _ in named if is_target]
        task = Task(joints=labels, target=target, budget=look.step[1], assessment=look.asks)
        percept = self._percept(look, labels, [position for _, _, position in named])
        if self.decision is not None:
            self._past = (*self._past, Turn(percept=self._before, decision=self.decision))
        self._before = percept
        assert len(self._past) == look.step[0] - 1
        assert re.sub(r"\s+", " ", look.report) in look.spoken  # what is shown is read aloud
        self._check_history(look)
        return Situation(task=task, past=self._past, percept=percept)

    def _check_history(self, look):
        """What was told before stays in view as it was told."""
        self._reports += [look.report] if look.step[0] > 1 else []
        assert len(look.history) == len(self._reports)
        shown = [re.sub(r"\s+", " ", report) for report in self._reports]
        assert all(line.startswith(report) for line, report in zip(look.history, shown, strict=True)), shown

    def _named(self, name):
        """Label, whether it is the target, and position of a joint, by what is read aloud of it."""
        said = name.split(", ")
        label = re.fullmatch(filled(self._words["joint"], label=r"(\w)"), said[0])[1]
        told = [at for at in (0, 1) if filled(self._words["position"], position=at) in said]
        return label, self._words["target"] in said, told[0] if told else None

    def _percept(self, look, labels, positions):
        if look.view == "pictures":
            kinds = ("rgb", "depth")
            shown = [base64.b64decode(url.partition(",")[2]) for url in look.pictures]
            pictures = tuple(Picture(kind=kind, png=png) for kind, png in zip(kinds, shown, strict=False))
            joint = None if self.decision is None else self.decision.joint
            return Percept(joint=joint, pictures=pictures)
        outcomes = {"moved": self._found("moved", look.report), "blocked": self._found("blocked", look.report)}
        outcome, joint = next(((said, label) for said, label in outcomes.items() if label), (None, None))
        joint = joint or self._found("attempted", look.report)
        known = None if None in positions else tuple(map(bool, positions))
        return Percept(joint=joint, outcome=outcome, positions=known)

    def _found(self, name, text):
        """What stands in the gap of one of the page's sentences, if it is there."""
        gap = "(.+?)" if name == "positions" else r"(\w)"
        sentence = re.sub(r"\\{\w+\\}", lambda found: gap, re.escape(self._words[name]))
        found = re.search(f"(?m)^{sentence}$", text)
        return found and found[1]


async def attend(tab, look, directory, study, strategy, who, *, until=lambda look: False, reader=None, luck=None):
    """Take part to the end, or until the page shows something; the strategy chooses by what is shown.

    Args:
        tab: The tab.
        look: What it shows.
        directory: Of the study; where it is looked up which trial is played, and nothing else.
        study: What is played.
        strategy: Spec of who decides.
        who: First parameter of the URL.
        until: Where to stop.
        reader: What was shown of the box before, where one begins in the middle.
        luck: The luck of the strategy, in the same case.

    Returns:
        What is shown at the end, and reader and luck with which to go on.
    """
    agent, words = resolve(strategy).make(), read_words(tab.language)
    while look.scene not in ("debrief", "closed") and not until(look):
        if look.scene != "box":
            look = await tab.go_on(look)
            continue
        if look.step[0] == 1:
            reader, luck = Reader(words), luck_of(directory, study, who, look.box)
        decision = await agent.decide(reader.situation(look), luck(look.step[0]))
        claimed = (decision.claimed or "blocked") if look.asks else None
        reader.decision = replace(decision, claimed=claimed)
        await tab.choose(decision.joint, claimed)
        look = await tab.look(after=look.turn)
    return look, reader, luck


def joined(directory, who):
    """The first line of the diary of somebody who came with a parameter."""
    return next(lines[0] for lines in diaries_of(directory) if who in lines[0].platform.values())


def plan_of(directory, study, who, number):
    """What somebody plays as a box, from 1."""
    slot = joined(directory, who).slots[number - 1]
    return study.plan("participant", study.labelled(slot.condition), slot.repetition, slot.trial)


def luck_of(directory, study, who, number):
    """The agent's stream of the trial that somebody plays as a box; any stream for the practice."""
    luck = plan_of(directory, study, who, number).luck if number else Luck(seed=1, box="", repetition=1, trial=1)
    return partial(luck.at, "agent")


def trials_of(directory):
    """All finished trials, by their keys; each is there once."""
    assert not replaced_records(directory)
    return {trial.key: trial for trial in load(directory)}


def without_the_page(plan, strategy):
    """The same trial of the same strategy, played here."""
    return run_trial(
        agent=strategy, box=plan.box, condition=plan.condition, seed=plan.seed, repetition=plan.repetition,
        trial=plan.trial, max_steps=plan.budget, shuffle=plan.shuffle, plant=plan.plant, assessment=plan.assessment,
    )  # fmt: skip


def bare(trial, *, claims=True):
    """A trial without what only its agent is, and without the name of its study."""
    steps = tuple(
        replace(
            step, decision=replace(step.decision, probabilities=None, claimed=step.decision.claimed if claims else None)
        )
        for step in trial.steps
    )
    return replace(trial, key="", study="", agent="", facts={}, steps=steps)


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
    assert asyncio.get_running_loop() is _runner().get_loop(), "a browser test runs in browser.run"
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


@asynccontextmanager
async def served(directory, study, **settings):
    """The server in this process; its address."""
    experiment = Experiment(**{"practice": "", **settings})
    door = Address(port=0)
    async with opened(directory, study, experiment, read_words(experiment.language), door) as (where, _):
        yield where.url

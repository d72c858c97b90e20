"""People at the page: strategies that see what it shows and choose there play as they do without it."""

import asyncio
import os
import time

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
    serving,
    trials_of,
    without_the_page,
)
from seated import diaries_of, people_study

from lockprobe.boxes.families import box

pytestmark = needs_a_browser

AT_ONCE = int(os.environ.get("LOCKPROBE_BROWSERS", "6"))
"""Browsers at once: each way to choose with each strategy."""

CHECK = {"after": 1, "question": "Choose blue.", "options": ["red", "blue"], "right": "blue"}
ASK = {"name": "how", "question": "How did you go about it?"}


ARGUMENTS = (
    "flips",
    "--box",
    "chain-4",
    "--layout",
    "fixed",
    "--p",
    "0,0.4",
    "--repetitions",
    1,
    "--seed",
    7,
    "--max-steps",
    9,
)
"""The same study for ``lockprobe serve``, but for its trials."""


def a_study(**settings):
    return people_study(**{"max_steps": 9, **settings})


def check_equal(directory, study, strategy, who, boxes, *, claims=True):
    """Every box of somebody is, step by step, what the strategy plays without a page."""
    trials = trials_of(directory)
    for number in range(1, boxes + 1):
        plan = plan_of(directory, study, who, number)
        mine = trials[plan.key]
        assert mine.agent == f"participant:{joined(directory, who).identity}"
        assert mine.facts["position"] == number
        assert bare(mine, claims=claims) == bare(without_the_page(plan, strategy), claims=claims)
    return trials


@pytest.mark.parametrize(
    "case",
    [
        ("key", "ideal-observer", {"flip": "integrated"}),
        ("click", "ideal-observer", {"layout": "shuffled"}),
        *(
            pytest.param(case, marks=pytest.mark.slow)
            for case in [
                ("click", "human-inspired", {}),
                ("touch", "human-inspired", {"flip": "outcome-only", "assessment": False}),
                ("touch", "random", {"box": box("random-6-4")}),
            ]
        ),
    ],
    ids=lambda case: " ".join([case[0], *map(str, case[2])]),
)
def test_a_strategy_at_the_page_plays_as_without_it(case, tmp_path):
    how, strategy, settings = case
    study = a_study(**{"max_steps": 6, **settings})
    language = "de" if how == "touch" else "en"
    shown = {"language": language, "practice": "chain-3", "checks": [CHECK], "questions": [ASK]}
    run(_takes_part(tmp_path, study, strategy, how, **shown))
    trials = check_equal(tmp_path, study, strategy, "w1", 2, claims=strategy != "random")
    assert len(trials) == 2
    (diary,) = diaries_of(tmp_path)
    answers = {line.item: line for line in diary[1:] if line.item}
    assert answers["1"].right is True
    assert answers["how"].act.answer == "words"
    times = [line.act.rt for line in diary[1:] if line.scene == "box"]
    assert all(0 < rt < 60_000 for rt in times)


async def _takes_part(directory, study, strategy, how, **experiment):
    async with browser() as chromium, served(directory, study, **experiment) as url:
        tab = await new_tab(chromium, how)
        tab.language, tab.answers = experiment["language"], {"Choose blue.": "blue"}
        look = await tab.open(f"{url}?PROLIFIC_PID=w1")
        assert look.scene == "consent"
        look, _, _ = await attend(tab, look, directory, study, strategy, "w1")
        assert look.scene == "debrief"


@pytest.mark.slow
def test_many_browsers_at_once_and_the_server_is_killed_meanwhile(tmp_path):
    study = a_study(trials=AT_ONCE)
    names = [f"w{i}" for i in range(AT_ONCE)]
    began = time.monotonic()
    run(_crowd(tmp_path, study, names))
    print(f"{AT_ONCE} browsers: {time.monotonic() - began:.0f} s")
    for i, who in enumerate(names):
        trials = check_equal(tmp_path, study, _played_by(i), who, 2)
    assert len(trials) == 2 * AT_ONCE
    steps = sum(len(trial.steps) for trial in trials.values())
    assert sum(line.scene == "box" and line.box > 0 for diary in diaries_of(tmp_path) for line in diary[1:]) == steps


def _played_by(i):
    return ("human-inspired", "ideal-observer")[i % 2]


async def _crowd(directory, study, names):
    with serving(directory, *ARGUMENTS, "--trials", study.trials) as server:
        async with browser() as chromium:

            async def takes_part(i, who):
                tab = await new_tab(chromium, ("click", "key", "touch")[i % 3], viewport={"width": 400, "height": 740})
                look = await tab.open(f"{server.url}?PROLIFIC_PID={who}")
                look, _, _ = await attend(tab, look, directory, study, _played_by(i), who)
                assert look.scene == "debrief"
                await tab.page.context.close()

            async def power_cuts():
                for acts in (8 * len(names), 16 * len(names)):
                    while sum(map(len, diaries_of(directory))) < acts:  # noqa: ASYNC110 - of another process
                        await asyncio.sleep(0.05)
                    await asyncio.to_thread(server.kill)
                    await asyncio.to_thread(server.start)

            await asyncio.gather(power_cuts(), *(takes_part(i, who) for i, who in enumerate(names)))


def at_step(number, step):
    return lambda look: (look.scene, look.box, look.step[:1]) == ("box", number, (step,))


def test_whatever_happens_to_the_page_no_action_counts_twice(tmp_path):
    study = a_study()
    run(_interrupted(tmp_path, study))
    check_equal(tmp_path, study, "human-inspired", "w1", 2)
    acts = [line.turn for line in diaries_of(tmp_path)[0][1:]]
    assert acts == list(range(2, 2 + len(acts)))


async def _interrupted(directory, study):
    async with browser() as chromium, served(directory, study) as url:
        tab = await new_tab(chromium)
        context = tab.page.context
        address = f"{url}?PROLIFIC_PID=w1"
        part = (directory, study, "human-inspired", "w1")
        look, *kept = await attend(tab, await tab.open(address), *part, until=at_step(1, 3))

        await tab.page.reload()  # loaded again
        assert await tab.look() == look
        look, *kept = await attend(tab, look, *part, until=at_step(1, 4), reader=kept[0], luck=kept[1])

        await tab.page.goto("about:blank")  # away, and back with the button
        await tab.page.go_back()
        assert (await tab.look()).turn == look.turn
        look, *kept = await attend(tab, look, *part, until=at_step(1, 5), reader=kept[0], luck=kept[1])

        await context.set_offline(True)  # no network at the moment of the act; then there is
        doing = asyncio.create_task(attend(tab, look, *part, until=at_step(1, 6), reader=kept[0], luck=kept[1]))
        await tab.page.wait_for_selector("#trouble p")
        assert not doing.done()
        await context.set_offline(False)
        look, *kept = await doing

        await context.route("**/api/act", _losing_its_reply, times=1)  # what is done arrives, and its reply does not
        look, *kept = await attend(tab, look, *part, until=at_step(1, 7), reader=kept[0], luck=kept[1])

        look = await _two_tabs(context, tab, look, address)
        look, _, _ = await attend(tab, look, *part, reader=kept[0], luck=kept[1])
        assert look.scene == "debrief"


async def _losing_its_reply(route):
    assert (await route.fetch()).status == 200
    await route.abort()


async def _two_tabs(context, tab, look, address):
    """The later tab plays; the earlier cannot, until it is told to go on there."""
    other = Tab(await context.new_page())
    assert await other.open(address) == look
    await tab.page.locator("[data-claim=moved]").click()
    await tab.page.locator("button[data-joint=A]").click()
    await tab.page.locator("dialog [data-act=here]").click()
    await tab.page.wait_for_selector("dialog:has([data-act=here])", state="detached")
    again = await tab.look()
    assert again.turn == look.turn  # nothing was done
    await other.page.close()
    return again


class Restless(Tab):
    """Somebody who loads the page again after everything that happens."""

    async def look(self, after=-1):
        first = await super().look(after)
        await self.page.reload()
        assert await super().look() == first
        return first


def test_a_page_that_is_loaded_again_shows_the_same_in_every_scene(tmp_path):
    study = a_study(box=box("chain-3"), p=(0.4,), max_steps=6)
    run(_restless(tmp_path, study))
    check_equal(tmp_path, study, "human-inspired", "w1", 1)


async def _restless(directory, study):
    shown = {"practice": "chain-3", "checks": [CHECK], "questions": [ASK]}
    async with browser() as chromium, served(directory, study, **shown) as url:
        tab = Restless((await new_tab(chromium)).page)
        look = await tab.open(f"{url}?PROLIFIC_PID=w1")
        look, _, _ = await attend(tab, look, directory, study, "human-inspired", "w1")
        assert look.scene == "debrief"


def test_a_server_that_is_killed_and_started_again_loses_nothing(tmp_path):
    study = a_study()
    run(_killed(tmp_path, study))
    check_equal(tmp_path, study, "human-inspired", "w1", 2)


async def _killed(directory, study):
    with serving(directory, *ARGUMENTS, "--trials", 4) as server:
        async with browser() as chromium:
            tab = await new_tab(chromium)
            part, kept = (directory, study, "human-inspired", "w1"), (None, None)
            look = await tab.open(f"{server.url}?PROLIFIC_PID=w1")
            for step in (1, 4):
                look, *kept = await attend(tab, look, *part, until=at_step(1, step), reader=kept[0], luck=kept[1])
                await asyncio.to_thread(server.kill)
                doing = asyncio.create_task(
                    attend(tab, look, *part, until=at_step(1, step + 1), reader=kept[0], luck=kept[1])
                )
                await tab.page.wait_for_selector("#trouble p")
                await asyncio.to_thread(server.start)
                look, *kept = await doing
            look, _, _ = await attend(tab, look, *part, reader=kept[0], luck=kept[1])
            assert look.scene == "debrief"


def test_pictures_are_read_off_the_page(tmp_path):
    pytest.importorskip("mujoco")
    study = a_study(
        name="modalities", p=(0.0,), plant="fast-twin?width=160&height=120", modalities=("rgb",), trials=1, max_steps=8
    )
    run(_viewing(tmp_path, study))
    trials = check_equal(tmp_path, study, "viewer", "w1", 1)
    assert len(trials) == 1


async def _viewing(directory, study):
    async with browser() as chromium, served(directory, study) as url:
        tab = await new_tab(chromium)

        async def note(response):
            if "/api/" in response.url:
                scene = (await response.json())["scene"]
                if scene["kind"] == "box":
                    joints = scene["panel"]["joints"]
                    tab.handles = tuple(
                        tuple((x * 160 - 0.5, y * 120 - 0.5) for x, y in joint["handle"]) for joint in joints
                    )

        tab.page.on("response", note)
        look = await tab.open(f"{url}?PROLIFIC_PID=w1")
        look, _, _ = await attend(tab, look, directory, study, "viewer", "w1")
        assert look.scene == "debrief"


def test_withdrawing_deletes_and_says_so(tmp_path):
    study = a_study()
    run(_withdraws(tmp_path, study))
    assert diaries_of(tmp_path) == []


async def _withdraws(directory, study):
    async with browser() as chromium, served(directory, study, left_code="GONE") as url:
        tab = await new_tab(chromium)
        look = await tab.open(f"{url}?PROLIFIC_PID=visitor-7")
        assert not await tab.page.locator("[data-act=withdraw]").count()  # nothing is kept before the consent
        look, *_ = await attend(tab, look, directory, study, "random", "visitor-7", until=at_step(2, 2))
        assert trials_of(directory)
        identity = joined(directory, "visitor-7").identity
        await tab.press("[data-act=withdraw]")
        await tab.press("[data-act=withdraw-no]")
        assert (await tab.look()).turn == look.turn
        await tab.press("[data-act=withdraw]")
        await tab.press("[data-act=withdraw-yes]")
        await tab.page.wait_for_selector("[data-scene=closed]")
        assert await tab.page.locator("[data-code=GONE]").is_visible()
        assert trials_of(directory) == {}
        kept = b"".join(path.read_bytes() for path in directory.rglob("*") if path.is_file())
        assert (identity.encode() in kept, b"visitor-7" in kept) == (False, False)


def test_what_somebody_writes_is_text_wherever_it_is_shown(tmp_path):
    study = a_study(p=(0.0,), trials=1)
    run(_writes(tmp_path, study))
    assert "<img src=x onerror=" in str(diaries_of(tmp_path))


async def _writes(directory, study):
    script = '<img src=x onerror="window.hurt = 1"><script>window.hurt = 1</script>'
    async with browser() as chromium, served(directory, study, questions=[ASK]) as url:
        tab = await new_tab(chromium)
        tab.answers = {ASK["question"]: script}
        look = await tab.open(f"{url}?PROLIFIC_PID=w1&x={script}")
        await attend(tab, look, directory, study, "random", "w1")
        await assert_no_script_ran(tab.page)


def test_whoever_took_part_in_another_study_under_this_name_begins_without_trouble(tmp_path):
    async def visit():
        async with (
            browser() as chromium,
            served(tmp_path / "a", a_study()) as one,
            served(tmp_path / "b", a_study()) as b,
        ):
            tab = await new_tab(chromium)
            assert (await tab.open(one)).scene == "consent"
            assert (await tab.open(b)).scene == "consent"  # cookies know no ports
            assert await tab.page.locator("dialog[open]").count() == 0

    run(visit())

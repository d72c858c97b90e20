"""Before the first box: the questions on the instructions, how far one is, and where the joint is said to be."""

import re

import pytest
from browser import browser, needs_a_browser, new_tab, run, served
from seated import diaries_of, people_study

from lockprobe.people.diary import Did
from lockprobe.people.texts import filled, read_words

pytestmark = needs_a_browser

WORDS = read_words("en")
FIRST = WORDS.comprehension.questions[0]


def test_who_answers_wrong_reads_again_and_then_plays(tmp_path):
    async def answers():
        async with browser() as chromium, served(tmp_path, people_study(), comprehension={"ask": True}) as url:
            tab = await new_tab(chromium)
            look = await tab.open(url)
            while look.scene != "comprehension":
                look = await tab.go_on(look)
            await tab.press("[data-act=answers]")
            assert await tab.page.locator(".missing").inner_text() == WORDS.page["all_required"]
            tab.answers = {FIRST.question: next(one for one in FIRST.options if one != FIRST.right)}
            look = await tab.go_on(look)
            assert (look.scene, look.heading) == ("page", WORDS.instructions[0].title)
            assert FIRST.question in await tab.page.locator(".notice").inner_text()
            tab.answers = {}
            while look.scene != "box":
                look = await tab.go_on(look)
                assert not await tab.page.locator(".notice").count()

    run(answers())
    rounds = [one.right for one in diaries_of(tmp_path)[0] if isinstance(one, Did) and one.scene == "comprehension"]
    assert rounds == [False, True]


def test_the_bar_grows_to_the_end_and_says_how_many_boxes_are_done(tmp_path):
    async def plays():
        bars = []
        async with browser() as chromium, served(tmp_path, people_study(max_steps=2)) as url:
            tab = await new_tab(chromium)
            look = await tab.open(url)
            assert not await tab.page.locator("[role=progressbar]").count()
            while look.scene != "debrief":
                if look.scene == "box":
                    await tab.choose("A", "moved" if look.asks else None)
                    look = await tab.look(after=look.turn)
                else:
                    look = await tab.go_on(look)
                bar = tab.page.locator("[role=progressbar]")
                bars.append((int(await bar.get_attribute("aria-valuenow")), await bar.get_attribute("aria-label")))
        return bars

    bars = run(plays())
    shares = [share for share, _ in bars]
    assert (shares[0], shares[-1], shares) == (0, 100, sorted(shares))
    said = dict.fromkeys(text for _, text in bars)
    assert list(said) == [filled(WORDS.page["progress"], done=done, of=2) for done in (0, 1, 2)]


@pytest.mark.parametrize("tell", ["state", "both", "outcome"])
def test_beside_the_picture_it_is_said_where_the_joint_is_now(tmp_path, tell):
    study = people_study(p=(0.0,), max_steps=4, modalities=(f"symbolic?tell={tell}",))

    async def plays():
        seen = []
        async with browser() as chromium, served(tmp_path, study) as url:
            tab = await new_tab(chromium)
            look = await tab.open(url)
            while look.scene != "box":
                look = await tab.go_on(look)
            while look.scene == "box":
                seen.append(look)
                await tab.choose("ABCD"[look.step[0] % 4], "moved" if look.asks else None)
                look = await tab.look(after=look.turn)
        return seen

    seen = run(plays())
    assert len(seen) > 2
    for look in seen[1:]:
        label = re.search(r"\b([A-D])\b", look.report)[1]
        drawn = next(name for name in look.joints if f"Joint {label}" in name)
        said = [at for at in (0, 1) if filled(WORDS.page["now"], label=label, position=at) in look.report]
        shown = [at for at in (0, 1) if filled(WORDS.page["position"], position=at) in drawn]
        assert said == shown
        assert len(said) == (tell != "outcome")

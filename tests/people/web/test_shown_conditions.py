"""What is done to people under any condition is on their page, and what others wrote is text there."""

from collections import defaultdict
from dataclasses import dataclass, replace

import pytest
from browser import (
    assert_no_script_ran,
    attend,
    bare,
    browser,
    needs_a_browser,
    new_tab,
    run,
    served,
    trials_of,
    violations,
    without_the_page,
)
from seated import under

from lockprobe.boxes.families import box
from lockprobe.trial.condition import Condition

pytestmark = needs_a_browser


@pytest.mark.slow
def test_every_condition_is_shown_as_it_acts(tmp_path):
    """What agents read beside a report stands on the page; who plays at random plays as without it."""
    specs = ("flip?p=0.4 + nudge", "correction?p=1", "drop?p=1", "distract?p=0.5 + warn?rate=0.4")
    study = under(*specs, box=box("random-6-4"), max_steps=20, trials=5, seed=9)
    looks = run(_sees(tmp_path, study, "random"))
    by = {trial.condition: trial for trial in trials_of(tmp_path).values()}
    assert len(by) == len(specs)
    for trial in by.values():
        plan = study.plan("participant", study.labelled(trial.condition), trial.repetition, trial.trial)
        assert bare(trial, claims=False) == bare(without_the_page(plan, "random"), claims=False)
        seen = looks[trial.facts["position"]]
        assert [look.remark for look in seen] == [step.remark for step in trial.steps]
        assert all(look.remark in look.spoken for look in seen)
        assert [bool(look.warning) for look in seen] == ["warn" in trial.condition] * len(seen)
        told = [step.told for step in trial.steps[:-1]]
        shown = [look.report for look in seen[1:]]
        if trial.condition == "correction?p=1":
            assert shown == told
            assert [line[: len(text)] for line, text in zip(seen[-1].history, told, strict=True)] == told
        if trial.condition == "drop?p=1":
            assert set(shown) == {"Nothing was reported."}
    assert by["flip?p=0.4 + nudge"].changed["nudge"] == 1
    assert any(
        "Note: you are repeating" in line for line in looks[by["flip?p=0.4 + nudge"].facts["position"]][-1].history
    )


async def _sees(directory, study, strategy, **experiment):
    """What the page shows at every step, by box."""
    looks = defaultdict(list)

    def note(look):
        if look.scene == "box":
            looks[look.box].append(look)
        return False

    async with browser() as chromium, served(directory, study, **experiment) as url:
        tab = await new_tab(chromium)
        look, _, _ = await attend(
            tab, await tab.open(f"{url}?PROLIFIC_PID=w1"), directory, study, strategy, "w1", until=note
        )
        assert look.scene == "debrief"
        assert await tab.page.get_by_text("something was changed on purpose").count() == 1
        assert await violations(tab.page) == []
    return looks


SCRIPT = '<img src=x onerror="window.hurt = 1"><script>window.hurt = 1</script>'


@dataclass(frozen=True, kw_only=True)
class Shouting:
    """Somebody's own intervention."""

    def brief(self, briefing, past, task, rng):
        return briefing.remarking(SCRIPT).warning_of(SCRIPT)


@dataclass(frozen=True, kw_only=True)
class Painting:
    """Somebody's own words."""

    after_words = True

    def perceive(self, percept, past, task, rng):
        return replace(percept, text=SCRIPT)


def test_what_a_condition_says_is_text_wherever_it_is_shown(tmp_path):
    acting = Condition(interventions=(Shouting(), Painting()), name="<img src=x>")
    study = replace(under("truth", trials=1), conditions=(acting,))
    run(_writes(tmp_path, study))


async def _writes(directory, study):
    async with browser() as chromium, served(directory, study) as url:
        tab = await new_tab(chromium)
        look = await tab.open(f"{url}?PROLIFIC_PID=w1")
        look, *kept = await attend(tab, look, directory, study, "random", "w1", until=_second_step)
        assert [look.remark, look.warning, look.report] == [SCRIPT] * 3
        assert look.history == [f"{SCRIPT} {SCRIPT}"]
        await attend(tab, look, directory, study, "random", "w1", reader=kept[0], luck=kept[1])
        await assert_no_script_ran(tab.page)


def _second_step(look):
    return (look.scene, look.step[:1]) == ("box", (2,))

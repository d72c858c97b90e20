"""The trial explorer: its data say what the records say, and in a browser it steps through them."""

import json
import re

import pytest
from browser import CHEAP, CHROMIUM, needs_a_browser
from builders import SOLUTION, make_trial, play_study, small_study, write_study

from lockprobe import run_trial
from lockprobe.boxes import box as boxes
from lockprobe.boxes.families import box
from lockprobe.report.page import write_report
from lockprobe.report.questions.trials import explorer_data
from lockprobe.report.rows import Design, Results

ATTACK = "</script><script>document.title='owned'</script><img src=x onerror=\"document.title='owned'\">\u202e<!--"


def explored(*trials):
    """What the page holds of trials on a box."""
    of = {"study": {"boxes": [boxes.data_of(box("chain-4"))]}, "design": Design(conditions=(), players=())}
    return explorer_data(trials, Results.model_construct(**of))


def data_of(*trials):
    return json.loads(explored(*trials))


@pytest.mark.parametrize("condition", ["flip?p=0.4", "flip?p=0.5&others=kept", "tremble?p=0.5", "drop?p=0.5"])
def test_the_data_hold_every_step_of_the_record(condition):
    trial = run_trial(agent="human-inspired", condition=condition, trial=3)
    data = data_of(trial)
    (one,) = data["trials"]
    letters = dict(zip("ABCD", data["boxes"][0]["joints"], strict=True))
    assert data["boxes"][0]["joints"] == [joint.name for joint in box("chain-4").joints]
    assert [letters[joint] for joint in one["did"]] == list(trial.actions)
    told = one.get("told", one["moved"])  # true reports are left out, and claims that repeat the report
    claimed = one.get("said", f"-{told}")
    for i, step in enumerate(trial.steps):
        assert one["moved"][i] == str(int(step.moved))
        assert told[i] == ("-" if step.told_moved is None else str(int(step.told_moved)))
        assert not i or claimed[i] == {"moved": "1", "blocked": "0"}.get(step.decision.claimed, "-")
        assert letters.get(one.get("chosen", "-" * 20)[i]) == step.chosen
    assert one["solved"] == trial.solved


@pytest.mark.parametrize(("first", "said"), [("lie", True), ("truth", False)])
def test_a_report_that_takes_back_the_first_is_marked_and_a_repeated_one_is_not(first, said):
    trial = run_trial(agent="random", condition=f"correction?p=0.5&first={first}", trial=1)
    back = data_of(trial)["trials"][0].get("back", "0" * len(trial.steps))
    assert [one == "1" for one in back] == [said and "Correction" in step.told for step in trial.steps]
    assert ("1" in back) == said


def test_broken_trials_are_left_out_people_are_numbered_and_no_text_of_an_agent_ends_the_script():
    person = {"agent": "participant:abc", "facts": {"position": 1}}
    evil = make_trial(SOLUTION, trial=2, hypothesis=ATTACK, agent="llm:evil/<b>")
    said = explored(make_trial([0], broken="model"), make_trial(SOLUTION, **person), evil)
    data = json.loads(said)["trials"]
    assert [one.get("person") for one in data] == [1, None]
    assert "abc" not in said
    assert "<" not in said
    assert data[1]["words"][0].startswith("</script>")
    assert "\u202e" not in data[1]["words"][0]


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The report of a study in a browser, on a phone; while it is open nothing else can be played."""
    from playwright.sync_api import sync_playwright

    trials = play_study(small_study(["human-inspired"], (0.0, 0.4), 1, 6))
    evil = [make_trial(([0, 1, 2] * 7)[:20], p=p, hypothesis=ATTACK, agent="llm:evil/<b>x</b>") for p in (0.0, 0.4)]
    planned = small_study(["human-inspired", evil[0].agent], (0.0, 0.4), 1, 6)
    directory = write_study(tmp_path_factory.mktemp("study") / "out", planned, [*trials, *evil])
    write_report(directory)
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=CHROMIUM, args=CHEAP)
        tab = chromium.new_page(viewport={"width": 390, "height": 844})
        tab.said = []
        tab.on("console", lambda message: tab.said.append(message.text))
        tab.on("pageerror", lambda error: tab.said.append(str(error)))
        tab.goto(f"file://{directory}/report.html")
        yield tab
        chromium.close()


WORDS = """(() => {
  const words = (one) => (one.innerText ?? one.textContent).split(/\\s+/).length;
  return [...document.querySelectorAll("select, .strip, .num, svg")].reduce((left, one) => left - words(one), words(document.body));
})()"""
"""Words that are read: not the choices that open, nor what stands in pictures and on buttons."""


@needs_a_browser
def test_the_explorer_opens_steps_and_compares(page):
    assert page.evaluate(WORDS) <= 600
    page.evaluate("location.hash = 'limits'")  # a link to a section opens it
    page.wait_for_function("document.getElementById('limits').open")
    page.select_option("#agent", label="human-inspired")
    steps = page.locator("#explorer input[type=range]")
    first, second = (strip.locator("button").all_inner_texts() for strip in page.locator(".strip").all())
    parted = next(i for i, pair in enumerate(zip(first, second, strict=False)) if len({*pair}) > 1)
    assert steps.input_value() == str(parted)  # the last step that they share: never one before any report
    assert f"Both play alike up to step {parted}; there one is told that" in page.inner_text("#say")
    assert re.search(
        r"In \d of 6 pairs of trials with the same random numbers the box was opened only with flip rate 0.4, in \d only "
        "when told the truth",
        page.inner_text("#pairs"),
    )
    page.focus(".strip button")
    page.keyboard.press("ArrowRight")
    assert steps.input_value() == str(parted + 1)
    page.click(".strip button:nth-child(2)")
    assert steps.input_value() == "2"
    assert page.locator("#explorer [aria-current=true]").count() == 2
    page.select_option("#right", label="told the truth")  # one condition: each trial alone
    assert page.locator(".strip").count() == 1
    page.select_option("#right", label="flip rate 0.4")
    took = page.evaluate(
        """() => { const began = performance.now(); const home = document.getElementById("explorer");
        for (let i = 0; i < 20; i++)
            home.dispatchEvent(new KeyboardEvent("keydown", {key: i % 2 ? "ArrowLeft" : "ArrowRight"}));
        return (performance.now() - began) / 20; }"""
    )
    assert took < 100
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert page.said == []


@needs_a_browser
def test_what_agents_say_stays_text_in_the_explorer(page):
    page.select_option("#agent", index=1)
    page.click(".strip button:nth-child(2)")
    assert "</script>" in page.locator("#explorer blockquote").first.inner_text()
    assert page.locator("#explorer img, #explorer script").count() == 0
    assert page.title() == "Do false reports change how agents open chain-4?"
    assert page.said == []

"""The audit that ships is one that this release would measure, and says what the report says of every test."""

from pathlib import Path

import pytest

from lockprobe.analysis.inference.battery import infer
from lockprobe.audit.rates import EARLY, measure
from lockprobe.audit.shipped_rates import as_data, false_positives, measured, shipped
from lockprobe.audit.simulate import simulate_outcomes
from lockprobe.audit.simulated_agents import WORLDS, Design
from lockprobe.prose.hypothesis_tests import QUESTIONS, name_of_test
from lockprobe.seeds import generator


def test_every_test_of_every_world_was_measured():
    rng = generator(1)
    names = {test.name for test in infer(simulate_outcomes(WORLDS["no-effect"], Design(), rng), rng).tests}
    assert {(rate.world, rate.test) for rate in measured()} == {(world, name) for world in WORLDS for name in names}


def test_recommended_tests_keep_their_level_and_the_papers_do_not():
    for rate in measured():
        if rate.recommended and not rate.truth:
            assert rate.valid, rate
    _, worst = false_positives("Pearson over repetitions")
    assert worst.rate >= 0.8
    (irrelevant,) = (rate for rate in measured() if rate.test == worst.test and rate.world == "loops-irrelevant")
    assert irrelevant.rate >= 0.8
    assert irrelevant.studies >= 1000


@pytest.mark.parametrize("name", ["loop-trapped", "shared-luck"])
def test_what_was_measured_is_what_is_measured_now(name):
    """The first studies again: any change of a test, or of a world, shows."""
    found = {rate.test: rate.early for rate in measured() if rate.world == name}
    again = measure([WORLDS[name]], studies=EARLY, seed=shipped()["seed"], records=False)
    assert {rate.test: rate.early for rate in again} == {rate.test: rate.rejected for rate in again} == found


def test_data_says_what_the_rates_say():
    rates = measure([WORLDS["no-effect"]], studies=1)
    data = as_data(rates, seed=1)
    assert data["worlds"] == {"no-effect": WORLDS["no-effect"].says}
    assert [row["test"] for row in data["rates"]] == [rate.test for rate in rates]
    assert false_positives("no such test") is None


def figure(rate):
    return f"{rate.rate:.2f} {rate.world}"


def documented():
    """The rows of the table in the docs, question by question, as they follow from the shipped audit."""
    for question, text in QUESTIONS.items():
        asked = [rate for rate in measured() if rate.question == question]
        yield f"| *{text}* | | |"
        for test in dict.fromkeys(rate.test for rate in asked):
            mine = [rate for rate in asked if rate.test == test]
            worst = max((rate for rate in mine if not rate.truth), key=lambda rate: rate.rate)
            name = f"**{name_of_test(test)}**" if mine[0].recommended else name_of_test(test)
            wrong = "" if worst.valid else " **!**"
            said = ", ".join(figure(rate) for rate in mine if rate.truth)
            yield f"| {name} | {worst.rate:.3f} {worst.world}{wrong} | {said} |"


def test_the_docs_hold_the_shipped_audit():
    written = (Path(__file__).parents[2] / "docs" / "statistics.md").read_text(encoding="utf-8")
    assert "\n".join(documented()) in written
    studies = {rate.studies for rate in measured()}
    assert len(studies) == 1
    assert f"`lockprobe audit --studies {studies.pop()}`" in written

"""Rates of rejection are counted right, however they are computed; the shipped ones are those of this release."""

from concurrent.futures.process import BrokenProcessPool
from itertools import product
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.foundation.parallel import Processes
from lockprobe.foundation.seeds import generator
from lockprobe.report.prose.hypothesis_tests import QUESTIONS
from lockprobe.simulation.audit.rates import (
    COMPARISON,
    EARLY,
    EveryLookRate,
    Rate,
    false_positives,
    measure,
    measured,
    shipped,
    within_error,
)
from lockprobe.simulation.audit.simulate import simulate, simulate_study
from lockprobe.simulation.audit.simulated_agents import WORLDS, Design
from lockprobe.statistics.inference.battery import infer
from lockprobe.statistics.outcomes import outcomes

NULL, TRAP = WORLDS["loops-irrelevant"], WORLDS["loop-trapped"]


@pytest.fixture(scope="module")
def rates():
    """The first studies of the shipped audit, measured now."""
    worlds = [NULL, TRAP, WORLDS["shared-luck"]]
    found = measure(worlds, studies=EARLY, seed=shipped()["seed"])
    return {(rate.world, rate.test): rate for rate in found}


def test_counts_are_those_of_the_tests_one_by_one():
    (first, *_) = measure([TRAP], studies=3, seed=5)
    rejected = 0
    for number in range(3):
        place = (5, "audit", TRAP.name, 30, number)
        trials = simulate(TRAP, Design(), generator(*place))
        found = infer(outcomes(trials), generator(*place, "tests"))
        rejected += found.tests[0].rejects
        assert found.tests[0].name == first.test
    assert (first.rejected, first.studies, first.world, first.trials) == (rejected, 3, TRAP.name, 30)


def test_processes_change_no_rate(monkeypatch):
    """Three jobs over two forked workers."""
    monkeypatch.setattr("lockprobe.simulation.audit.rates.BATCH", 1)
    monkeypatch.setattr("lockprobe.foundation.parallel.get_context", lambda _: get_context("fork"))
    few = measure([TRAP], studies=3, seed=2)
    assert few == measure([TRAP], studies=3, seed=2, workers=Processes(2))
    assert few != measure([TRAP], studies=3, seed=3)


def test_the_papers_correlation_finds_harm_where_there_is_none(rates):
    assert rates[NULL.name, "Pearson over repetitions"].rate >= 0.8
    assert rates[NULL.name, "looped against solved, Fisher"].rate == 1.0
    assert rates[NULL.name, "lowest loop rate, chosen by eye, Fisher"].rate > 0.3
    assert rates[NULL.name, "Pearson over repetitions"].valid is False


def test_recommended_tests_keep_their_level_and_find_what_is_there(rates):
    for (name, _), rate in rates.items():
        if rate.recommended and not rate.truth:
            assert rate.valid, (name, rate)
    for test in ("loop onset, log-rank", "success after a loop, Mantel-Haenszel by dose and step"):
        assert rates[TRAP.name, test].truth
        assert rates[TRAP.name, test].rate > 0.6
    assert rates[NULL.name, "greatest difference from the lowest dose, permutation"].rate > 0.7


def test_truth_decides_what_is_a_false_positive(rates):
    for rate in rates.values():
        assert rate.truth == (rate.question in WORLDS[rate.world].truths)
        assert (rate.valid is None) == rate.truth


def test_monte_carlo_error_is_never_nothing():
    made = {"world": "w", "trials": 30, "question": "harm", "test": "t", "recommended": True, "truth": False}
    none = Rate(**made, studies=100, rejected=0, early=0)
    assert (none.rate, none.valid) == (0.0, True)
    assert none.error > 0
    assert Rate(**made, studies=100, rejected=5, early=1).error == pytest.approx(
        np.sqrt(0.0588 * 0.9412 / 100), rel=0.01
    )


@pytest.mark.parametrize(
    ("rejected", "studies", "fine"),
    [(5, 100, True), (12, 100, True), (14, 100, False), (120, 2000, True), (135, 2000, False)],
)
def test_within_monte_carlo_error_is_a_binomial_tail(rejected, studies, fine):
    from scipy.stats import binom

    assert within_error(rejected, studies) is fine
    assert fine == (binom.sf(rejected - 1, studies, 0.05) > 0.001)


def test_people_who_leave_are_not_told_apart_from_an_equal_agent():
    """With every box counted alike they are in a third of studies."""
    (rate,) = (one for one in measure([WORLDS["dropout"]], studies=20) if one.question == "comparison")
    assert rate.rejected <= 3


def test_no_studies_are_refused():
    with pytest.raises(BadValue, match="at least 1"):
        measure([NULL], studies=0)


def test_a_killed_worker_is_one_line(monkeypatch):
    def broken(*_):
        raise BrokenProcessPool("a child process terminated abruptly")

    monkeypatch.setattr("lockprobe.foundation.parallel.Spawned.submit", broken)
    with pytest.raises(Missing, match="a worker process died before its work was done: is there memory enough for 2"):
        measure([TRAP], studies=12, workers=Processes(2))


def test_every_test_of_every_world_was_measured():
    rng = generator(1)
    found, _, _ = simulate_study(WORLDS["no-effect"], Design(), rng)
    names = {test.name for test in infer(found, rng).tests}
    compared = {(rate.world, rate.test) for rate in measured() if rate.question == "comparison"}
    assert {world for world, _ in compared} == {name for name, made in WORLDS.items() if made.people}
    assert {(rate.world, rate.test) for rate in measured()} == compared | set(product(WORLDS, names))


def test_recommended_tests_keep_their_level_and_the_papers_do_not():
    for rate in measured():
        if rate.recommended and not rate.truth:
            assert rate.valid, rate
    _, worst = false_positives("Pearson over repetitions")
    assert worst.rate >= 0.8
    (irrelevant,) = (rate for rate in measured() if rate.test == worst.test and rate.world == "loops-irrelevant")
    assert irrelevant.rate >= 0.8
    assert irrelevant.studies >= 1000


def test_what_was_measured_is_what_is_measured_now(rates):
    """The first studies again: any change of a test, or of a world, shows."""
    shipped_early = {(rate.world, rate.test): rate.early for rate in measured()}
    assert {rate.world for rate in rates.values()} == {"loops-irrelevant", "loop-trapped", "shared-luck"}
    for place, rate in rates.items():
        assert rate.early == rate.rejected == shipped_early[place], place


def test_what_is_said_of_many_agents_is_seldom_false():
    found = shipped()["many_agents"]
    assert {rate["world"] for rate in found["rates"]} == set(found["worlds"])
    for rate in found["rates"]:
        assert rate["studies"] >= 400
        assert rate["rate"] == rate["said"] / rate["studies"]
        assert rate["truth"] or within_error(rate["said"], rate["studies"]), rate


def figure(rate):
    return f"{rate.rate:.2f} {rate.world}"


def documented():
    """The rows of the table in the docs, question by question, as they follow from the shipped audit."""
    for question, text in [*QUESTIONS.items(), ("comparison", COMPARISON)]:
        asked = [rate for rate in measured() if rate.question == question]
        yield f"| *{text}* | | |"
        for test in dict.fromkeys(rate.test for rate in asked):
            mine = [rate for rate in asked if rate.test == test]
            worst = max((rate for rate in mine if not rate.truth), key=lambda rate: rate.rate)
            name = f"**{test}**" if mine[0].recommended else test
            wrong = "" if worst.valid else " **!**"
            said = ", ".join(figure(rate) for rate in mine if rate.truth)
            yield f"| {name} | {worst.rate:.3f} {worst.world}{wrong} | {said} |"


def test_the_docs_hold_the_shipped_audit():
    written = (Path(__file__).parents[3] / "docs" / "statistics-appendix.md").read_text(encoding="utf-8")
    assert "\n".join(documented()) in written
    assert {rate.studies for rate in measured()} == {1000}
    assert "`python benchmarks/audit.py` simulates 1000 studies" in written
    assert shipped()["worlds"] == {name: made.says for name, made in WORLDS.items()}


def test_no_statement_at_every_look_is_false_in_more_than_5_percent_of_studies():
    found = shipped()["every_look"]
    assert {one["agents"] for one in found["rates"]} >= {1, 5, 10}
    for row in found["rates"]:
        own = {name: row[name] for name in ("says", "world", "agents", "studies", "said")}
        rate = EveryLookRate(**own)
        assert (row["rate"], row["error"], row["valid"]) == (rate.rate, rate.error, rate.valid)
        assert rate.valid
        assert rate.studies >= 1000


@pytest.mark.parametrize(("said", "valid"), [(0, True), (65, True), (80, False)])
def test_a_rate_at_every_look_is_valid_within_monte_carlo_error(said, valid):
    assert EveryLookRate(says="x", world="y", agents=1, studies=1000, said=said).valid is valid

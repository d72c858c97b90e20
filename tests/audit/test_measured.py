"""The audit that ships is one that this release would measure, and says what the report says of every test."""

from lockprobe.analysis.inference.battery import infer
from lockprobe.audit.measured import as_data, false_positives, measured
from lockprobe.audit.rates import measure
from lockprobe.audit.worlds import WORLDS, Design, simulate_outcomes
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


def test_what_was_measured_is_what_is_measured_now():
    """Rates of a few studies lie where the shipped ones say."""
    shipped = {rate.test: rate for rate in measured() if rate.world == "loop-trapped"}
    for rate in measure([WORLDS["loop-trapped"]], studies=30, seed=77, records=False):
        expected = shipped[rate.test]
        assert abs(rate.rate - expected.rate) < 4.5 * (rate.error + expected.error)


def test_data_says_what_the_rates_say():
    rates = measure([WORLDS["no-effect"]], studies=1)
    data = as_data(rates, seed=1)
    assert data["worlds"] == {"no-effect": WORLDS["no-effect"].says}
    assert [row["test"] for row in data["rates"]] == [rate.test for rate in rates]
    assert false_positives("no such test") is None

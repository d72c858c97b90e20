"""What is said of many agents: counted as it is said, valid in the shipped audit, and true power where it is true."""

import pytest

from lockprobe.simulation.audit.many_agents import (
    CHANGES,
    MANY_AGENTS,
    MISSED,
    MOVED,
    ORDER,
    SentenceRate,
    sentence_data,
    sentence_rates,
)
from lockprobe.simulation.audit.rates import shipped


def test_every_world_ships_with_its_rates_and_no_false_sentence_is_said_too_often():
    found = shipped()["many_agents"]
    assert found["worlds"] == {name: world.says for name, world in MANY_AGENTS.items()}
    rates = [SentenceRate(**{name: row[name] for name in SentenceRate.__dataclass_fields__}) for row in found["rates"]]
    assert {(rate.world, rate.sentence): rate.truth for rate in rates} == {
        (name, sentence): truth for name, world in MANY_AGENTS.items() for sentence, truth in world.sentences.items()
    }
    for rate in rates:
        assert rate.studies >= 400
        assert rate.valid is not False, rate
    assert sentence_data(rates) == found


@pytest.mark.parametrize(("name", "at_most"), [("suite-of-5", 5), ("six-crossings", 5)])
def test_what_is_false_is_said_in_few_studies(name, at_most):
    """40 studies; each agent by itself, such sentences are false in a tenth to a quarter of them."""
    for rate in sentence_rates([name], studies=40, seed=3):
        assert rate.said <= at_most, rate


def test_agents_that_do_change_are_found():
    rates = {rate.sentence: rate for rate in sentence_rates(["ten-agents-raised"], studies=2)}
    assert rates[CHANGES].said == 2
    lowered = {rate.sentence: rate for rate in sentence_rates(["suite-of-10-lowered"], studies=3)}
    assert (lowered[MOVED].said, lowered[MOVED].valid) == (3, None)


def test_the_number_of_processes_and_the_batches_change_nothing(monkeypatch):
    few = sentence_rates(["suite-of-5"], studies=6)
    monkeypatch.setattr("lockprobe.simulation.audit.many_agents._BATCH", 1)
    seen = []
    assert sentence_rates(["suite-of-5"], studies=6, progress=lambda done, of: seen.append((done, of))) == few
    assert seen[-1] == (6, 6)
    assert [rate.sentence for rate in few] == [ORDER, MOVED, MISSED]

"""The posterior is Bayes': against slow enumeration, and calibrated where all is drawn from the prior."""

from itertools import product

import numpy as np
import pytest
from boxes.beliefs.enumeration import histories

from lockprobe.boxes.beliefs.posterior import ReportedAttempt, begin, noise_model, update
from lockprobe.boxes.beliefs.structures import interlocks
from lockprobe.foundation.errors import BadValue

SMALL = interlocks("single-parent", 3)


def after(known, noise, reports):
    belief = begin(known, noise)
    for report in reports:
        belief = update(belief, report)
    return belief


@pytest.mark.parametrize(
    ("name", "reading", "kinds", "states_only"),
    [
        ("0.3", "memoryless", ["memoryless"], False),
        ("0.3", "latched", ["latched"], False),
        ("0.3", "outcomes", ["outcome-only"], False),
        ("0.3", "positions", ["memoryless", "latched"], False),
        ("aware", "positions", ["memoryless", "latched"], False),
        ("aware", "memoryless", ["outcome-only"], False),
        ("0.3", "latched", ["latched"], True),
        ("aware", "integrated", ["integrated"], False),
        ("0.3", "re-observed", ["re-observed"], True),
        ("0.3", "integrated", ["integrated"], True),
        ("aware", "positions", ["memoryless", "latched"], True),
        ("0.3", "outcomes", ["re-observed", "integrated"], False),
        ("aware", "outcomes", ["re-observed", "integrated"], True),
    ],
)
def test_the_posterior_is_that_of_enumeration(name, reading, kinds, states_only):
    noise = noise_model(name, reading)
    for joints in product(range(3), repeat=3):
        for reports, behind in histories(SMALL.needs, kinds, joints, noise.p, states_only).items():
            belief = after(SMALL, noise, reports)
            total = sum(behind.values())
            expected = [sum(behind[place, moved] for moved in (False, True)) / total for place in range(len(SMALL))]
            assert np.allclose(belief.weights, expected, atol=1e-12)
            assert belief.moved == pytest.approx(sum(m for (_, moved), m in behind.items() if moved) / total)
            assert belief.restarts == 0


def test_a_naive_observer_begins_again_from_the_last_report():
    """Told that joint 1 moved, then that it is where it was: only the second report is kept."""
    known = interlocks("chains", 4)
    belief = after(
        known,
        noise_model("naive"),
        [ReportedAttempt(1, moved=True, positions=2), ReportedAttempt(2, moved=False, positions=0)],
    )
    assert belief.restarts == 1
    assert belief.alive == after(known, noise_model("naive"), [ReportedAttempt(2, moved=False, positions=0)]).alive


@pytest.mark.parametrize("name", ["1.5", "-0.1", "nan", "often", ""])
def test_a_noise_model_that_does_not_exist_is_refused(name):
    with pytest.raises(BadValue, match="noise: got .*, expected naive, aware, or a number from 0 to 1"):
        noise_model(name)

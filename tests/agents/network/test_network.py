"""The network against plain loops over trials and units, and its gradient against finite differences."""

import math

import numpy as np
import pytest

from lockprobe.agents.network.network import Network, encoded, gradient, initial, inputs, shapes
from lockprobe.foundation.errors import BadValue

TRIALS, STEPS, JOINTS, HIDDEN = 3, 4, 3, 5


@pytest.fixture(scope="module")
def network():
    rng = np.random.default_rng(2)
    made = initial(JOINTS, HIDDEN, seed=1)
    return Network(**{name: array + rng.normal(0, 0.3, array.shape) for name, array in made.arrays().items()})


@pytest.fixture(scope="module")
def read():
    return np.random.default_rng(3).normal(0, 1, (STEPS, TRIALS, inputs(JOINTS)))


@pytest.fixture(scope="module")
def aims():
    return np.random.default_rng(4).dirichlet(np.ones(JOINTS), (STEPS, TRIALS))


def by_loops(network, read):
    """Logits of every step, unit by unit, as the equations of a gated recurrent unit are written."""
    size, found = network.hidden, np.zeros((STEPS, TRIALS, network.joints))
    for trial in range(TRIALS):
        state = [0.0] * size
        for step in range(STEPS):

            def gate(which, unit, over, seen=read[step, trial]):
                row = which * size + unit
                given = sum(w * x for w, x in zip(network.gates_in[row], seen, strict=True)) + network.gates_bias[row]
                return given, sum(w * h for w, h in zip(network.gates_state[row], over, strict=True))

            after = []
            for unit in range(size):
                update = 1 / (1 + math.exp(-sum(gate(0, unit, state))))
                reset = 1 / (1 + math.exp(-sum(gate(1, unit, state))))
                given, kept = gate(2, unit, state)
                after.append(update * state[unit] + (1 - update) * math.tanh(given + reset * kept))
            state = after
            layer = [
                math.tanh(sum(w * h for w, h in zip(row, state, strict=True)) + bias)
                for row, bias in zip(network.layer, network.layer_bias, strict=True)
            ]
            for joint in range(network.joints):
                row = network.out[joint]
                found[step, trial, joint] = (
                    sum(w * a for w, a in zip(row, layer, strict=True)) + network.out_bias[joint]
                )
    return found


def played(network, read):
    """The steps, and the logits after each."""
    state, steps = np.zeros((TRIALS, network.hidden)), []
    for seen in read:
        steps.append(network.step(seen, state))
        state = steps[-1].after
    return steps, np.array([network.logits(step.after) for step in steps])


def loss(logits, aims):
    """Cross-entropy, summed over steps and trials."""
    total = np.log(np.exp(logits).sum(axis=2)) - (aims * logits).sum(axis=2)
    return float(total.sum())


def test_the_network_is_the_equations(network, read):
    assert np.allclose(played(network, read)[1], by_loops(network, read), atol=1e-12)


def test_the_gradient_is_that_of_finite_differences_in_every_parameter(network, read, aims):
    steps, logits = played(network, read)
    chances = np.exp(logits) / np.exp(logits).sum(axis=2, keepdims=True)
    slopes = gradient(network, steps, list(chances - aims)).arrays()
    for name, array in network.arrays().items():
        for place in np.ndindex(array.shape):
            sides = []
            for by in (1e-5, -1e-5):
                moved = array.copy()
                moved[place] += by
                sides.append(loss(played(Network(**network.arrays() | {name: moved}), read)[1], aims))
            assert slopes[name][place] == pytest.approx((sides[0] - sides[1]) / 2e-5, abs=1e-6), (name, place)


def test_what_is_read_is_the_last_attempt_its_report_the_positions_the_target_and_the_first_step():
    found = encoded(np.array([-1, 2]), np.array([0.0, -1.0]), np.array([[0.0, 0, 0], [1, 0, 1]]), np.array([1, 0]))
    assert found.tolist() == [[0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1], [0, 0, 1, -1, 1, 0, 1, 1, 0, 0, 0]]
    assert found.shape[1] == inputs(3)


def test_sizes_are_those_asked_for_and_others_are_refused():
    assert {name: array.shape for name, array in initial(4, 64, 1).arrays().items()} == shapes(4, 64)
    assert sum(array.size for array in initial(4, 64, 1).arrays().values()) == 19_588
    for joints, hidden in ((1, 64), (9, 64), (4, 0), (4, 257)):
        with pytest.raises(BadValue):
            initial(joints, hidden, 1)

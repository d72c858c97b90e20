"""The network of a learner: a gated recurrent unit (GRU), one hidden layer and a logit per joint, in NumPy.

In each step the network reads what a policy is told (:func:`encoded`). A batch is played forward one step at a time,
because each action decides the next input. Gradients come from backpropagation through time, written out by hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lockprobe.foundation.seeds import generator
from lockprobe.foundation.validation import check_whole

__all__ = [
    "HIDDEN",
    "MOST_HIDDEN",
    "MOST_JOINTS",
    "Network",
    "StepActivations",
    "encoded",
    "gradient",
    "initial",
    "inputs",
    "shapes",
]

Array = NDArray[np.float64]

HIDDEN = 64
"""Units of the recurrent state, and of the hidden layer, by default."""

MOST_HIDDEN, MOST_JOINTS = 256, 8


def inputs(joints: int) -> int:
    """The number of inputs of a network for this number of joints."""
    return 3 * joints + 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Network:
    """The parameters for n joints, H units and I inputs.

    Attributes:
        gates_in: Input weights of the update gate, the reset gate and the candidate, shape (3 H, I).
        gates_state: State weights of the same, shape (3 H, H).
        gates_bias: Biases of the same, shape (3 H,).
        layer: Weights of the hidden layer, shape (H, H).
        layer_bias: Biases of the hidden layer, shape (H,).
        out: Weights of the logits, shape (n, H).
        out_bias: Biases of the logits, shape (n,).
    """

    gates_in: Array
    gates_state: Array
    gates_bias: Array
    layer: Array
    layer_bias: Array
    out: Array
    out_bias: Array

    @property
    def joints(self) -> int:
        """The number of joints of the boxes that it plays."""
        return len(self.out)

    @property
    def hidden(self) -> int:
        """The number of hidden units."""
        return len(self.layer)

    def arrays(self) -> dict[str, Array]:
        """The parameters by name."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def step(self, read: Array, state: Array) -> StepActivations:
        """Compute the next state of every trial.

        Args:
            read: Inputs, shape (trials, I).
            state: States, shape (trials, H); zeros before the first step.
        """
        size = self.hidden
        given = read @ self.gates_in.T + self.gates_bias
        kept = state @ self.gates_state.T
        update, reset = np.split(_sigmoid(given[:, : 2 * size] + kept[:, : 2 * size]), 2, axis=1)
        candidate = np.tanh(given[:, 2 * size :] + reset * kept[:, 2 * size :])
        after = update * state + (1 - update) * candidate
        return StepActivations(read, state, update, reset, candidate, kept[:, 2 * size :], after)

    def logits(self, state: Array) -> Array:
        """The logits of the joints, shape (trials, n), for states of shape (trials, H)."""
        found: Array = np.tanh(state @ self.layer.T + self.layer_bias) @ self.out.T + self.out_bias
        return found


class StepActivations(NamedTuple):
    """The activations of one step, kept for backpropagation; all of shape (trials, H), except ``read``."""

    read: Array
    before: Array
    update: Array
    reset: Array
    candidate: Array
    recalled: Array
    after: Array


def shapes(joints: int, hidden: int) -> dict[str, tuple[int, ...]]:
    """The shape of each parameter."""
    return {
        "gates_in": (3 * hidden, inputs(joints)),
        "gates_state": (3 * hidden, hidden),
        "gates_bias": (3 * hidden,),
        "layer": (hidden, hidden),
        "layer_bias": (hidden,),
        "out": (joints, hidden),
        "out_bias": (joints,),
    }


def initial(joints: int, hidden: int, seed: int) -> Network:
    """An untrained network: weights uniform within +-1 / sqrt(inputs of the unit), biases 0.

    Raises:
        BadValue: If the sizes are out of range.
    """
    check_whole("joints", joints, 2, MOST_JOINTS)
    check_whole("hidden", hidden, 1, MOST_HIDDEN)
    rng = generator(seed, "learner", "weights")
    made = {
        name: rng.uniform(-1, 1, shape) / np.sqrt(shape[-1]) if len(shape) == 2 else np.zeros(shape)
        for name, shape in shapes(joints, hidden).items()
    }
    return Network(**made)


def encoded(attempted: NDArray[np.int64], moved: Array, positions: Array, target: NDArray[np.int64]) -> Array:
    """The inputs of a network, shape (trials, 3 n + 2).

    Args:
        attempted: The joint attempted last, -1 before the first step, shape (trials,).
        moved: 1 if the report said moved, -1 if blocked, 0 without a report, shape (trials,).
        positions: 1 for each joint reported away from its start, else 0, shape (trials, n).
        target: The target, shape (trials,).
    """
    one_hot = np.eye(positions.shape[1] + 1)
    first = (attempted < 0).astype(np.float64)
    return np.column_stack([one_hot[attempted][:, :-1], moved, positions, one_hot[target][:, :-1], first])


def gradient(network: Network, steps: Sequence[StepActivations], errors: Sequence[Array]) -> Network:
    """The gradient of a loss by backpropagation through time, as a network of derivatives.

    Args:
        network: The network that made the steps.
        steps: The results of :meth:`Network.step`, in order.
        errors: Derivatives of the loss with respect to the logits after each step, each of shape (trials, n).
    """
    total = {name: np.zeros_like(array) for name, array in network.arrays().items()}
    size, back = network.hidden, np.zeros_like(steps[0].before)
    for step, error in zip(reversed(steps), reversed(errors), strict=True):
        layer = np.tanh(step.after @ network.layer.T + network.layer_bias)
        total["out"] += error.T @ layer
        total["out_bias"] += error.sum(axis=0)
        inner = (error @ network.out) * (1 - layer**2)
        total["layer"] += inner.T @ step.after
        total["layer_bias"] += inner.sum(axis=0)
        back = back + inner @ network.layer
        candidate = back * (1 - step.update) * (1 - step.candidate**2)
        update = back * (step.before - step.candidate) * step.update * (1 - step.update)
        reset = candidate * step.recalled * step.reset * (1 - step.reset)
        given = np.concatenate([update, reset, candidate], axis=1)
        kept = np.concatenate([update, reset, candidate * step.reset], axis=1)
        total["gates_in"] += given.T @ step.read
        total["gates_bias"] += given.sum(axis=0)
        total["gates_state"] += kept.T @ step.before
        back = back * step.update + kept @ network.gates_state
    assert total["gates_bias"].shape == (3 * size,)
    return Network(**total)


def _sigmoid(value: Array) -> Array:
    found: Array = 0.5 * (1 + np.tanh(value / 2))
    return found

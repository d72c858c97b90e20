"""Studies of simulated agents whose truth is known (worlds), as columns or as records: error rates are held with them."""

from dataclasses import dataclass, fields, replace

import numpy as np

from lockprobe.interventions.conditions import flips
from lockprobe.simulation.power.effects import BUDGET, JOINTS, P, World, actions_of, default_worlds, solved_at
from lockprobe.statistics.loops import onset_batch
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.trial.record import Decision, Step, Trial, TrialError
from lockprobe.trial.trial_name import TrialName


@dataclass(frozen=True, kw_only=True)
class Design:
    """The size of a study; the paper's flip study by default (Sec. 3.2)."""

    p: tuple[float, ...] = P
    repetitions: int = 3
    trials: int = 10

    @property
    def clusters(self):
        """Trials per p."""
        return self.repetitions * self.trials


@dataclass(frozen=True, kw_only=True)
class Known(World):
    """A world with luck, people and errors.

    ``shared``: share of trials with the same luck at every p; ``apart``: the lowest p has another. ``people``: who play
    at each p, each at one, unequally good by ``likeness``. ``breaks``: chance per step of an error at the highest p.
    ``slow``: share of blocks that take the whole budget at every p but the lowest, with equal means.
    """

    success: tuple[float, ...] = (0.5,) * 7
    truths: frozenset = frozenset()
    shared: float = 0.0
    apart: bool = False
    people: int = 0
    likeness: float = 0.0
    breaks: float = 0.0
    slow: float = 0.0


WORLDS = {
    one.name: Known(**{field.name: getattr(one, field.name) for field in fields(one)}) for one in default_worlds()
} | {
    name: Known(name=name, says="", **truth)
    for name, truth in {
        "no-effect": {},
        "shared-luck": {"shared": 0.5},
        "unequal-luck": {"shared": 1.0, "apart": True},
        "people": {"people": 6, "likeness": 0.5},
        "skewed-steps": {"success": (1.0,) * 7, "slow": 0.05},
        "broken-trials": {"breaks": 0.08},
        "saturating": {
            "success": (0.23, 0.45, 0.57, 0.63, 0.66, 0.67, 0.67),
            "truths": frozenset({"success", "speed"}),
        },
        "inverted-u": {
            "success": (0.2, 0.55, 0.8, 0.9, 0.8, 0.55, 0.2),
            "truths": frozenset({"success", "speed", "shape"}),
        },
        "loops-return": {
            "trap": (0.5, 0.25, 0.1, 0.03, 0.1, 0.25, 0.5),
            "truths": frozenset({"looping", "looping again"}),
        },
    }.items()
}


def simulated(name, rng, design=None, **changed):
    """The ended trials of one study, and those that broke."""
    columns, broke, _ = _played(name, rng, design or Design(), changed)
    return columns.at(~broke), columns.at(broke)


def records(name, rng, design=None):
    """The same as trials."""
    design = design or Design()
    columns, broke, actions = _played(name, rng, design, {})
    conditions = {one.doses["flip.p"] if one.doses else 0.0: one for one in flips(design.p, modalities=("symbolic",))}
    return [
        _trial(f"simulated:{name}", conditions[float(columns.dose[i])], columns, i, bool(broke[i]), actions[i].tolist())
        for i in range(len(columns))
    ]


def _played(name, rng, design, changed):
    truth = replace(WORLDS[name], **changed)
    n, clusters = len(design.p), design.clusters
    luck = rng.random((n, clusters, BUDGET, 3))
    alike = rng.random(clusters) < truth.shared
    luck[truth.apart :, alike] = rng.random((clusters, BUDGET, 3))[alike]
    luck = luck.reshape(-1, BUDGET, 3)
    success = np.repeat(truth.success, clusters)
    who = np.arange(n * clusters) * truth.people // clusters
    if truth.people:
        from scipy.special import ndtr, ndtri

        able = rng.standard_normal(n * truth.people)[who] * truth.likeness**0.5
        success = ndtr((ndtri(success) + able) / (1 - truth.likeness) ** 0.5)
    actions = actions_of(np.repeat(truth.trap, clusters), luck)
    onset = onset_batch(actions)
    solved = solved_at(success, luck[:, :, 2])
    if truth.slow:
        solved = _skewed(truth.slow, n, clusters, rng)
    failed = rng.random((n * clusters, BUDGET)) < np.repeat([0.0] * (n - 1) + [truth.breaks], clusters)[:, None]
    fault = np.where(failed.any(axis=1), failed.argmax(axis=1) + 1, BUDGET + 1)
    broke = (fault <= BUDGET) & ((solved == 0) | (fault <= solved))
    length = np.where(broke, fault - 1, np.where(solved > 0, solved, BUDGET))
    cluster = np.tile(np.arange(clusters), n)
    columns = Outcomes(
        dose=np.repeat(np.array(design.p), clusters),
        repetition=cluster // design.trials + 1,
        trial=cluster % design.trials + 1,
        length=length,
        solved=(solved > 0) & ~broke,
        onset=np.where(onset <= length, onset, 0),
        player=np.array([f"participant:{one}" for one in who] if truth.people else [], str),
    )
    return columns, broke, actions


def _skewed(slow, n, clusters, rng):
    """Five to seven steps at the lowest p, else fewer or, in rare blocks, all: of equal means."""
    steps = rng.integers(5, 8, size=(n, clusters))
    usual = (6 - slow * BUDGET) / (1 - slow)
    short = int(usual) + (rng.random((n - 1, clusters)) < usual % 1)
    steps[1:] = np.where(rng.random(clusters) < slow, BUDGET, short)
    return steps.reshape(-1)


def _trial(agent, told, columns, place, broke, actions):
    """The record of one trial. The joint attempted last opens the box, so it is the target."""
    joints, length, solved = tuple("ABCD"[:JOINTS]), int(columns.length[place]), bool(columns.solved[place])
    number = {"repetition": int(columns.repetition[place]), "trial": int(columns.trial[place])}
    name = TrialName(study="flips", agent=agent, condition=told.label, **number)
    return Trial(
        key=str(name), study=name.study, agent=agent, facts={}, box="clock", condition=told.label, specs=told.specs,
        doses=told.doses, modality=told.modality, channels=(), **number, seed=0, budget=BUDGET, joints=joints,
        labels=joints, listing=joints, target=joints[actions[length - 1]], opening="",
        steps=tuple(
            Step(
                step=i + 1, state="0000", joint=joints[action], moved=solved and i == length - 1,
                told_moved=solved and i == length - 1, told_state=None, told="", decision=Decision(joint=joints[action]),
            )
            for i, action in enumerate(actions[:length])
        ),
        ending="error" if broke else "solved" if solved else "budget",
        error=TrialError(boundary="model", message="simulated", step=length + 1) if broke else None,
    )  # fmt: skip

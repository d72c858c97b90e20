"""Studies that somebody looks at after every block, and the false statements that they make; ``every_look.py`` runs it.

Agents of known truth play long studies. A study is false if a false statement is made at any of its looks. The
direction of a statement is that of the estimate at each look. Every world has a stream of its own.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from looking import Said, said_at_every_look, same_as_the_report
from numpy.typing import NDArray
from why_rules import Case, Job, drawn

from lockprobe.foundation.seeds import generator
from lockprobe.simulation.audit.simulate import simulate_columns
from lockprobe.simulation.audit.simulated_agents import WORLDS, World
from lockprobe.statistics.agent_comparison.paired import BlockMean, mean_at_every_look, numbers_of
from lockprobe.statistics.inference.broken_trials import completed, worst_case_difference
from lockprobe.statistics.inference.difference import any_difference
from lockprobe.statistics.inference.logrank import holm
from lockprobe.statistics.outcomes import Outcomes
from lockprobe.statistics.proportions import ALPHA
from lockprobe.statistics.sequential.betting import SHARES, log_wealth, looks
from lockprobe.statistics.sequential.order import BlockOrder
from lockprobe.statistics.sequential.shares import share_at_every_look
from lockprobe.statistics.why.mechanism import CONTRASTS, MARGIN, NEEDS, decide, decision_of

Array = NDArray[np.float64]

BLOCKS = 200
AGENTS = (1, 5, 10)
MARGIN_OF_NONE = 0.1

CHANGES = "false reports raise or lower success"
NONE = "the same, or change it by less than 10 points"
WHY = "why false reports change success"
BETTER = "an agent solves more boxes than another"
SOONER = "an agent solves sooner than another"
CHANCE = "an agent solves more, or fewer, than random agents"


@dataclass(frozen=True, slots=True)
class Asked:
    """Some studies of one world: numbers ``first`` to ``end`` - 1; for the study of controls with its case."""

    says: str
    world: str
    seed: int
    first: int
    end: int
    case: Case | None = None

    @property
    def studies(self) -> int:
        """How many they are."""
        return self.end - self.first

    def rng(self) -> np.random.Generator:
        """Their stream."""
        return generator(self.seed, "every look", self.says, self.world, self.first)


@dataclass(frozen=True, slots=True)
class Group:
    """Worlds that make statements of one kind.

    Attributes:
        says: The statement.
        size: Studies that are played at once.
        worlds: World -> what plays some studies of it: number of agents -> how many were false.
    """

    says: str
    size: int
    worlds: Mapping[str, Callable[[Asked], dict[int, int]]]


def _solved(
    rng: np.random.Generator, shape: tuple[int, int, int], shares: Sequence[float], luck: str
) -> NDArray[np.int8]:
    """Whether blocks were solved, shape (studies, agents, blocks, conditions): agents have luck of their own."""
    own = rng.random((*shape, len(shares)), dtype=np.float32)
    if luck != "own":
        alike = rng.random((*shape, 1)) < (0.5 if luck == "half" else 1)
        own[..., 1:] = np.where(alike, own[..., 1:2], own[..., 1:])
        if luck == "half":
            own[..., :1] = np.where(alike, own[..., 1:2], own[..., :1])
    return (own < np.array(shares, dtype=np.float32)).astype(np.int8)


def _false(said: Said, truth: Array) -> NDArray[np.bool_]:
    """Whether each study said something false at any look, given the true difference of each dose."""
    effect = ((said.effect != 0) & (said.effect != np.sign(truth))).any(axis=(1, 2))
    found: NDArray[np.bool_] = effect | (said.small & (np.abs(truth) >= MARGIN_OF_NONE - 1e-9)).any(axis=(1, 2))
    return found


def doses(shares: Sequence[float], luck: str, margin: float | None = None) -> Callable[[Asked], dict[int, int]]:
    """Studies of several doses against a control; the success of each, the control first."""
    truth = np.array(shares[1:]) - shares[0]

    def play(asked: Asked) -> dict[int, int]:
        solved = _solved(asked.rng(), (asked.studies, max(AGENTS), BLOCKS), shares, luck)
        pairs = solved[..., 1:] - solved[..., :1]
        found = {}
        for agents in AGENTS:
            own = pairs[:, :agents].reshape(-1, BLOCKS, len(truth))
            said = said_at_every_look(own, agents=agents, margin=margin)
            if not asked.first:
                same_as_the_report(own, said, agents=agents, margin=margin)
            found[agents] = int(_false(said, truth).reshape(-1, agents).any(axis=1).sum())
        return found

    return play


def _doses(number: int) -> str:
    return f"{number} dose{'s' * (number > 1)}"


def doses_worlds() -> Iterator[Group]:
    """1 to 11 doses, of which none changes success; and some that do not beside others that change it by 10 points."""
    lucks = {"own": "luck of their own", "half": "half of the luck shared", "apart": "other luck than the control"}
    nothing = {
        f"{_doses(k)}, {100 * at:.0f} % solved, {lucks[luck]}": doses((at,) * (k + 1), luck)
        for k in (1, 3, 4, 7, 11)
        for at in (0.1, 0.5, 0.9)
        for luck in lucks
    }
    yield Group(CHANGES, 50, nothing)
    mixed = {
        f"{_doses(k)}, {(k + 1) // 2} of them {sign}10 points, {100 * at:.0f} % solved, {lucks[luck]}": doses(
            (at, *(at + float(f"{sign}.1") * (i % 2 == 0) for i in range(k))), luck, MARGIN_OF_NONE
        )
        for k in (1, 4, 7, 11)
        for at, sign in ((0.1, "+"), (0.5, "+"), (0.95, "-"))
        for luck in ("own", "half")
    }
    alike = {
        f"{k} doses, all +10 points, 50 % solved, {lucks[luck]}": doses((0.5,) + (0.6,) * k, luck, MARGIN_OF_NONE)
        for k in (4, 11)
        for luck in ("own", "half")
    }
    yield Group(NONE, 50, mixed | alike)


def _table(found: Outcomes, doses_: NDArray[np.float64]) -> Array:
    """1 where solved, 0 where not, NaN where no trial ended, shape (blocks, doses)."""
    table = np.full((BLOCKS, len(doses_)), math.nan)
    table[found.trial - 1, np.searchsorted(doses_, found.dose)] = found.solved
    return table


def audit_world(world: World) -> Callable[[Asked], dict[int, int]]:
    """Studies of a world of the audit, with its broken trials: a statement must hold whether they are solved or not."""
    design = replace(world.design, repetitions=1, trials=BLOCKS)
    sign = np.sign(np.array(world.success[1:]) - world.success[0])
    truth = np.where((sign == 0) & (world.harm < 1), 1.0, sign)  # fewer loops do less harm

    def play(asked: Asked) -> dict[int, int]:
        rng, false = asked.rng(), 0
        for number in range(asked.studies):
            found, broken = simulate_columns(world, design, rng)
            cases = [found, *completed(found, broken)] if len(broken) else [found]
            said = [_said(one, np.array(design.p)) for one in cases]
            effect = np.array([one.effect[0] for one in said])
            held = np.where((effect == effect[0]).all(axis=0), effect[0], 0)
            if not asked.first and number < 2:
                _same_as_any_difference(cases, held)
            false += bool(((held != 0) & (held != truth)).any())
        return {1: false}

    return play


def _said(found: Outcomes, p: NDArray[np.float64]) -> Said:
    """What is said of one study; a block without a pair changes nothing."""
    table = _table(found, p)
    pairs = np.nan_to_num(table[:, 1:] - table[:, :1]).astype(np.int8)
    return said_at_every_look(pairs[None])


def _same_as_any_difference(cases: Sequence[Outcomes], held: NDArray[np.int8]) -> None:
    """Hold what is said at the last look to the report's function."""
    rng, order = np.random.default_rng(1), BlockOrder(plans=((1, BLOCKS),))
    tested = [any_difference(replace(one, order=order), rng) for one in cases]
    difference = worst_case_difference(*tested) if len(tested) > 1 else tested[0]
    if len(tested) > 1:  # looks fall on other blocks where trials broke
        return
    seen = [int(np.sign(one.value)) if one.p_value < ALPHA else 0 for one in difference.at]
    assert seen == held[-1].tolist(), (seen, held[-1])


def audit_worlds() -> Group:
    """The worlds of the audit that are about agents."""
    return Group(CHANGES, 25, {name: audit_world(one) for name, one in WORLDS.items() if not one.people})


def _running_p(values: Array, bound: float = 1.0) -> Array:
    """The P value after each number, as it runs."""
    found: Array = np.minimum(1.0, np.exp(-np.maximum.accumulate(log_wealth(values, 0.0, low=-bound, high=bound))))
    return found


def _why(asked: Asked) -> dict[int, int]:
    """Studies of controls: whether a verdict, or a claim on the arms, is false at any look."""
    assert asked.case is not None
    rng, job = asked.rng(), Job(case=asked.case, blocks=BLOCKS, studies=1)
    return {
        1: sum(
            _why_is_false(drawn(job, rng), asked.case, checked=not asked.first and not number)
            for number in range(asked.studies)
        )
    }


def _why_is_false(solved: Mapping[str, Array], case: Case, *, checked: bool) -> bool:
    at = looks(len(solved["lie"]))
    change = solved["lie"] - solved["truth"]
    said = said_at_every_look(change.astype(np.int8)[None, :, None], margin=MARGIN)
    total = _course(change)
    contrasts = {
        name: _course(np.mean([solved[more] - solved[less] for more, less in pairs], axis=0))
        for name, pairs in CONTRASTS.items()
    }
    shares = dict(zip(solved, case.source, strict=True)) if case.source.ndim == 1 else {}
    decision = None
    for i, n in enumerate(at.tolist()):
        parts = contrasts if total[1][n - 1] < ALPHA else {}
        small = 0.0 if said.small[0, i, 0] else 1.0
        decision = decision_of(_at(total, n), {name: _at(course, n) for name, course in parts.items()}, small)
        if case.mechanism.wrong(decision.verdict, case.total):
            return True
        if shares and not all(_holds(claim, shares, decision.way) for claim in decision.claims):
            return True
    if checked:
        report = decide(solved, every_look=True)
        assert decision is not None
        assert (report.verdict, report.claims) == (decision.verdict, decision.claims)
    return False


def _course(values: Array) -> tuple[Array, Array]:
    """Mean and running P value after each block."""
    return values.cumsum() / np.arange(1, len(values) + 1), _running_p(values)


def _at(course: tuple[Array, Array], n: int) -> BlockMean:
    """A mean after so many blocks. Its interval leaves out 0 if its P value is below 0.05."""
    value, p = float(course[0][n - 1]), float(course[1][n - 1])
    low, high = (value, value) if p < ALPHA else (-1.0, 1.0)
    return BlockMean(value=value, low=low, high=high, p_value=p, pairs=n, blocks=n)


def _holds(claim: str, shares: Mapping[str, float], way: int) -> bool:
    """Whether all contrasts that a claim needs go this way in truth."""

    def true(name: str) -> float:
        sign, name = (-1, name[1:]) if name.startswith("-") else (1, name)
        return sign * float(np.mean([shares[more] - shares[less] for more, less in CONTRASTS[name]]))

    return all(way * true(name) > 1e-9 for name in NEEDS[claim])  # type: ignore[index]


_BY_P = (0.5, 0.7, 0.3, 0.6)


_ALIKE = {
    "own": "equally good agents, luck of their own",
    "half": "equally good agents, half of the luck shared",
    "turned": "equally good agents that are good at other flip rates",
    "slow": "equally good agents, one block in 20 takes the whole budget",
}


def compared_worlds() -> Iterator[Group]:
    """Agents that are equally good, over four flip rates."""
    for says in (BETTER, SOONER):
        yield Group(says, 50, {name: _compared(kind, says) for kind, name in _ALIKE.items()})


def _compared(kind: str, says: str) -> Callable[[Asked], dict[int, int]]:
    """Every pair of agents is compared (Holm), in success or in steps, block by block."""

    def play(asked: Asked) -> dict[int, int]:
        rng, false = asked.rng(), Counter[int]()
        for number in range(asked.studies):
            success, steps = _played(kind, rng)
            found, bound = (success, 1.0) if says == BETTER else (steps, 20.0)
            for agents in (2, 5):
                false[agents] += _told_apart(found[:agents], bound)
            if not asked.first and not number:
                report = mean_at_every_look(found[1] - found[0], bound=bound)
                assert report.p_value is not None
                assert math.isclose(report.p_value, _at_looks(found[1] - found[0], bound))
        return dict(false)

    return play


def _played(kind: str, rng: np.random.Generator) -> tuple[Array, Array]:
    """Success and steps of five agents, shape (agents, blocks, flip rates)."""
    shape = (5, BLOCKS, len(_BY_P))
    luck = rng.random(shape)
    if kind == "half":
        luck = np.where(rng.random((1, BLOCKS, 1)) < 0.5, rng.random((1, *shape[1:])), luck)
    shares = np.array([np.roll(_BY_P, i if kind == "turned" else 0) for i in range(5)])
    steps = np.ceil(20 * luck ** (0.3 if kind == "half" else 1))
    if kind == "slow":
        usual = (6 - 0.05 * 20) / 0.95
        rare = np.where(rng.random((1, BLOCKS, 1)) < 0.05, 20.0, np.floor(usual + luck))
        steps = np.where((np.arange(5) % 2 == 0)[:, None, None], rng.integers(5, 8, shape), rare)
    return (luck < shares[:, None]).astype(np.float64), steps


def _at_looks(differences: Array, bound: float) -> float:
    values = numbers_of(differences, bound).values
    return float(_running_p_at_looks(values, bound))


def _running_p_at_looks(values: Array, bound: float) -> float:
    wealth = log_wealth(values, 0.0, low=-bound, high=bound)[looks(len(values)) - 1]
    return min(1.0, math.exp(-wealth.max()))


def _told_apart(found: Array, bound: float) -> bool:
    """Whether some pair of agents differs. P values run, so that the last look holds what any has said."""
    pairs = [(i, j) for i in range(len(found)) for j in range(i)]
    adjusted = holm([_at_looks(found[i] - found[j], bound) for i, j in pairs])
    return any(p is not None and p < ALPHA for p in adjusted)


def chance_worlds() -> Group:
    """Agents that solve as many boxes as random agents do."""
    return Group(CHANCE, 50, {f"{100 * at:.0f} % solved": _by_chance(at) for at in (0.05, 0.54, 0.9)})


def _by_chance(at: float) -> Callable[[Asked], dict[int, int]]:
    def play(asked: Asked) -> dict[int, int]:
        solved = asked.rng().random((asked.studies, max(AGENTS), BLOCKS)) < at
        most = _share_wealth(solved.cumsum(axis=2)[..., looks(BLOCKS) - 1], looks(BLOCKS), at).max(axis=2)
        left_out = {agents: most[:, :agents] >= math.log(agents / ALPHA) for agents in AGENTS}
        if not asked.first:
            for agents, found in left_out.items():
                shares = [share_at_every_look(one).at_level(1 - ALPHA / agents) for one in solved[0, :agents]]
                assert found[0].tolist() == [one.high < at or one.low > at for one in shares]
        return {agents: int(found.any(axis=1).sum()) for agents, found in left_out.items()}

    return play


def _share_wealth(count: NDArray[np.int64], n: NDArray[np.int64], at: float) -> Array:
    """The logarithm of the wealth against a share, of so many solved trials."""
    logarithms = count[..., None] * np.log(SHARES / at) + (n - count)[..., None] * np.log((1 - SHARES) / (1 - at))
    largest = logarithms.max(axis=-1, keepdims=True)
    found: Array = np.log(np.exp(logarithms - largest).mean(axis=-1)) + largest[..., 0]
    return found


def groups() -> dict[str, list[Group]]:
    """The worlds of every statement, except those of the study of controls."""
    every = [*doses_worlds(), audit_worlds(), *compared_worlds(), chance_worlds()]
    return {says: [one for one in every if one.says == says] for says in (CHANGES, NONE, BETTER, SOONER, CHANCE)}


def false_of(asked: Asked) -> dict[int, int]:
    """How many of these studies made a false statement, by the number of agents."""
    if asked.says == WHY:
        return _why(asked)
    worlds = next(group.worlds for group in groups()[asked.says] if asked.world in group.worlds)
    return worlds[asked.world](asked)

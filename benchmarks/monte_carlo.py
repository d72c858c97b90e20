"""Populations: trials of simple agents by every way there is, and what peers make of such small worlds, in one run.

    uv run [--with envpool,pgx] python benchmarks/monte_carlo.py [--trials 500000]

CPU time, one thread. Nominal steps are trials times the budget of 20, whether a trial is solved before or not; actual
steps are those really made. Peers that are not installed are left out.
"""

from __future__ import annotations

import argparse
import asyncio
import os
import time
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from itertools import chain
from typing import Any

import gymnasium
import numpy as np

from lockprobe.agents.catalogue import resolve
from lockprobe.boxes.families import box
from lockprobe.interventions.conditions import flips
from lockprobe.plants.symbolic import SymbolicPlant
from lockprobe.simulation.exact.propagation import propagate
from lockprobe.simulation.montecarlo.plain import play_plainly, policy_of, world_of
from lockprobe.simulation.montecarlo.populations import Population, population
from lockprobe.studies.modality import interventions_for
from lockprobe.studies.study import Study
from lockprobe.trial.loop import play

BUDGET = 20
SOFTMAX = "cognitive:softmax-memory?failure=5&recent=2"
MEMORY = ("human-inspired", SOFTMAX, "cognitive:random-map?avoid=last")

Row = tuple[str, str, float | None, float]
"""Way, agent or world, nominal and actual steps a second."""


def cpu_seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """CPU time of the quickest of a few."""
    taken = []
    for _ in range(repeats):
        began = time.process_time()
        work()
        taken.append(time.process_time() - began)
    return min(taken)


def closed_loop(agent: str, trials: int) -> int:
    """Trials as ``lockprobe.run_trial`` plays them, with records; how many steps they had."""
    study = Study(name="flips", agents=(agent,), box=box(), conditions=flips((0.3,)), repetitions=1, trials=trials)
    player = resolve(agent).make()

    async def all_trials() -> int:
        steps = 0
        for plan in study.plans(agent):
            plant = SymbolicPlant(plan.box)
            steps += len((await play(plan, plant=plant, interventions=interventions_for(plan), agent=player)).steps)
        return steps

    return asyncio.run(all_trials())


def plain_loop(agent: str, trials: int) -> int:
    """Trials by the readable loop; how many steps they had."""
    policy, world = policy_of(agent), world_of("chain-4", p=0.3, flip="transient", max_steps=BUDGET)
    channel, own = np.random.default_rng(0), np.random.default_rng(1)
    return sum(len(play_plainly(policy, world, (2, 0, 3, 1), channel, own).joints) for _ in range(trials))


def loops(trials: int) -> Iterator[Row]:
    """Trials one by one."""
    few, more = trials // 500, trials // 100
    for agent in ("random", *MEMORY):
        seconds = cpu_seconds(lambda agent=agent: closed_loop(agent, few))
        yield "closed loop with records (`trial.play`)", agent, None, closed_loop(agent, few) / seconds
    for agent in ("random", *MEMORY):
        seconds = cpu_seconds(lambda agent=agent: plain_loop(agent, more))
        yield "readable loop", agent, None, plain_loop(agent, more) / seconds


def populations(trials: int) -> Iterator[Row]:
    """Many trials a call."""
    ways: list[tuple[str, str, int, dict[str, Any]]] = [
        ("population of a study, recorded", "human-inspired", trials // 50, {"streams": "study", "record": True}),
        *(("population, recorded", agent, trials, {"streams": "fast", "record": True}) for agent in MEMORY),
        ("population, recorded", "random", trials, {"streams": "fast", "record": True}),
        ("population", "random", trials * 20, {"streams": "fast"}),
    ]
    for way, agent, count, asked in ways:

        def work(agent: str = agent, count: int = count, asked: dict[str, Any] = asked) -> Population:
            return population(agent, p=0.3, trials=count, threads=1, **asked)

        seconds = cpu_seconds(work)
        yield way, agent, count * BUDGET / seconds, float(work().steps.sum()) / seconds


def gymnasium_toys(count: int) -> Iterator[Row]:
    """Toys of Gymnasium, one after the other; it has none for many at once."""
    for name in ("FrozenLake-v1", "Taxi-v4"):
        envs = gymnasium.make_vec(name, num_envs=count, vectorization_mode="sync")
        envs.reset(seed=1)
        actions = np.random.default_rng(0).integers(envs.single_action_space.n, size=(100, count))
        seconds = cpu_seconds(lambda envs=envs, actions=actions: [envs.step(one) for one in actions])
        yield f"Gymnasium {gymnasium.__version__}, sync", f"{name}, {count:,} at once", None, actions.size / seconds


def envpool_toys(count: int) -> Iterator[Row]:
    """The same toys in C++."""
    import envpool

    for name in ("FrozenLake-v1", "Taxi-v3"):
        envs = envpool.make_gymnasium(name, num_envs=count, num_threads=1, seed=1)
        envs.reset()
        actions = np.random.default_rng(0).integers(envs.action_space.n, size=(500, count)).astype(np.int32)
        seconds = cpu_seconds(lambda envs=envs, actions=actions: [envs.step(one) for one in actions])
        yield f"EnvPool {envpool.__version__}", f"{name}, {count:,} at once", None, actions.size / seconds


def pgx_game(count: int) -> Iterator[Row]:
    """Tic-tac-toe by random legal moves, compiled by JAX."""
    os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false"
    import jax
    import pgx

    game = pgx.make("tic_tac_toe")

    def step(state: Any, key: Any) -> tuple[Any, None]:
        action = jax.random.categorical(key, jax.numpy.where(state.legal_action_mask, 0.0, -1e9), axis=-1)
        return jax.vmap(game.step)(state, action), None

    @jax.jit
    def games(key: Any) -> Any:
        start = jax.vmap(game.init)(jax.random.split(key, count))
        return jax.lax.scan(step, start, jax.random.split(key, BUDGET))[0].terminated.sum()

    games(jax.random.PRNGKey(0)).block_until_ready()
    seconds = cpu_seconds(lambda: games(jax.random.PRNGKey(1)).block_until_ready())
    world = f"tic-tac-toe, {count:,} at once"
    yield f"Pgx {pgx.__version__}, JAX {jax.__version__}", world, None, count * BUDGET / seconds


def compare(trials: int) -> None:
    """The table. Ratios are of actual steps, to the closed loop of the random agent."""
    ways = [loops(trials), populations(trials), gymnasium_toys(100)]
    if find_spec("envpool"):
        ways.append(envpool_toys(1_000))
    if find_spec("pgx"):
        ways.append(pgx_game(10_000))
    reference = None
    print("| way | agent or world | nominal steps a second | actual steps a second | ratio |\n|---|---|---|---|---|")
    for way, world, nominal, actual in chain.from_iterable(ways):
        reference = reference or actual
        shown = "" if nominal is None else f"{nominal:,.0f}"
        print(f"| {way} | {world} | {shown} | {actual:,.0f} | {actual / reference:,.1f} |", flush=True)


def exact() -> None:
    """What a course costs, against the trials that give its success to 0.001."""
    print("\n| exact course on chain-4 | states | ms | as many trials by a population | ms |\n|---|---|---|---|---|")
    for agent, p in (("random", 0.0), ("human-inspired", 0.0), ("human-inspired", 0.3), (SOFTMAX, 0.3)):
        course = propagate(agent, p=p)
        seconds = cpu_seconds(lambda agent=agent, p=p: propagate(agent, p=p))
        trials = max(1_000, round(course.success * (1 - course.success) / 0.001**2))
        sampled = cpu_seconds(
            lambda agent=agent, p=p, trials=trials: population(agent, p=p, trials=trials, streams="fast", threads=1)
        )
        print(f"| {agent}, p = {p:g} | {course.states} | {seconds * 1e3:.2f} | {trials:,} | {sampled * 1e3:.2f} |")


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=500_000, help="trials of a recorded population")
    asked = parser.parse_args()
    began = time.process_time()
    for agent, recorded in (("random", False), ("human-inspired", True)):
        population(agent, trials=50_000, p=0.3, streams="fast", record=recorded, threads=1)
    print(f"numba's import and what it compiles, or has compiled before: {time.process_time() - began:.1f} s\n")
    compare(asked.trials)
    exact()


if __name__ == "__main__":
    main()

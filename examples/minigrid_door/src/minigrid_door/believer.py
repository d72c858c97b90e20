"""An agent with a known answer: it knows the way, and believes what it is told of the door.

It toggles the door until it is told that it opened. Only doors that opened are lied about, so each lie costs two steps:
the toggle that closes the door, and the one that opens it again. With probability p of a lie, k of them come first with
probability p^k (1 - p). An episode that takes s steps without a lie is lost with the probability that s + 2 k exceeds
the budget: p^(1 + (BUDGET - s) // 2). Run as ``python -m minigrid_door.believer episodes.jsonl``.
"""

import sys
from collections import deque

import gymnasium
from minigrid.core.actions import Actions
from minigrid.core.constants import DIR_TO_VEC

from lockprobe.wrappers import FalseReports, Record
from minigrid_door import NAME, OPENED, outcome

BUDGET = 14
"""Steps, in which every one of the first 200 seeds is solved without a lie."""


def way(world, goal, through=()):
    """The shortest series of turns and steps after which the goal is in the cell ahead."""
    start = (*map(int, world.agent_pos), world.agent_dir)
    reached, ahead = {start: ()}, deque([start])
    while ahead:
        x, y, turned = place = ahead.popleft()
        forward = (x + int(DIR_TO_VEC[turned][0]), y + int(DIR_TO_VEC[turned][1]))
        if forward == goal:
            return reached[place]
        found = {Actions.left: (x, y, (turned - 1) % 4), Actions.right: (x, y, (turned + 1) % 4)}
        if world.grid.get(*forward) is None or forward in through:
            found[Actions.forward] = (*forward, turned)
        for action, there in found.items():
            if there not in reached:
                reached[there] = (*reached[place], action)
                ahead.append(there)
    raise ValueError("no way leads there")


def believer(world):
    """Yields actions, and is sent what is told of each."""
    cells = [(x, y) for x in range(world.width) for y in range(world.height)]
    place = {there.type: cell for cell in cells if (there := world.grid.get(*cell)) is not None}
    for action in (*way(world, place["key"]), Actions.pickup):
        yield action
    for action in way(world, place["door"]):
        yield action
    while (yield Actions.toggle) != OPENED:
        pass
    for action in (*way(world, place["goal"], through=[place["door"]]), Actions.forward):
        yield action


def main(path, seeds=range(200)):
    """Play the same seeds under three rates of false reports, and record them."""
    for p in (0, 0.2, 0.4):
        told = FalseReports(gymnasium.make(NAME, max_steps=BUDGET), p, outcome=outcome, only=OPENED)
        env = Record(told, path, agent="believer", condition=f"flip?p={p}", score=float)
        for seed in seeds:
            env.reset(seed=seed)
            agent, info, over = believer(env.unwrapped), {"told": None}, False
            while not over:
                *_, terminated, truncated, info = env.step(agent.send(info["told"]))
                over = terminated or truncated


if __name__ == "__main__":
    main(sys.argv[1])

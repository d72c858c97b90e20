"""A player with a known answer: it knows the way, and believes what it is told of the door.

It toggles the door until it is told that it opened. A true "did not open" is never told of a door that opened, so each
false one costs two steps: the toggle that closes the door, and the one that opens it again. With probability p of a
false report the number of them is geometric: 2 p / (1 - p) steps are lost in the mean, and 0.9 / 250 of the score for
each. Run as ``python -m minigrid_door.believer episodes.jsonl``.
"""

import sys
from collections import deque

import gymnasium
from minigrid.core.actions import Actions
from minigrid.core.constants import DIR_TO_VEC

from lockprobe.wrappers import FalseReports, Record
from minigrid_door import NAME, OPENED, outcome


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


def play(env, seed):
    """Play one episode."""
    env.reset(seed=seed)
    world = env.unwrapped
    cells = [(x, y) for x in range(world.width) for y in range(world.height)]
    place = {there.type: cell for cell in cells if (there := world.grid.get(*cell)) is not None}
    for action in (*way(world, place["key"]), Actions.pickup):
        env.step(action)
    for action in way(world, place["door"]):
        env.step(action)
    while env.step(Actions.toggle)[-1]["told"] != OPENED:
        pass
    for action in (*way(world, place["goal"], through=[place["door"]]), Actions.forward):
        env.step(action)


def main(path, seeds=range(100)):
    """Play the same seeds under three rates of false reports, and record them."""
    for p in (0, 0.2, 0.4):
        told = FalseReports(gymnasium.make(NAME), p, outcome=outcome, only=OPENED)
        env = Record(told, path, agent="believer", condition=f"flip?p={p}", score=float)
        for seed in seeds:
            play(env, seed)


if __name__ == "__main__":
    main(sys.argv[1])

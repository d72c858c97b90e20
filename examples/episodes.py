"""Episodes of walkers in mazes, as a table that ``lockprobe report`` reads: ``python examples/episodes.py mazes.csv``.

A walker has to find the way out of a maze of 4 x 4 rooms. Under the condition ``map`` it is now and then told the way.
A seed is where it starts and what it draws, so that both conditions share their luck. Walkers differ in how often they
do again what they did three steps ago, which is a loop.
"""

import csv
import random
import sys
from collections.abc import Iterator
from pathlib import Path

SIDE, BUDGET, BACK_TO = 4, 80, 3
MOVES = {"north": -SIDE, "east": 1, "south": SIDE, "west": -1}
BACK = {"north": "south", "east": "west", "south": "north", "west": "east"}
HABITS = {"curious": 0.1, "steady": 0.3, "stubborn": 0.6, "careful": 0.2, "hasty": 0.4}
"""Walker -> how often it does again what it did three steps ago."""


def beside(room: int, move: str) -> int:
    """The room that lies that way; the same at the edge."""
    if room % SIDE == {"east": SIDE - 1, "west": 0}.get(move, SIDE):
        return room
    there = room + MOVES[move]
    return there if 0 <= there < SIDE**2 else room


def maze(task: int) -> dict[int, str]:
    """Room -> the move that leads towards the way out, room 0; there is one way between any two rooms."""
    draw, ways = random.Random(task), {0: ""}
    while len(ways) < SIDE**2:
        room, move = draw.choice([*ways]), draw.choice([*MOVES])
        ways.setdefault(beside(room, move), BACK[move])
    return ways


def walked(ways: dict[int, str], habit: float, told: float, draw: random.Random) -> list[str]:
    """The moves of a walker until it is out, or its budget is spent."""
    room, done = draw.randrange(1, SIDE**2), list[str]()
    while room and len(done) < BUDGET:
        shown, again, move = draw.random() < told, draw.random() < habit, draw.choice([*MOVES])
        if again and len(done) >= BACK_TO:
            move = done[-BACK_TO]
        move = ways[room] if shown else move
        there = beside(room, move)
        room = there if move == ways[room] or (there != room and ways[there] == BACK[move]) else room
        done.append(move)
    return done if room == 0 else [*done, ""]


def episodes(tasks: int, seeds: int, apart: int) -> Iterator[tuple[object, ...]]:
    """A row an episode; under ``map`` the first seeds were not played, and as many others were."""
    yield "agent", "condition", "task", "seed", "solved", "steps", "actions"
    for task in range(tasks):
        ways = maze(task)
        for agent, habit in HABITS.items():
            for condition, told, first in (("plain", 0.0, 0), ("map", 0.05, apart)):
                for seed in range(first, first + seeds):
                    done = walked(ways, habit, told, random.Random(f"{task}/{seed}/{agent}"))
                    solved, done = int(done[-1] != ""), [*filter(None, done)]
                    yield agent, condition, f"maze-{task:02}", seed, solved, len(done), " ".join(done)


if __name__ == "__main__":
    with Path(sys.argv[1]).open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(episodes(*map(int, sys.argv[2:] or (12, 10, 3))))

"""A blicket detector as a text game: which two of the blocks make the machine play, and nothing else with them?

An action puts one block on the machine, or takes it off. The machine plays while both blickets are on it. The game is
solved when it plays with no other block on it.
"""

from string import ascii_uppercase, printable

import gymnasium
from gymnasium import spaces

PLAYS, SILENT = "The machine plays.", "The machine is silent."


class BlicketEnv(gymnasium.Env):
    """One machine and some blocks, named by letters; observations are texts."""

    def __init__(self, blocks=4):
        self.blocks = blocks
        self.action_space = spaces.Discrete(blocks)
        self.observation_space = spaces.Text(200, charset=printable)

    def reset(self, *, seed=None, options=None):
        """Begin with an empty machine; the blickets are hidden."""
        super().reset(seed=seed)
        self.blickets = {*self.np_random.choice(self.blocks, 2, replace=False).tolist()}
        self.on = set()
        return self.observation(), {}

    def step(self, action):
        """Put a block on the machine, or take it off."""
        self.on ^= {int(action)}
        solved = self.on == self.blickets
        return self.observation(), float(solved), solved, False, {}

    def observation(self):
        """What a player sees and hears."""
        there = ", ".join(ascii_uppercase[block] for block in sorted(self.on)) or "nothing"
        return f"On the machine: {there}. {PLAYS if self.on >= self.blickets else SILENT}"


def outcome(before, action, after):
    """What the machine did, and the opposite."""
    return (PLAYS, SILENT) if PLAYS in after else (SILENT, PLAYS)


gymnasium.register("Blicket-v0", BlicketEnv, max_episode_steps=20)

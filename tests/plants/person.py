"""A person next to a box, scripted: obeys the rules, types answers, takes drawn pictures."""

import itertools
import re

from drawn_board import HANDLES, HEIGHT, WIDTH, board
from PIL import Image

from lockprobe.plants.manual import ENTER, OperatorStopped

ASKED = re.compile(r"Move joint \w \(([\w-]+)\) from ([01]) to ([01])")


class Person:
    """Moves the joints of a box as its rules allow.

    ``slips`` are wrong answers before the right one; ``folder`` is where pictures are saved; after ``patience``
    questions the person stops.
    """

    def __init__(self, box, *, folder=None, slips=(), patience=10**6, clumsy=False):
        self.box, self.now, self.folder = box, box.initial, folder
        self.slips, self.patience, self.clumsy = list(slips), patience, clumsy
        self.questions, self.told, self._number = [], [], itertools.count()
        self._moved = False

    def ask(self, question, answers):
        self.questions.append(question)
        if len(self.questions) > self.patience:
            raise OperatorStopped("the operator stopped")
        if found := ASKED.search(question):
            joint = self.box.names.index(found[1])
            assert int(found[2]) == self.now[joint] != int(found[3])
            self.now, self._moved = self.box.attempt(self.now, joint)
            if self.clumsy:
                self.now = tuple(at != (i == (joint + 1) % len(self.now)) for i, at in enumerate(self.now))
        if self.folder is not None:
            self.photograph()
        if answers == (ENTER,):
            return ENTER
        return self.slips.pop() if self.slips else "y" if self._moved else "n"

    def tell(self, line):
        self.told.append(line)

    def photograph(self):
        number = next(self._number)
        Image.fromarray(board(self.now, number)).save(self.folder / f"{number:03}.png")


def handles_text(box):
    lines = [f"width = {WIDTH}", f"height = {HEIGHT}"]
    for name, (zero, one) in zip(box.names, HANDLES, strict=False):
        lines += [f"[{name}]", f"at_0 = {list(zero)}", f"at_1 = {list(one)}"]
    return "\n".join(lines)

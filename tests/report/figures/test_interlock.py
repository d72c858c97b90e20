"""The drawing of an interlock says what the interlock says, and nothing lies on anything else."""

import itertools
from collections import Counter

from boxes.conftest import any_box
from hypothesis import given, settings
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch

from lockprobe.report.figures.interlock import diagram_of, draw_interlock, short_name

NEAR = 1e-6


class Drawing:
    """What stands on the paper: boxes by text, level and upright lines, arrows, marks (x, y, filled)."""

    def __init__(self, drawn):
        width, height = diagram_of(drawn).size
        axes = Figure().add_axes((0, 0, 1, 1))
        axes.set(xlim=(0, width), ylim=(0, height))
        draw_interlock(axes, drawn)
        frames = [patch.get_bbox() for patch in axes.patches if isinstance(patch, FancyBboxPatch)]
        self.boxes = {}
        for text in axes.texts:
            (inside,) = [frame for frame in frames if frame.contains(*text.get_position())]
            self.boxes[text.get_text()] = inside
        segments = [tuple(zip(*line.get_data(), strict=True)) for line in axes.lines]
        self.level = [segment for segment in segments if segment[0][0] != segment[1][0]]
        self.upright = [segment for segment in segments if segment[0][0] == segment[1][0]]
        self.arrows = [patch._posA_posB for patch in axes.patches if isinstance(patch, FancyArrowPatch)]
        circles = [patch for patch in axes.patches if isinstance(patch, Circle)]
        self.marks = [(*circle.center, circle.get_facecolor()[:3] != (1, 1, 1)) for circle in circles]

    def joint_at(self, x, y):
        """The joint at whose left or right edge a line ends."""
        (name,) = [
            name
            for name, frame in self.boxes.items()
            if frame.y0 < y < frame.y1 and min(abs(frame.x0 - x), abs(frame.x1 - x)) < NEAR
        ]
        return name

    def alternatives(self):
        """Joint -> its alternatives, read off lines and marks."""
        found = {name: Counter() for name in self.boxes}
        for (x, y), end in self.arrows:
            (upright,) = [s for s in self.upright if abs(s[0][0] - x) < NEAR and s[0][1] - NEAR <= y <= s[1][1] + NEAR]
            needs = set()
            for at, height, filled in self.marks:
                if abs(at - x) < NEAR and upright[0][1] - NEAR <= height <= upright[1][1] + NEAR:
                    (wire,) = [
                        s
                        for s in self.level
                        if abs(s[0][1] - height) < NEAR
                        and min(s[0][0], s[1][0]) - NEAR <= x <= max(s[0][0], s[1][0]) + NEAR
                    ]
                    needs.add((self.joint_at(*wire[0]), filled))
            found[self.joint_at(*end)][frozenset(needs)] += 1
        return found


def asked(drawn):
    """A joint with an empty clause is always free, whatever its other clauses say."""
    clauses = {name: drawn.interlock.get(name, ()) for name in drawn.names}
    return {
        short_name(joint): Counter(
            frozenset((short_name(other), position) for other, position in clause.items())
            for clause in found
            if all(found)
        )
        for joint, found in clauses.items()
    }


def check_room(drawing):
    """No line runs through a joint, no two level or upright lines lie on each other, no two joints do."""
    for one, other in itertools.combinations(drawing.boxes.values(), 2):
        assert one.x1 < other.x0 or other.x1 < one.x0 or one.y1 < other.y0 or other.y1 < one.y0
    level = [(min(a[0], b[0]), max(a[0], b[0]), a[1]) for a, b in [*drawing.level, *drawing.arrows]]
    for low, high, y in level:
        for frame in drawing.boxes.values():
            assert high < frame.x0 + NEAR or low > frame.x1 - NEAR or not frame.y0 < y < frame.y1
    for one, other in itertools.combinations(level, 2):
        assert abs(one[2] - other[2]) > 0.02 or one[1] < other[0] + NEAR or other[1] < one[0] + NEAR
    for (x, low), (_, high) in drawing.upright:
        for frame in drawing.boxes.values():
            assert not frame.x0 - 0.05 < x < frame.x1 + 0.05 or high < frame.y0 or low > frame.y1
    for one, other in itertools.combinations(drawing.upright, 2):
        assert abs(one[0][0] - other[0][0]) > 0.1


@settings(max_examples=50)
@given(any_box())
def test_any_drawing_says_what_the_interlock_says_and_has_room(drawn):
    drawing = Drawing(drawn)
    assert drawing.alternatives() == asked(drawn)
    check_room(drawing)

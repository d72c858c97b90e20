"""The drawing of an interlock says what the interlock says, and nothing lies on anything else."""

import itertools
from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lockprobe.lockbox.difficulty import depths
from lockprobe.lockbox.families import box, named_boxes
from lockprobe.lockbox.graph import graph_of


def said(graph):
    """Joint -> its alternatives, read off the lines."""
    into = {}
    for line in graph.lines:
        into.setdefault(line.nodes[-1], []).append(line)
    found = {}
    for i, node in enumerate(graph.nodes):
        if node.kind == "joint":
            clauses = []
            for line in into.get(i, ()):
                source = graph.nodes[line.nodes[0]]
                meeting = [line] if source.kind == "joint" else into[line.nodes[0]]
                clauses.append(frozenset((graph.nodes[m.nodes[0]].name, not m.closed) for m in meeting))
            found[node.name] = Counter(clauses)
    return found


def asked(drawn):
    """A joint with an empty clause is always free, whatever its other clauses say."""
    clauses = {name: drawn.interlock.get(name, ()) for name in drawn.names}
    return {name: Counter(frozenset(c.items()) for c in found if all(found)) for name, found in clauses.items()}


@settings(max_examples=50)
@given(st.data())
def test_the_drawing_says_what_the_interlock_says(boxes, data):
    drawn = data.draw(boxes)
    assert said(graph_of(drawn)) == asked(drawn)


@pytest.mark.parametrize("name", [*named_boxes(), "random-8-3", "random-8-7", "random-7-1"])
def test_named_boxes_are_drawn_as_they_are(name):
    drawn = box(name)
    graph, layers = graph_of(drawn), depths(drawn)
    assert said(graph) == asked(drawn)
    columns = {node.name: node.column for node in graph.nodes if node.kind == "joint"}
    assert columns == {joint: 2 * layer for joint, layer in layers.items()}
    assert all((node.column % 2 == 0) == (node.kind == "joint") for node in graph.nodes if node.kind != "bend")


@settings(max_examples=50)
@given(st.data())
def test_nothing_lies_on_anything_else(boxes, data):
    graph = graph_of(data.draw(boxes))
    half = {"joint": 0.2, "all": 0.1, "bend": 0.05}
    columns = {}
    for node in graph.nodes:
        columns.setdefault(node.column, []).append(node)
    for nodes in columns.values():
        for a, b in itertools.combinations(nodes, 2):
            assert abs(a.height - b.height) >= half[a.kind] + half[b.kind]


def test_chains_are_straight():
    for name in ("chain-2", "chain-8"):
        graph = graph_of(box(name))
        assert {round(node.height, 6) for node in graph.nodes} == {0.0}
        assert all(line.arrow and not line.closed for line in graph.lines)


def test_the_same_box_is_drawn_the_same():
    assert graph_of(box("random-8-5")) == graph_of(box("random-8-5"))


def test_lines_pass_every_column_between_their_ends():
    """So that each can be led past the joints there."""
    for name in ("gray-code-8", "random-8-3", "bichain-8"):
        graph = graph_of(box(name))
        for line in graph.lines:
            columns = [graph.nodes[node].column for node in line.nodes]
            steps = {abs(b - a) for a, b in itertools.pairwise(columns)}
            assert steps <= {0, 1} or (len(columns) == 2 and steps == {2})

"""A box as text for terminals: its panel and its interlock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from lockprobe.boxes.box import Lockbox

_WIDE, _ROW = 60, 0.1
"""Width of the panel in characters; a joint that lies farther below the one above, in heights, is in another row."""

_SYMBOLS = {"prismatic": ("[#-]", "[-#]", "[? ]"), "revolute": ("(|) ", "(-) ", "(?) ")}
"""Symbols of a closed joint, an open joint, and a joint whose position is not told."""


def panel_lines(
    box: Lockbox, *, labels: Sequence[str] | None = None, positions: Sequence[bool | None] | None = None
) -> list[str]:
    """The panel with a label under each joint; a star marks the target.

    Labels and positions are in panel order; by default numbers from 1, and the start. A position that is not told is
    None.
    """
    names = labels or [str(i + 1) for i in range(len(box.joints))]
    drawn = box.initial if positions is None else positions
    inside = list[str]()
    for row in in_rows([joint.place for joint in box.joints]):
        symbols, under = "", ""
        for i in row:  # overlapping symbols move to the right
            joint, position = box.joints[i], drawn[i]
            at = max(len(symbols) + 1, round(joint.place[0] * _WIDE) - 2)
            symbols = symbols.ljust(at) + _SYMBOLS[joint.kind][2 if position is None else position]
            under = under.ljust(at) + f" {names[i]}" + ("*" if joint.name == box.target else "")
        inside += [f"|{line:{_WIDE}}|" for line in (symbols, under)]
    unknown = ", not told [? ] (?)" if None in drawn else ""
    legend = f"closed [#-] (|), open [-#] (-){unknown}; * the target"
    edge = f"+{'-' * _WIDE}+"
    return [edge, *inside, edge, legend]


def reading_order(box: Lockbox) -> list[int]:
    """The joints, by index in panel order, as the panel shows them: row by row, each from left to right."""
    return [i for row in in_rows([joint.place for joint in box.joints]) for i in row]


def in_rows(places: Sequence[tuple[float, float]]) -> list[list[int]]:
    """The numbers of places on the panel, row by row from the top, each row from the left."""
    rows: list[list[int]] = []
    for i in sorted(range(len(places)), key=lambda i: -places[i][1]):
        if rows and places[rows[-1][-1]][1] - places[i][1] <= _ROW:
            rows[-1].append(i)
        else:
            rows.append([i])
    return [sorted(row, key=places.__getitem__) for row in rows]


def interlock_lines(box: Lockbox, called: Mapping[str, str] | None = None) -> list[str]:
    """The positions that each joint needs, the target first; joints by their names, or as they are ``called``."""
    lines, called = [], called or dict(zip(box.names, box.names, strict=True))
    for name in sorted(box.names, key=lambda name: name != box.target):
        ways = [
            " and ".join(f"{called[other]} {'open' if position else 'closed'}" for other, position in clause.items())
            for clause in box.alternatives(name)
        ]
        lines.append(f"{called[name]}{' (target)' * (name == box.target)}: {', or '.join(ways) or 'always free'}")
    return lines

"""The answer of a study in sentences, made from its rows: what changed success, for whom, and what is not decided."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from lockprobe.foundation.formatting import capital, listed, percent
from lockprobe.foundation.spec import PEOPLE
from lockprobe.report.prose import cause, who
from lockprobe.report.rows import Results
from lockprobe.report.rows.primary import Line, primary_lines

ONE_LOOK = "The answer holds for one look: it stands here when all planned trials are played."
"""What is said where the answer rests on tests that do not hold at every look."""

_NARROW = 10
"""Points up to which a change that is not excluded need not be said, and half the width of an interval that would
decide whether one is small; chosen by eye."""

_DOES = {"solves more": ("raise", "raises"), "solves fewer": ("lower", "lowers")}
"""Verdict -> what was done to the success of these agents, by several things and by one."""


def answer(found: Results) -> str:
    """What was found; a question of its own (why, modalities, many factors) has its sentences in its file."""
    lines = primary_lines(found)
    own = [line for line in lines if not line.baseline] or lines
    if not own:
        return "No trial has ended yet."
    if found.design.contrasts and any(line.cause for line in own):
        return headline(own, own[0].cause, several=False)
    if found.several_p:
        return headline(own, "false reports") or solved_said(found, own)
    axes = [axis for axis in found.design.axes if not axis.of_flips]
    if axes and any(line.under.startswith(f"at {axes[0].name} ") for line in own):
        return headline(own, cause(axes[0].axis)) or solved_said(found, own)
    said = conditions_said(own, other=bool(found.fact("overview", "changed_nothing")))
    return said or solved_said(found, own)


def headline(lines: Sequence[Line], causes: str, *, several: bool = True, named: bool = True) -> str:
    """What was found, in one sentence that serves one agent and thirty; empty if nothing was compared.

    ``causes`` may change their success (false reports), which is a plural if ``several``; ``named`` is whether it says
    whose success it is, which a heading may have said.
    """
    of = {said: [line.label for line in lines if line.verdict == said] for said in (*_DOES, "not detected")}
    more, fewer, hidden = of.values()
    if not (more or fewer):
        what = f" of {causes} on {_whose(hidden)}" if named and hidden else ""
        return f"No effect{what} was detected{_open(lines)}." if hidden else ""
    raise_, lower = (_DOES[verdict][not several] for verdict in _DOES)
    changed = [f"{raise_} {_whose(more)}"] if more else []
    changed += [f"{lower} {_whose(fewer, 'that' if more else '')}"] if fewer else []
    rest = f"; no effect on {_whose(hidden, 'that')} was detected" if hidden else ""
    said = f"{' and '.join(changed)}{rest}" if named else f"{raise_ if more else lower} success"
    return f"{capital(causes)} {said}."


def conditions_said(lines: Sequence[Line], *, other: bool = False) -> str:
    """The same for single conditions, of which a line has the clearest; empty if nothing was compared.

    ``other`` says that there are conditions besides, in which nothing was changed.
    """
    done: dict[tuple[str, str], list[str]] = {}
    for line in lines:
        if line.verdict in _DOES:
            done.setdefault((line.conditions[-1], line.verdict), []).append(line.label)
    hidden = [line for line in lines if line.verdict == "not detected"]
    names, any_ = {line.conditions[-1] for line in hidden}, f"any {'other ' * other}condition"
    if not done:
        alone = len(names) == 1 and all(line.change.corrected_for <= 1 for line in hidden if line.change)
        return headline(lines, names.pop() if alone else any_)
    said = [f"{condition} {_DOES[did][1]} {_whose(agents)}" for (condition, did), agents in done.items()]
    whose = _whose([line.label for line in hidden], "that") if hidden else ""
    return f"{capital('; '.join(said))}{f'; no effect of {any_} on {whose} was detected' * bool(hidden)}."


def solved_said(found: Results, lines: Sequence[Line]) -> str:
    """Who solved how much where nothing was compared; of several agents, who solved the most; trials that broke."""
    shares = [(line.first.value, line) for line in lines if line.first and line.first.value is not None]
    if not shares:
        return "No trial has ended yet."
    most = max(share for share, _ in shares)
    best = [line for share, line in shares if share == most]
    sizes = sorted({line.first.n or 0 for line in best if line.first})
    of = f"{percent(most)} of {sizes[0]}{f' to {sizes[-1]}' if len(sizes) > 1 else ''} trials"
    broke = sum(int(row.value or 0) for _, line in shares for row in found.where("broken", **line.of_first, of=""))
    rest = f" {broke} trials broke and are in no share." * bool(broke)
    if len(shares) == 1:
        alike = " under every condition: it plays alike whatever it is told" * best[0].alike
        ends = [found.get("success", **best[0].of_first, of=part) for part in ("at least", "at most")]
        between = " and ".join(percent(row.value) for row in ends if row)
        rest = f"; {broke} more broke, so of all trials it is between {between}" * bool(broke)
        return f"{capital(who(best[0].label)) if best[0].agent == PEOPLE else best[0].label} solved {of}{alike}{rest}."
    if len(best) == len(shares):
        return f"The {len(shares)} agents solved the same share: {of}.{rest}"
    return f"Of {len(shares)} agents {listed([line.label for line in best], named=3)} solved the most: {of}.{rest}"


def needed_said(lines: Sequence[Line]) -> str:
    """How many trials narrow the widest interval of an undetected change to 10 points; empty if none has to."""
    open_ = [
        (math.ceil(row.n * ((row.high - row.low) * 100 / 2 / _NARROW) ** 2), row.n, line.label)
        for line in lines
        if not line.baseline and line.verdict == "not detected" and (row := line.change) and row.n
        if row.low is not None and row.high is not None and row.low > -1 and row.high < 1
    ]
    if not open_ or (largest := max(open_))[0] <= largest[1]:
        return ""
    unit = int(10.0 ** max(len(str(largest[0])) - 2, 0))
    return (
        f"Estimating the change of {largest[2]} to ±{_NARROW} points takes about {-(-largest[0] // unit) * unit} "
        f"trials under each condition; it has {largest[1]}."
    )


def not_excluded(lines: Iterable[Line]) -> int:
    """The largest change in points that intervals of undetected changes hold; 0 without any."""
    rows = [line.change for line in lines if line.change and line.verdict == "not detected"]
    return round(100 * max((abs(end) for row in rows for end in (row.low, row.high) if end is not None), default=0.0))


def _open(lines: Iterable[Line]) -> str:
    most = not_excluded(lines)
    return f"; changes of up to {most} points are not excluded" * (most > _NARROW)


def _whose(labels: Sequence[str], what: str = "") -> str:
    """The success of agents, by name as long as these are two."""
    agents = listed([who(label) for label in labels]) if len(labels) < 3 else f"{len(labels)} agents"
    return f"{what or 'the success'} of {agents}"


def broken_said(found: Results) -> str:
    """That all trials of some agents ended as an error; empty without any."""
    solved = {row.agent for row in found.where("success", of="") if row.n}
    broken: dict[str, int] = {}
    for row in found.where("broken", of=""):
        if row.condition and row.value and row.agent not in solved:
            broken[row.agent] = broken.get(row.agent, 0) + int(row.value)
    if not broken:
        return ""
    which = f"All {sum(broken.values())} trials" if sum(broken.values()) > 1 else "The only trial"
    return f"{which} of {listed([*map(who, broken)], named=3)} ended as an error."

"""A section of the report: of how many attempts agents were told nothing, under every condition."""

from latecomer.untold import untold
from lockprobe.report.rows import Finding
from lockprobe.report.section import Caption, Figure, Part, Section, Table

NAME, SHARE = "latecomer.silence", "latecomer.untold_share"


def rows(study):
    """The share of attempts without a report, one row for each agent and condition, and the answer."""
    shares = {}
    for cell in study.cells:
        told = [share for trial in cell.trials if (share := untold(trial)) is not None]
        if told:
            shares[cell.agent, cell.condition] = sum(told) / len(told)
            yield cell.estimate(SHARE, sum(told) / len(told), n=len(told))
    if shares:
        (agent, condition), most = max(shares.items(), key=lambda pair: pair[1])
        said = f"Most attempts without a report: {100 * most:.0f} % ({agent}, {condition})."
        yield Finding(section=NAME, kind="answer", text=said, rests_on=(SHARE,), judges=False)


def table(found):
    """The same as text."""
    head = ["agent", "condition", "trials", "attempts without a report"]
    rows = found.where(SHARE)
    return [head] + [[row.agent, row.condition, str(row.n), f"{100 * row.value:.0f} %"] for row in rows]


def applies(found):
    """Whether there are numbers."""
    return bool(found.where(SHARE))


def draw(found):
    """A bar for each agent and condition."""
    from matplotlib import figure

    rows = found.where(SHARE)
    drawn = figure.Figure(figsize=(5, 0.4 + 0.3 * len(rows)), layout="constrained")
    axes = drawn.subplots()
    axes.barh([f"{row.agent}, {row.condition}" for row in rows], [100 * row.value for row in rows])
    axes.set_xlabel("attempts without a report, %")
    return drawn


CAPTION = Caption("Share of attempts of which nothing was told, mean over trials.")
BARS = Figure(NAME, "Attempts without a report, one bar each", CAPTION, "latecomer.silence:draw", applies)
SHARES = Table(f"{NAME}-by-condition", table)


def show(found):
    """The part of the page, where there are numbers."""
    if applies(found):
        yield Part("Attempts without a report", found.answer_of(NAME), [BARS, SHARES])


ITS = {"rows": rows, "show": show, "tables": (SHARES,), "figures": (BARS,), "after": "speed"}
SECTION = Section(name=NAME, title="Attempts without a report", **ITS)

"""Known parameters and known models are found again, and findings are true. benchmarks/README.md has full figures."""

from functools import partial
from pathlib import Path

import pytest
from benchmarked import benchmark

from lockprobe.foundation.parallel import THIS_PROCESS

PAGE = Path(__file__).parents[3] / "benchmarks" / "README.md"
RECOVERY, KNOWN = benchmark("recovery"), benchmark("known_agents")
SMALL = partial(RECOVERY.Study, p=(0.0, 0.3, 0.6), repetitions=2)
TRUTH = {"target": 1.0, "failure": 2.0, "stay": -1.0, "decay": 0.8, "reset": 0.5}
AGENTS = {
    **{name: KNOWN.MODELS[name] for name in ("random", "human-inspired", "random-map")},
    "softmax-memory": KNOWN.softmax_memory(
        {"target": 1.5, "closed": 0.5, "failure": 3, "recent": 1, "stay": -1.5, "position": 1.2, "decay": 0.9}
    ),
}


def rows(printed):
    """The rows of the table: the first cell of each -> the others."""
    cells = [line.strip("| ").split(" | ") for line in printed.splitlines()[2:] if line.startswith("| ")]
    return {first: others for first, *others in cells}


def test_the_true_model_wins(monkeypatch, capsys):
    """At least 3 of 4 small studies; by the full figures 95 % and more win."""
    monkeypatch.setattr(RECOVERY, "Study", SMALL)
    monkeypatch.setattr(RECOVERY, "MODELS", AGENTS)
    RECOVERY.model_table(1, THIS_PROCESS)
    printed = capsys.readouterr().out
    found = rows(printed)
    assert list(found) == [f"`{name}`" for name in AGENTS]
    assert [agent for *_, agent in found.values()] == [f"`{agent}`" for agent in AGENTS.values()]
    assert [bic for bic, *_ in found.values()].count("100 %") >= 3
    assert all((bic == "100 %") == (others == RECOVERY.NONE) for bic, others, *_ in found.values())
    assert "1 studies of the faint agent: by BIC `no-repeat` 1; by AICc `" in printed


def test_parameters_are_found_and_intervals_hold_them():
    """32 intervals: 0.95 less three Monte Carlo errors, were they independent, is 0.83."""
    studies = [SMALL(agent=KNOWN.softmax_memory(TRUTH), seed=seed) for seed in range(21, 25)]
    found = RECOVERY.recovered(TRUTH, [RECOVERY.fitted_parameters(study) for study in studies])
    assert {one.name: one.truth for one in found} == dict.fromkeys(("closed", "recent", "position"), 0.0) | TRUTH
    assert sum(one.covered for one in found) / len(found) >= 0.83
    for one in found:
        assert abs(one.median - one.truth) < 4 * 1.25 * one.spread / 4**0.5


def test_what_findings_claim_is_held_against_the_truth(monkeypatch, capsys):
    names = ("prefers labels, never repeats", "all joints once, then stays", "failure memory")
    monkeypatch.setattr(RECOVERY, "Study", SMALL)
    monkeypatch.setattr(RECOVERY, "WORLDS", {name: KNOWN.WORLDS[name] for name in names})
    RECOVERY.finding_table(1, THIS_PROCESS)
    printed, none = capsys.readouterr(), RECOVERY.NONE
    labels, stays, memory = (rows(printed.out)[name] for name in names)
    assert labels == ["`softmax-memory` 1", "1", "`recent -` 1", none]
    assert stays == ["`random-map` 1", "1", none, none]
    assert memory == ["`failure-memory` 1", "1", "`failure -` 1, `reports +` 1", none]
    assert "heed reports or failures in 0 of 2 (" in printed.out
    assert "any kind is made about them in 0 of 2 (" in printed.out
    assert "are said to heed reports in 1 of 1 (" in printed.out
    assert "failure memory: 1 of 1 studies" in printed.err


@pytest.mark.parametrize(
    ("pulls", "false"), [({"failure": None}, ["reports +"]), ({"reports": 1, "failure": 1}, ["failure -"])]
)
def test_a_claim_against_the_truth_is_counted(pulls, false):
    """Of one agent, said to heed nothing, or to return to what failed."""
    found = RECOVERY.claims(SMALL(agent=KNOWN.MODELS["failure-memory"], pulls=pulls, seed=31))
    assert sorted(found.made) == ["failure -", "reports +"]
    assert found.false == false


def test_every_seed_plays_another_study():
    first, second = (SMALL(agent="random", trials=3, seed=seed).play() for seed in (4, 5))
    assert len(first) == 3 * 2 * 3
    assert {spec for trial in first for spec in trial.specs} == {"flip?p=0.3", "flip?p=0.6"}
    assert [[step.joint for step in trial.steps] for trial in first] != [
        [step.joint for step in trial.steps] for trial in second
    ]


def test_the_page_shows_these_agents():
    page = PAGE.read_text("utf-8")
    table = rows(page[page.index("| parameter | forgetful") :].split("\n\n")[0])
    for name, cells in table.items():
        truths = [float(cell.split(":")[0].replace("\N{MINUS SIGN}", "-")) for cell in cells]
        assert truths == [truth[name.strip("`")] for truth in KNOWN.PARAMETERS.values()]
    models = rows(page[page.index("| truth | found") :].split("\n\n")[0])
    assert {name: agent for name, (*_, agent) in models.items()} == {
        f"`{n}`": f"`{a}`" for n, a in KNOWN.MODELS.items()
    }
    assert all(f"\n| {name} | `" in page for name in KNOWN.WORLDS)

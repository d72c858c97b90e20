"""``lockprobe audit``, as typed."""

import json
from functools import cache, partial

import pytest
from typed import typed

from lockprobe.report.prose.hypothesis_tests import QUESTIONS
from lockprobe.simulation.montecarlo.interval_rates import interval_rates
from lockprobe.simulation.montecarlo.verdicts import verdict_rates


def test_an_audit_in_words():
    done = typed("audit", "--studies", 4, "--world", "loops-irrelevant", "--world", "loop-trapped", "--workers", 1)
    assert done.returncode == 0, done.stderr
    said = " ".join(done.stdout.split())
    for question in QUESTIONS.values():
        assert question in said
    assert "loops-irrelevant !" in said
    assert "Every recommended test (*) rejects in at most 5 %" in said
    assert "\x1b" not in done.stdout


def test_an_audit_as_json_is_the_same_again_and_a_world_named_twice_is_one():
    done = typed("audit", "--studies", 2, "--world", "no-effect", "--seed", 7, "--workers", 1, "--json")
    found = json.loads(done.stdout)
    assert found["seed"] == 7
    assert list(found["worlds"]) == ["no-effect"]
    assert {"world", "test", "question", "truth", "studies", "rejected", "rate", "error", "valid"} <= set(
        found["rates"][0]
    )
    again = typed("audit", "--studies", 2, *("--world", "no-effect") * 2, "--seed", 7, "--workers", 2, "--json")
    assert again.stdout == done.stdout


@pytest.fixture
def few(monkeypatch):
    """Audits play fewer blocks and forks than the thousands that they take by themselves."""
    played = partial(interval_rates, agents=(("random", 0.4), ("human-inspired", 0.1)), trials=20, forked=30)
    played = cache(played)  # the same audit in words and as JSON is played once
    monkeypatch.setattr("lockprobe.simulation.montecarlo.interval_rates.interval_rates", played)
    monkeypatch.setattr("lockprobe.simulation.montecarlo.verdicts.verdict_rates", partial(verdict_rates, pool=60))


def test_an_audit_of_verdicts(few, lockprobe):
    asked = ("audit", "why", "--studies", 5, "--blocks", "30,60", "--world", "irrelevant", "--workers", 1)
    status, said, _ = lockprobe(*asked)
    assert status == 0
    rows = [line.split() for line in said.splitlines() if line.startswith("world:irrelevant")]
    assert [row[1:5] for row in rows] == [["0", "no", "change", "30"], ["0", "no", "change", "60"]]
    found = json.loads(lockprobe(*asked, "--json")[1])
    assert found["seed"] == 1
    for row, one in zip(rows, found["rates"], strict=True):
        assert (one["truth"], one["studies"], sum(one["verdicts"].values())) == ("no change", 5, 5)
        assert row[5:7] == [f"{one['right']:.3f}", f"{one['wrong']:.3f}"]
        assert one["right"] + one["wrong"] <= 1


def test_an_audit_of_one_lie_has_a_dash_where_no_study_has_an_estimate(few, lockprobe):
    asked = ("audit", "lie", "--studies", 2, "--workers", 1)
    status, said, _ = lockprobe(*asked)
    assert status == 0
    rates = json.loads(lockprobe(*asked, "--json")[1])["rates"]
    rows = [line for line in said.splitlines() if line.startswith(("random", "human-inspired"))]
    assert [(one["agent"], one["estimate"]) for one in rates] == [
        (agent, source) for agent in ("random", "human-inspired") for source in ("records", "forks")
    ]
    assert any(not one["shown"] for one in rates)  # too few trials of either outcome
    for line, one in zip(rows, rates, strict=True):
        assert line.endswith(f"{one['shown']} of 2")
        assert ("%" in line) == (one["shown"] > 0)
        assert 0 <= one["covered"] <= one["shown"] <= one["studies"] == 2


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("audit", "what"), "why, lie, or nothing"),
        (("audit", "why", "--world", "irelevant"), "did you mean 'irrelevant'?"),
        (("audit", "lie", "--world", "irrelevant"), "always audits the agents random"),
        (("audit", "--world", "no-efect"), "did you mean 'no-effect'?"),
        (("audit", "--studies", "0"), "--studies"),
    ],
)
def test_mistakes_are_one_line(arguments, message):
    done = typed(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr
    assert done.stderr.count("\n") == 1

"""Agents compared: the leaderboard with its costs, and every two agents on the same boxes."""

from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, small_study, write_study
from captions import too_long
from page_parts import part

from lockprobe.agents.llm.model_facts import Price
from lockprobe.foundation.formatting import NONE
from lockprobe.report import costs
from lockprobe.report.costs import prices_of
from lockprobe.report.opened import open_study
from lockprobe.report.pages import page_of, tables_of
from lockprobe.report.results import results_of
from lockprobe.report.rows import Estimate
from lockprobe.report.sections import agents_compared, leaderboard
from lockprobe.report.study_numbers import study_numbers
from lockprobe.report.svg import image
from lockprobe.statistics.loops import habit_baseline
from lockprobe.trial.model_call import Usage
from lockprobe.trial.record import STATES

P = (0.0, 0.4)
SOLVED = {"llm:acme/one": (9, 8), "llm:acme/two": (3, 10), "random": (2, 2), "round-robin": (10, 10)}
PRICE = Price(input=2.0, cached=0.1, output=10.0, batch=None, date="2026-01-02", source="https://acme.test/prices")
USAGE = Usage(calls=1, input_tokens=500, cached_tokens=100, output_tokens=20)
TABLES = [table for module in (leaderboard, agents_compared) for one in module.SECTIONS for table in one.tables]
ONE = {"agent": "llm:acme/one", "modality": STATES, "axis": "flip rate"}


def trials(agent, usage=USAGE):
    """Trials that are solved at once or not at all; models say what happened and cost tokens."""
    model = {"model": agent.removeprefix("llm:")} if agent.startswith("llm:") else {}
    for p, solved in zip(P, SOLVED[agent], strict=True):
        for i in range(10):
            joints = SOLUTION if i < solved else (0,) * 20
            claims = [None, *["blocked"] * (len(joints) - 1)] if model else []
            made = make_trial(joints, agent=agent, p=p, trial=i + 1, claims=claims, facts=model)
            spent = {"usage": usage, "served": f"{agent[4:]}-2026"} if model else {}
            steps = [replace(step, decision=replace(step.decision, **spent)) for step in made.steps]
            yield replace(made, steps=tuple(steps))


def opened(directory, *agents, **more):
    """A study of these agents."""
    made = [trial for agent in agents for trial in trials(agent, **more)]
    return open_study(write_study(directory / "study", small_study(agents, P, 1, 10), made))


@pytest.fixture(scope="module", autouse=True)
def priced():
    """One of the models has a price; nobody asks for an exact null of blind agents."""
    known = costs.facts_of
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(costs, "facts_of", lambda name: replace(known(name), price=PRICE if name == "acme/one" else None))
        patch.setattr(habit_baseline, "SIMULATED", 200)
        yield


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return opened(tmp_path_factory.mktemp("side"), *SOLVED)


@pytest.fixture(scope="module")
def found(study):
    return results_of(study_numbers(study))


def results(directory, *agents, **more):
    return results_of(study_numbers(opened(directory, *agents, **more)))


def table(found, name):
    head, *rows = tables_of(found, TABLES)[name]
    return [dict(zip(head, row, strict=True)) for row in rows]


def row_of_one(found, *rows):
    """The leaderboard's row of the first model, of which nothing but these numbers is known."""
    bare = found.with_rows([*found.where("trials"), *(Estimate(**ONE, **row) for row in rows)])
    return next(row for row in table(bare, "leaderboard") if row["agent"] == ONE["agent"])


def test_the_leaderboard_has_every_agent_by_success(found):
    rows = table(found, "leaderboard")
    assert [row["agent"] for row in rows] == ["round-robin", "llm:acme/one", "llm:acme/two", "random"]
    assert [row["rank"] for row in rows] == [NONE, "1 to 2", "1 to 2", NONE]
    assert [found.one("success", **ONE | {"agent": row["agent"]}).count for row in rows] == [20, 17, 13, 4]
    assert rows[1]["success"].startswith("85 % [")
    by_p = table(found, "leaderboard-by-p")[2:6]
    assert [(row["agent"], row["flip rate"]) for row in by_p] == [
        (a, p) for a in SOLVED if "llm" in a for p in ["0", "0.4"]
    ]
    assert [row["success"][:4] for row in by_p] == ["90 %", "80 %", "30 %", "100 "]
    assert by_p[3]["misread"].endswith("]")


def test_money_is_known_where_a_price_is(found):
    cost, calls = found.one("cost", **ONE).value, found.one("calls", **ONE).value
    assert (
        calls == sum(row.value for row in found.where("calls", agent=ONE["agent"], axis="", of="")) == 17 * 4 + 3 * 20
    )
    assert cost == pytest.approx(calls * (400 * 2.0 + 100 * 0.1 + 20 * 10.0) / 1e6)
    assert found.one("cost", **ONE, of="per solved trial").value == pytest.approx(cost / 17)
    assert found.one("cached_share", **ONE).value == pytest.approx(0.2)
    assert found.one("answers", **ONE, of="acme/one-2026").value == calls
    two = ONE | {"agent": "llm:acme/two"}
    assert found.one("tokens", **two, of="input").value > 0
    assert found.get("cost", **two) is None
    assert found.get("calls", **ONE | {"agent": "random"}) is None
    assert [row["US$"] for row in table(found, "leaderboard")] == [NONE, "0.13", NONE, NONE]


def test_a_report_is_made_again_at_the_prices_that_its_results_hold(found, study, monkeypatch):
    prices = prices_of(type(found).model_validate(found.plain()))
    assert prices == {"llm:acme/one": PRICE, "llm:acme/two": None, "random": None, "round-robin": None}
    monkeypatch.setattr(costs, "facts_of", lambda name: pytest.fail("looked up"))
    again = results_of(study_numbers(replace(study, prices=prices)))
    assert (again.where("cost"), again.facts) == (found.where("cost"), found.facts)


def test_prices_that_cannot_be_read_are_looked_up(found):
    edited = [one.model_copy(update={"text": "dear"}) if one.name == "input" else one for one in found.facts]
    assert list(prices_of(found.changed(facts=tuple(edited)))) == ["llm:acme/two", "random", "round-robin"]


def test_what_is_missing_is_said_or_a_dash(found):
    row = row_of_one(
        found,
        {"quantity": "rank", "low": 2, "high": 2},
        {"quantity": "success", "n": 10, "count": 5, "value": 0.5, "low": 0.4, "high": 0.6},
        {"quantity": "relative_area", "value": -0.2},
        {"quantity": "loop_rate", "value": 0.3},
        {"quantity": "loop_rate_chance", "of": "uniform", "value": 0.504},
        {"quantity": "trials_not_asked", "value": 3},
    )
    minus = "\N{MINUS SIGN}"
    assert list(row.values()) == [
        *("2", "llm:acme/one", "10", "50 % [40, 60]", "not reached", f"{minus}0.20", f"{minus}20", "not asked")
    ]
    assert list(row_of_one(found).values()) == [NONE, "llm:acme/one", "0", NONE, "not reached", *[NONE] * 3]


def test_money_is_a_lower_bound_where_some_replies_were_not_counted_and_empty_where_none_was(found):
    uncounted = {"quantity": "calls", "of": "uncounted", "value": 3}
    row = row_of_one(
        found,
        uncounted,
        {"quantity": "tokens", "of": "input", "value": 1000},
        {"quantity": "tokens", "of": "output", "value": 10},
        {"quantity": "cost", "value": 0.00001},
    )
    assert list(row.values())[-5:] == ["1000", NONE, "10", "at least 0.00001", NONE]
    assert list(row_of_one(found, uncounted).values())[-5:] == [NONE] * 5


def test_replies_that_nobody_counted_are_said_on_the_page_and_cost_nothing_that_is_known(tmp_path):
    found = results(tmp_path, "llm:acme/one", "random", usage=Usage(calls=1))
    assert found.one("calls", **ONE, of="uncounted").value == found.one("calls", **ONE).value == 128
    assert found.where("tokens") == found.where("cost") == []
    assert "128 of 128 replies have no token count" in page_of("report", found)
    assert {row["US$"] for row in table(found, "leaderboard")} == {NONE}


def test_pairs_are_compared_and_changes_with_noise(found):
    pairs = [(row.agent, row.versus, row.family) for row in found.where("played_by_one_only")]
    assert pairs == [
        ("llm:acme/one", "llm:acme/two", "agents"),
        ("llm:acme/one", "random", "agents and baselines"),
        ("llm:acme/two", "random", "agents and baselines"),
    ]
    (first, *_) = rows = table(found, "comparisons")
    assert len(rows) == 3
    assert [first[name] for name in ("agent", "pairs of trials", "success", "success of the other")] == [
        *("llm:acme/one", "20", "85 %", "65 %")
    ]
    assert len(table(found, "comparisons-by-p")) == 6
    assert [row["to flip rate"] for row in table(found, "interactions")] == ["all higher, mean", "0.4"]
    (change,) = found.where("success_change_difference", of="")
    assert (change.value, change.control) == (pytest.approx(-0.8), "truth")
    assert found.one("success_change_difference", of="any flip rate").p_value < 0.05


def test_two_that_play_alike_at_every_p_have_one_row(tmp_path):
    found = results(tmp_path, "random", "round-robin")
    assert [row["flip rate"] for row in table(found, "comparisons-by-p")] == ["every flip rate"]
    assert [row.doses for row in found.where("steps_difference", axis="")] == [{}, {"flip.p": 0.4}]


def test_the_page_shows_models_side_by_side(found):
    drawn = {"side-by-side": image(b"<svg />")}
    page, details = (page_of(name, found, drawn) for name in ("report", "details"))
    assert "Models compared" in page
    assert "No difference in success" in part(details, "agents_compared")
    assert "False reports affect the two differently" in part(details, "agents_compared")
    assert "US$ 2 per million input tokens, 0.1 cached, 10 output, as of 2026-01-02 (acme.test/prices)." in page
    assert "<code>llm:acme/two</code>: no price is known" in page
    assert "data:image/svg" in page[page.index("Pairs of agents on the same boxes") :]
    for one in (page, details):
        assert too_long(part(one, "agents_compared"), found.plain()) == []


def test_one_agent_has_nobody_beside_it(tmp_path):
    found = results(tmp_path, "llm:acme/one")
    assert found.where("played_by_one_only") == []
    assert 'id="agents_compared"' not in page_of("report", found)
    assert table(found, "comparisons") == table(found, "interactions") == []


def test_one_model_is_held_against_the_baselines(tmp_path):
    found = results(tmp_path, "llm:acme/one", "random")
    page = page_of("report", found)
    assert ">Baselines<" in page
    assert "Models compared" not in page
    assert "llm:acme/one solves the box more often than random" in part(page_of("details", found), "agents_compared")

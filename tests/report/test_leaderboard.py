"""Agents side by side in results.json, tables and page."""

import csv
import io
import json
from dataclasses import replace

import pytest
from builders import SOLUTION, make_trial, small_study, write_study
from captions import too_long

from lockprobe.agents.llm.model_facts import Price
from lockprobe.formatting import NONE
from lockprobe.model_call import Usage
from lockprobe.report import costs, write_report

P = (0.0, 0.4)
SOLVED = {"llm:acme/one": (9, 8), "llm:acme/two": (3, 10), "random": (2, 2), "round-robin": (10, 10)}


def trials(agent, solved, of=10):
    """Trials that are solved at once or not at all; models say what happened and cost tokens."""
    model = {"model": agent.removeprefix("llm:")} if agent.startswith("llm:") else {}
    for p, n in zip(P, solved, strict=True):
        for i in range(of):
            joints = SOLUTION if i < n else (0,) * 20
            claims = [None, *["blocked"] * (len(joints) - 1)] if model else []
            made = make_trial(joints, agent=agent, p=p, trial=i + 1, claims=claims, facts=model)
            usage = Usage(calls=1, input_tokens=500, cached_tokens=100, output_tokens=20) if model else None
            served = f"{agent[4:]}-2026" if model else ""
            steps = [replace(s, decision=replace(s.decision, usage=usage, served=served)) for s in made.steps]
            yield replace(made, steps=tuple(steps))


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    known = costs.facts_of
    price = Price(input=2.0, cached=1.0, output=10.0, batch=None, date="2026-01-02", source="https://acme.test/prices")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(costs, "facts_of", lambda name: replace(known(name), price=price if name == "acme/one" else None))
        study = small_study(list(SOLVED), P, 1, 10)
        made = [trial for agent, solved in SOLVED.items() for trial in trials(agent, solved)]
        path = write_study(tmp_path_factory.mktemp("side") / "study", study, made)
        write_report(path)
    return path


@pytest.fixture(scope="module")
def content(directory):
    return json.loads((directory / "results.json").read_text("utf-8"))


def table(directory, name):
    return list(csv.DictReader(io.StringIO((directory / "tables" / f"{name}.csv").read_text("utf-8"))))


def test_the_leaderboard_has_every_agent_by_success(content):
    rows = content["leaderboard"]
    assert [row["agent"] for row in rows] == ["round-robin", "llm:acme/one", "llm:acme/two", "random"]
    assert [row["success"]["count"] for row in rows] == [20, 17, 13, 4]
    assert [(row["rank_low"], row["rank_high"]) for row in rows] == [(None, None), (1, 2), (1, 2), (None, None)]
    one = rows[1]
    assert [at["success"]["count"] for at in one["by_p"]] == [9, 8]
    assert sum(at["money"]["calls"] for at in one["by_p"]) == one["money"]["calls"] == 17 * 4 + 3 * 20
    assert one["loops_above_chance"] == pytest.approx(one["loop_rate"]["value"] - one["loop_rate_chance"])


def test_money_is_known_where_a_price_is(content):
    one, two = content["leaderboard"][1:3]
    calls = one["money"]["calls"]
    assert one["money"]["dollars"] == pytest.approx(calls * (400 * 2.0 + 100 * 1.0 + 20 * 10.0) / 1e6)
    assert one["money"]["dollars_per_solved"] == pytest.approx(one["money"]["dollars"] / 17)
    assert one["money"]["cached_share"] == pytest.approx(0.2)
    assert one["prices"]["date"] == "2026-01-02"
    assert two["money"]["input_tokens"] > 0
    assert (two["money"]["dollars"], two["prices"]) == (None, None)
    assert content["leaderboard"][0]["money"]["calls"] is None


def test_who_answered_stands_with_the_facts_of_an_agent(content):
    assert content["agents"]["llm:acme/one"] == {"model": "acme/one", "answered by": "acme/one-2026"}


def test_pairs_are_compared_and_changes_with_noise(content):
    (between, *beside) = content["comparisons"]
    assert (between["second"], between["first"], between["among"]) == ("llm:acme/one", "llm:acme/two", "subjects")
    assert (between["second_success"], between["first_success"]) == (0.85, 0.65)
    assert [(row["second"], row["first"]) for row in beside] == [("llm:acme/one", "random"), ("llm:acme/two", "random")]
    (moved,) = content["interactions"]
    assert moved["at"][0]["change"]["value"] == pytest.approx(-0.8)
    assert moved["p_value"] < 0.05


def test_tables_say_the_same(directory):
    rows = table(directory, "leaderboard")
    assert [row["agent"] for row in rows] == ["round-robin", "llm:acme/one", "llm:acme/two", "random"]
    assert [row["rank"] for row in rows] == [NONE, "1 to 2", "1 to 2", NONE]
    assert rows[1]["success"].startswith("85 % [")
    assert rows[2]["US$"] == NONE
    by_p = table(directory, "leaderboard-by-p")
    assert [(row["agent"], row["p"]) for row in by_p[2:6]] == [
        (a, p) for a in SOLVED if "llm" in a for p in ("0", "0.4")
    ]
    assert by_p[5]["misread"].endswith("]")
    (first, *_) = table(directory, "comparisons")
    assert (first["agent"], first["pairs of trials"]) == ("llm:acme/one", "20")
    assert len(table(directory, "comparisons-by-p")) == 6
    assert [row["to p"] for row in table(directory, "interactions")] == ["all higher, mean", "0.4"]


def test_the_page_shows_models_side_by_side(directory):
    page = (directory / "report.html").read_text("utf-8")
    assert "Models compared" in page
    assert "No difference in success" in page
    assert "False reports affect the two differently" in page
    assert "as of 2026-01-02 (acme.test/prices)" in page
    assert "<code>llm:acme/two</code>: no price is known" in page
    assert "data:image/svg" in page[page.index("Pairs of agents on the same boxes") :]


def test_replies_that_nobody_counted_are_said_on_the_page_and_cost_nothing_that_is_known(tmp_path):
    bare = [
        replace(made, steps=tuple(replace(s, decision=replace(s.decision, usage=Usage(calls=1))) for s in made.steps))
        for made in trials("llm:acme/one", (9, 8))
    ]
    study = small_study(["llm:acme/one", "random"], P, 1, 10)
    path = write_study(tmp_path / "study", study, [*bare, *trials("random", (2, 2))])
    page = write_report(path).read_text("utf-8")
    spent = json.loads((path / "results.json").read_text("utf-8"))["leaderboard"][0]["money"]
    assert spent["uncounted_calls"] == spent["calls"] == 17 * 4 + 3 * 20
    assert (spent["input_tokens"], spent["dollars"]) == (None, None)
    assert "128 of 128 replies have no token count" in page
    assert {row["US$"] for row in table(path, "leaderboard")} == {NONE}


def test_one_agent_has_nobody_beside_it(tmp_path):
    study = small_study(["llm:acme/one"], P, 1, 10)
    path = write_study(tmp_path / "study", study, trials("llm:acme/one", (9, 8)))
    write_report(path)
    assert json.loads((path / "results.json").read_text("utf-8"))["comparisons"] == []
    assert "#side" not in (path / "report.html").read_text("utf-8")
    assert not (path / "figures" / "side-by-side.svg").exists()


def test_one_model_is_held_against_the_baselines(tmp_path):
    made = [*trials("llm:acme/one", (9, 8)), *trials("random", (2, 2))]
    path = write_study(tmp_path / "study", small_study(["llm:acme/one", "random"], P, 1, 10), made)
    write_report(path)
    page = (path / "report.html").read_text("utf-8")
    assert ">Baselines<" in page
    assert "Models compared" not in page
    assert "llm:acme/one solves the box more often than random" in page


def test_agents_that_were_not_asked_are_said_not_to_have_been(tmp_path):
    made = [replace(make_trial(SOLUTION, agent="llm:x", trial=i), assessment=False) for i in (1, 2)]
    study = replace(small_study(["llm:x"], (0.0,), 1, 2), assessment=False)
    path = write_study(tmp_path / "study", study, made)
    assert "said what its actions did: they were not asked." in write_report(path).read_text("utf-8")
    found = json.loads((path / "results.json").read_text("utf-8"))
    assert found["conditions"][0]["misinterpretation_trials_not_asked"] == 2
    assert found["conditions"][0]["misinterpretations"] is None
    assert {step["misinterpreted"] for example in found["examples"] for step in example["steps"]} == {None}
    assert table(path, "leaderboard")[0]["misread"] == "not asked"


def test_captions_are_short(directory, content):
    assert too_long((directory / "report.html").read_text("utf-8"), content) == []

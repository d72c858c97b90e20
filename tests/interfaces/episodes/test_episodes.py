"""``lockprobe report`` of anybody's episodes: what is read, what is said, and that its numbers are right."""

import csv
import io
import json
import math
import random
import time
import zipfile
from collections import defaultdict
from itertools import pairwise, permutations, product
from operator import attrgetter
from statistics import fmean

import numpy as np
import pytest
from episode_worlds import episodes, looping, made_by_example, world
from placeholders import undrawn
from scipy import stats

from lockprobe.foundation.errors import UserMistake
from lockprobe.interfaces.episodes.answers import BY_STEP, CONDITIONS, EARLY, results_of
from lockprobe.interfaces.episodes.frame import compare, sides
from lockprobe.interfaces.episodes.loops import chance
from lockprobe.interfaces.episodes.page import write_episodes
from lockprobe.interfaces.episodes.reading import read_episodes
from lockprobe.statistics.loops import onset
from lockprobe.statistics.loops.chance import chance_level


def answers(of, k=20):
    return results_of(of, k, name="x", digest="")


@pytest.fixture(scope="module")
def mazes(tmp_path_factory):
    return made_by_example(tmp_path_factory.mktemp("mazes") / "mazes.csv")


@pytest.fixture(scope="module")
def report(mazes):
    return write_episodes([mazes], "", first=20, out=mazes.parent / "out")


def bomb():
    """An archive of 300 MB, which says that it is of 10 bytes."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("header.json", bytes(300_000_000))
    return made.getvalue().replace((300_000_000).to_bytes(4, "little"), (10).to_bytes(4, "little"))


HEAD = "agent,condition,task,seed,solved,score,steps,actions\n"

WRONG = [
    (".csv", HEAD + "a,c,t,1,2,,,\n", "", "line 2, column solved: got '2', expected true or false"),
    (".csv", HEAD + "a,c,t,1,,nan,,\n", "", "line 2, column score: got 'nan', expected at most 1"),
    (".csv", HEAD + "a,c,t,1,1,,2.5,\n", "", "line 2, column steps: got '2.5', expected a whole number"),
    (".csv", HEAD + "a,c,t,1,1,,,[1\n", "", "line 2, column actions: got '[1', EOF while parsing a list at line 1 column 2"),
    (".csv", HEAD + "a,c,t,1,1,,,\na,c,t,1,0,,,\n", "", "line 3: got again the episode of line 2 (a column"),
    (".csv", HEAD + f"{'a' * 2000},c,t,1,1,,,\n", "", "aaaaaaaaa, expected at most 1000 characters"),
    (".csv", HEAD + "a,c\n", "", "line 2: got more or fewer cells than columns"),
    (".csv", HEAD, "", "got no row, expected an episode"),
    (".csv", b"agent\n\xff\xfe\n", "", "line 2: got the byte 0xff, expected text in UTF-8"),
    (".csv", 'agent\n"a\n', "", "line 2: not CSV"),
    (".csv", "agent\n" + "".join(f"{i}\n" for i in range(31)), "", "column agent: got 31 names, expected at most 30"),
    (".csv", HEAD + "a,c,t,1,1,,,\n", 'task = "level"', "x.csv is called 'level'; there are: agent, condition"),
    (".csv", HEAD, 'tusk = "level"', "is called 'tusk' (did you mean 'task'?)"),
    (".csv", HEAD, "agent = 3", "agent: got 3, expected the name of a column"),
    (".csv", HEAD, 'preset = "x"', "no preset is called 'x'"),
    (".jsonl", '{"agent": "a"}\nno\n', "", "line 2: not a JSON object"),
    (".jsonl", '{"agent": ["a"]}\n', "", "line 1, column agent: got ['a'], expected a text"),
    (".jsonl", '{"task": "t", "step": 1}\n{"task": "t", "step": 1}\n', "", "line 2: got step 1 of an episode after line 1, expected step 2"),
    (".csv", "agent,agent\na,b\n", "", "got a column twice, expected each once: agent, agent"),
    (".csv", "agent;solved\na;1\n", "", "got the columns agent;solved, expected one or more of agent, condition"),
    (".csv", "agent,actions\na," + "[" * 200_000, "", "line 2, column actions: got '[[["),
    (".jsonl", '{"agent": "\\ud800"}\n', "", "line 1: not a JSON object"),
    (".csv", "task,step\nt,4\nt,1\nt,2\n", "", "line 2: got step 4 of an episode after line 4, expected step 3"),
    (".csv", "task,step\nt,2\nt,3\n", "", "line 2: got step 2 of an episode, expected step 1"),
    (".parquet", b"PAR1 rubbish PAR1", "", "not Parquet"),
    (".eval", b"rubbish", "", "not a log of Inspect"),
    (".eval", bomb(), "", "larger than 268435456 bytes when it is unpacked"),
    (".xls", b"", "", "expected a name that ends in .csv, .jsonl, .parquet, .eval"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "content", "mapped", "said"), WRONG)
def test_a_mistake_is_one_line_with_file_line_and_column(kind, content, mapped, said, tmp_path):
    path, toml = tmp_path / f"x{kind}", tmp_path / "map.toml"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    toml.write_text(mapped)
    with pytest.raises(UserMistake) as mistake:
        read_episodes([path], str(toml) if mapped else "")
    assert said in str(mistake.value)
    assert "\n" not in str(mistake.value)


def test_a_file_of_more_rows_than_a_page_can_say_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("lockprobe.interfaces.episodes.reading.MOST_ROWS", 2)
    (tmp_path / "x.csv").write_text("agent\na\nb\nc\n")
    with pytest.raises(UserMistake, match="line 4: got more than 2 rows"):
        read_episodes([tmp_path / "x.csv"], "")
    monkeypatch.setattr("lockprobe.interfaces.episodes.reading._MOST_VALUES", 2)
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    parquet.write_table(arrow.Table.from_pylist([{"actions": ["a", "b", "c"]}]), tmp_path / "x.parquet")
    with pytest.raises(UserMistake, match="expected at most 2 rows, 2 cells"):
        read_episodes([tmp_path / "x.parquet"], "")


def test_rows_of_episodes_and_of_steps_in_every_kind_of_file_say_the_same(mazes, tmp_path):
    """Steps in any order, solved if any row says so."""
    arrow, parquet = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    rows = [row | {"actions": row["actions"].split()} for row in csv.DictReader(mazes.read_text().splitlines())]
    names = ("agent", "condition", "task", "seed")
    steps = [
        {name: row[name] for name in names} | {"step": i, "action": did, "solved": row["solved"] == "1" and i == 1}
        for row in rows for i, did in enumerate(row["actions"], 1)
    ]  # fmt: skip
    (tmp_path / "x.jsonl").write_text("\n".join(map(json.dumps, rows)))
    (tmp_path / "steps.jsonl").write_text("\n".join(map(json.dumps, sorted(steps, key=lambda row: -row["step"]))))
    parquet.write_table(arrow.Table.from_pylist(rows), tmp_path / "x.parquet")
    first, *same, of_steps = map(
        read_episodes, ([mazes], *([tmp_path / f"{x}"] for x in ("x.jsonl", "x.parquet", "steps.jsonl")))
    )
    assert [answers(of).rows for of in same] == [answers(first).rows] * 2
    every, other = ({(of.agents[a], of.conditions[c], of.tasks[t], *rest) for a, c, t, *rest in
                     zip(of.agent, of.condition, of.task, of.steps, of.actions, of.solved, strict=True)}
                    for of in (first, of_steps))  # fmt: skip
    assert every == other


def test_an_episode_of_steps_that_is_cut_off_is_no_failure_and_the_other_file_is_named(tmp_path):
    (tmp_path / "x.csv").write_text("task,step,solved\na,0,0\na,1,\nb,0,1\nb,1,\nc,0,\nc,1,0\n")
    assert str(read_episodes([tmp_path / "x.csv"], "").solved.tolist()) == "[nan, 1.0, 0.0]"
    (tmp_path / "y.csv").write_text("task,step,solved\nb,1,yes\n")
    with pytest.raises(UserMistake, match=r"y.csv: line 2: got step 1 of an episode after line 5 of .*x.csv, expected"):
        read_episodes([tmp_path / "x.csv", tmp_path / "y.csv"], "")


def test_presets_name_columns_and_a_file_can_name_its_rows(tmp_path):
    rows = "m,cot,t,0,7,0.5\nm,naive,t,0,9,1\n"
    (tmp_path / "b.csv").write_text(f"model_id,agent,task,seed,num_steps,progression\n{rows}")
    found = read_episodes([tmp_path / "b.csv"], "balrog")
    assert (found.agents, found.conditions, found.steps.tolist()) == (["m"], ["cot", "naive"], [7, 9])
    (tmp_path / "g.csv").write_text("r,l,t\n0.25,12,0.1\n1,13,0.2\n")
    (tmp_path / "m.toml").write_text('preset = "gymnasium"\nagent = "file"\n')
    found = read_episodes([tmp_path / "g.csv"], str(tmp_path / "m.toml"))
    assert (found.agents, found.score.tolist(), found.steps.tolist()) == (["g"], [0.25, 1], [12, 13])


def test_numbers_are_those_of_other_code(mazes, report):
    """Pairs by hand, Student over tasks by SciPy, O - E of risk sets step by step."""
    rows = [row | {"did": row["actions"].split()} for row in csv.DictReader(mazes.read_text().splitlines())]
    solved = {tuple(r[name] for name in ("agent", "task", "seed", "condition")): int(r["solved"]) for r in rows}
    blocks, tasks = defaultdict(list), defaultdict(list)
    for (agent, task, seed, condition), before in solved.items():
        if condition == "plain" and (after := solved.get((agent, task, seed, "map"))) is not None:
            blocks[task, seed].append(after - before)
            tasks[task].append(after - before)
    row, student = report.where(family=CONDITIONS)[0], stats.ttest_1samp([fmean(own) for own in tasks.values()], 0)
    sums, ends = np.array([sum(own) for own in blocks.values()]), student.confidence_interval()
    assert (row.n, row.clusters) == (sum(map(len, blocks.values())), len(blocks))
    assert row.value == pytest.approx(fmean(map(fmean, tasks.values())))
    assert (row.low <= ends.low + 1e-9, row.high >= ends.high - 1e-9) == (True, True)
    flips = np.random.default_rng(1).choice([-1, 1], (40_000, len(blocks))) @ sums
    assert row.p_value == pytest.approx(max(np.mean(np.abs(flips) >= abs(sums.sum())), student.pvalue), abs=3e-3)
    for agent, condition in product({r["agent"] for r in rows}, ("plain", "map")):
        own = [r for r in rows if (r["agent"], r["condition"]) == (agent, condition)]
        share = report.one("success", agent=agent, condition=condition)
        assert (share.count, share.n) == (sum(r["solved"] == "1" for r in own), len(own))
        reach = [r for r in own if len(r["did"]) >= 20]
        loops = [0 < onset(r["did"]) <= 20 for r in reach]
        assert report.one("loop_rate", agent=agent, condition=condition, of="first 20").count == sum(loops)
        if len({*loops}) == 2:
            ends = [[r["solved"] == "1" for r, did in zip(reach, loops, strict=True) if did == side] for side in (1, 0)]
            gap = report.one("loop_success", agent=agent, condition=condition, of=EARLY).value
            assert gap == pytest.approx(fmean(ends[0]) - fmean(ends[1]))
        counts = np.zeros(4)  # solved after a loop, expected so, solved without, expected so
        for step in range(1, 81):
            at_risk = [r for r in own if len(r["did"]) >= step]
            running = [(0 < onset(r["did"]) < step, r["solved"] == "1" and len(r["did"]) == step) for r in at_risk]
            share = sum(event for _, event in running) / max(1, len(running))
            for i, side in enumerate((True, False)):
                inside = [event for looped, event in running if looped == side]
                counts[2 * i : 2 * i + 2] += sum(inside), share * len(inside)
        ratio = report.one("loop_success", agent=agent, condition=condition, of=BY_STEP).value
        assert ratio == pytest.approx(counts[0] / counts[1] / (counts[2] / counts[3]), rel=1e-6) or ratio is None


@pytest.mark.parametrize("tasks", [1, 8])
def test_scores_have_the_interval_and_the_p_value_of_one_method(tasks):
    """Small differences, as of rewards: Student over pairs, and over tasks; without pairs of one task Welch's."""
    rng, n = np.random.default_rng(7), 240
    base = rng.random(n) / 10
    score = np.r_[base, base - 0.0017 + 0.002 * rng.standard_normal(n)].clip(0, 1)
    c, at = np.repeat([0, 1], n), np.tile(np.arange(n), 2)
    apart = score[n:] - score[:n]
    for seeds in (at // tasks, np.full(2 * n, -1)):
        of = episodes(np.zeros(2 * n), c, at % tasks, seeds, np.full(2 * n, np.nan), score=score)
        row = next(row for row in answers(of).rows if row.family == f"{CONDITIONS}, score")
        means = [apart[np.arange(n) % tasks == t].mean() for t in range(tasks)]
        samples = [apart] * int(seeds[0] >= 0) + [means] * (tasks > 1)
        tests = [stats.ttest_1samp(one, 0) for one in samples]
        tests = tests or [stats.ttest_ind(score[n:], score[:n], equal_var=False)]
        ends, near = [one.confidence_interval() for one in tests], 1e-6 if samples else 0.02
        assert row.value == pytest.approx(apart.mean(), abs=1e-9)
        assert row.low == pytest.approx(min(one.low for one in ends), rel=near)
        assert row.high == pytest.approx(max(one.high for one in ends), rel=near)
        assert row.p_value == pytest.approx(max(one.pvalue for one in tests), rel=near)
        assert row.detected == (len(samples) > 0)


def test_chance_is_that_of_all_orders_and_of_all_chains():
    own = "ABABCABCAB"[:8]
    orders = fmean(onset(one) > 0 for one in permutations(own))
    after = {one: [b for a, b in pairwise(own) if a == one] for one in own}

    def chained(done):
        if len(done) == len(own):
            return float(onset(done) > 0)
        return fmean(chained(done + one) for one in after[done[-1]])

    assert chance([own], "permutation", 3)[0] == pytest.approx(orders, abs=0.015)
    assert chance([own], "Markov", 3)[0] == pytest.approx(chained(own[0]), abs=0.015)
    assert chance([own], "uniform", 3)[0] == chance_level(8, 3).probability


def test_length_confounds_loops_and_equal_length_does_not():
    """Whole episodes tie loops to failure where nothing does; a tie that is there is found by risk sets."""
    free, bound = (looping(np.random.default_rng(3), 1500, trap=trap) for trap in (0.0, 0.7))
    found, tied = answers(free), answers(bound)
    rate = {of: found.one("loop_rate", agent="", condition="", of=of).value for of in
            ("whole, unsolved", "whole, solved", "first 20, unsolved", "first 20, solved")}  # fmt: skip
    assert rate["whole, unsolved"] - rate["whole, solved"] > 0.2
    assert abs(rate["first 20, unsolved"] - rate["first 20, solved"]) < 0.1
    by_step = [of.one("loop_success", agent="agent 0", condition="condition 0", of=BY_STEP) for of in (found, tied)]
    assert by_step[0].p_value > 0.05 > by_step[1].p_value
    assert by_step[1].value < 0.8


@pytest.mark.parametrize(("tasks", "agents", "enough"), [(7, 1, 7), (9, 3, 10), (10, 3, 10), (10, 5, 11)])
def test_a_test_that_could_never_reject_has_no_p_value_and_says_how_many_tasks_it_takes(tasks, agents, enough):
    a, c, t, s = (of.ravel() for of in np.meshgrid(range(agents), range(2), range(tasks), range(20), indexing="ij"))
    solved = (s < 1) | (c == 1) & (s < 19)
    row = answers(episodes(a, c, t, s, solved, steps=np.where(solved, 20, 40))).where("hazard_ratio")[0]
    few = f"Too few tasks for {agents} comparisons: it takes {enough} or more" * (tasks < enough)
    assert (row.note, row.p_value is not None and row.p_value < 0.05) == (few, not few)


def test_two_thousand_episodes_of_a_hundred_steps_are_quick_whatever_their_actions():
    draw, began = np.random.default_rng(0), time.process_time()
    for actions in (4, 5000):
        did = [tuple(map(str, row)) for row in draw.integers(0, actions, (1000, 100))]
        at, solved = np.arange(1000), draw.random(1000) < 0.5
        of = episodes(0 * at, at % 2, at % 10, at, solved, steps=0 * at + 100, actions=did)
        assert answers(of).where("loop_rate", of="Markov")
    assert time.process_time() - began < 5


def compared(of, values=None, **how):
    own = sides(of, of.condition == 0, of.condition == 1, of.agent)
    return own.by, *compare(of, own, of.solved if values is None else values, **how)


def test_what_does_not_match_is_compared_over_tasks_and_what_has_no_end_is_bounded():
    rng = np.random.default_rng(5)
    apart = world(rng, tasks=12, seeds=10, seeded=False, effect=0.3)
    by, first, second, change = compared(apart)
    assert (by, change.clusters, change.low > 0) == ("tasks", 12, True)
    means = [apart.solved[apart.condition == c].mean() for c in (0, 1)]  # all tasks have as many
    assert (first, second, change.value) == tuple(pytest.approx(x) for x in (*means, means[1] - means[0]))
    by, *_, change = compared(episodes([0] * 60, [0, 1] * 30, [0] * 60, [-1] * 60, [0, 1] * 20 + [0, 0] * 10))
    assert (by, change.detected()) == ("episodes", True)
    whole = world(rng, tasks=6, seeds=10, effect=0.2, matched=1)
    half = np.where(rng.random(len(whole)) < 0.1, np.nan, whole.solved)
    sure, open_ = compared(whole)[-1], compared(whole, half)[-1]
    assert open_.low <= sure.value <= open_.high
    assert open_.high - open_.low > sure.high - sure.low


def test_every_task_counts_alike_however_many_pairs_it_has():
    t, s = np.repeat([0, 1, 2], [4, 20, 40]), np.arange(64)
    after = np.where(t == 0, 1, s % 2)
    by, first, second, change = compared(
        episodes([0] * 128, [0] * 64 + [1] * 64, [*t] * 2, [*s] * 2, [0] * 64 + [*after])
    )
    assert (by, first, second, change.value) == ("pairs", 0, pytest.approx(2 / 3), pytest.approx(2 / 3))


def test_every_look_claims_no_more_than_one_look_and_takes_tasks_as_blocks():
    for seed, tasks in product(range(8), (1, 12)):
        of = world(np.random.default_rng(seed), tasks=tasks, seeds=100, agents=1, effect=0.3, matched=1)
        once, ever = (compared(of, every_look=looks)[-1] for looks in (False, True))
        assert (ever.low <= once.low, ever.high >= once.high, ever.p_value >= once.p_value) == (True,) * 3
    assert (once.p_value < 0.001, ever.p_value > 0.05) == (True, True)  # of 12 tasks, however many seeds they have


def test_a_page_is_written_whatever_is_there_and_whatever_is_not(tmp_path):
    kinds = {name: lambda draw: draw.choice(["", "a", "b", "c"]) for name in ("agent", "condition", "task", "seed")}
    kinds |= {"solved": lambda draw: draw.choice([0, 1, ""]), "score": lambda draw: draw.choice([0, 1, 0.3])}
    kinds |= {"steps": lambda draw: draw.choice([0, 9, 40]), "actions": lambda draw: "xyzzy"[: draw.randrange(6)] * 9}
    for seed in range(40):
        draw = random.Random(seed)
        there = draw.sample([*kinds], draw.randrange(1, 9))
        rows = [{"episode": i} | {name: kinds[name](draw) for name in there} for i in range(draw.choice([1, 3, 80]))]
        (tmp_path / "x.jsonl").write_text("\n".join(map(json.dumps, rows)).replace("xyz", "x y z "))
        with undrawn():
            assert write_episodes([tmp_path / "x.jsonl"], "", first=8, out=tmp_path / "out").answer, seed


def test_the_page_asks_one_question_first_and_says_what_it_cannot(report, mazes, tmp_path):
    page = (mazes.parent / "out/report.html").read_text("utf-8")
    assert page.count('class="answer"') == 1
    assert report.answer in page.replace("<i>P</i>", "P").replace("&lt;", "<").replace("&nbsp;", " ")
    families = {CONDITIONS, "conditions by agent", "agents", "every look", "how soon", EARLY, BY_STEP, ""}
    assert {row.family for row in report.rows} == families
    assert "match in agent, task and seed: 320 of 480 episodes; the others count in" in page
    assert not any(said.startswith("Not asked") for said in map(attrgetter("text"), report.facts))
    there = sorted(path.name for path in (mazes.parent / "out").iterdir())
    assert there == ["figures", "report.html", "results.json", "tables"]
    (tmp_path / "x.csv").write_text("agent,score\n" + "".join(f"<b>{i % 2},{i % 3 / 2}\n" for i in range(40)))
    bare = write_episodes([tmp_path / "x.csv"], "", first=20, out=tmp_path / "out")
    page = (tmp_path / "out/report.html").read_text("utf-8")
    assert "“Not shown” is not “no”" in page
    assert "<b>0" not in page
    assert bare.facts[-1].text == (
        "Not asked, for want of values in a column: what a condition changes (condition), tasks as clusters (task), "
        "pairs of equal luck (seed), success (solved), how soon (steps), loops (actions)."
    )


def test_answers_say_of_what_they_are_in_which_unit_and_who_is_worse(tmp_path):
    sides = [(a, t, s, int(s < 4 - a)) for a in (0, 3) for t in range(7) for s in range(5 + 5 * (t < 1))]
    rows = "".join(f"{'good' if not a else 'bad'},{t},{s},{end},{end}\n" for a, t, s, end in sides)
    (tmp_path / "x.csv").write_text("agent,task,seed,solved,score\n" + rows)
    found = write_episodes([tmp_path / "x.csv"], "", first=20, out=tmp_path / "out")
    page = (tmp_path / "out/report.html").read_text("utf-8").replace("&nbsp;", " ").replace("\N{NO-BREAK SPACE}", " ")
    assert "Success: 19 % to 74 %; score: 0.186 to 0.743." in page
    for what, size in (("Success, points", "56"), ("score", "0.557")):
        assert f"{what}: a difference detected, most clearly bad below good: \N{MINUS SIGN}{size} [" in page
    assert found.where("score_difference")[0].test == "larger P of t over tasks, from five on, and t of pairs"


@pytest.mark.slow
def test_under_the_null_with_task_effects_few_sentences_are_false_and_pairs_find_more():
    """Every family at most .05, with task effects and effects of mean 0; paired against unpaired with an effect."""
    families, worlds, false = (CONDITIONS, "conditions by agent", "agents", "every look"), 400, defaultdict(int)
    power = np.zeros(2)
    for i in range(worlds):
        rng = np.random.default_rng(i)
        for name, made in (("", world(rng, tasks=10)), ("unseeded ", world(rng, tasks=10, seeded=False))):
            found = answers(made)
            for family in families:
                false[name + family] += any(row.detected for row in found.rows if row.family == family)
        real = world(rng, tasks=10, seeds=8, effect=0.12, matched=0.75)
        for j, seeded in enumerate((True, False)):
            own = real if seeded else world(np.random.default_rng(i), tasks=10, seeds=8, effect=0.12, seeded=False)
            power[j] += compared(own)[-1].detected()
    limit = worlds * 0.05 + 2.5 * math.sqrt(worlds * 0.05 * 0.95)
    assert {family: n / worlds for family, n in false.items() if n > limit} == {}
    assert power[0] > 1.1 * power[1]


@pytest.mark.slow
def test_loops_that_do_nothing_are_tied_to_failure_in_few_worlds():
    false, of = np.zeros(2), {"agent": "agent 0", "condition": "condition 0"}
    for i in range(300):
        found = answers(looping(np.random.default_rng(i), 200))
        rows = [found.get("loop_success", **of, of=part) for part in (EARLY, BY_STEP)]
        false += [row is not None and row.p_value is not None and row.p_value < 0.05 for row in rows]
    assert (false / 300 < 0.085).all(), false / 300

"""A study that stops when it is decided, against a provider that charges: killed, resumed, and in any order of arrival.

``LOCKPROBE_KILLS=30`` in the environment kills so often.
"""

import random
import signal
from collections import Counter
from functools import partial

import pytest
from killed import KILLS, ended, settled, start
from provider_server import Manner, account, counted, elsewhere, here
from stored import unanswered

from lockprobe.agents.llm.model_facts import OWN_FACTS
from lockprobe.agents.llm.settings import Access
from lockprobe.foundation.errors import BudgetReached
from lockprobe.studies.costs.call_log import read_calls
from lockprobe.studies.costs.spending import Budget, Ledger
from lockprobe.studies.decisions import answers, due
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.read_records import load
from lockprobe.studies.records.trial_rows import replaced_records
from lockprobe.studies.running.runner import Limits, run, run_study

SPEC = "llm:openai-api/fake/model"
CONNECTIONS = 10
# The provider goes through the joints in turn. A hand that always trembles is decided first, one that often does later.
CONDITIONS = ["tremble?p=1", "tremble?p=0.1"]
STUDY = {"box": "chain-3", "condition": CONDITIONS, "until": "decided", "most": 60, "max_steps": 7}
SOME = 0.05
"""A budget in US dollars that pays for some of its trials."""

PRICE = "{ input = 1, cached = 1, output = 10, date = '2026-01-02', source = 'x' }"


@pytest.fixture(autouse=True, scope="module")
def paid(tmp_path_factory):
    path = tmp_path_factory.mktemp("prices") / "models.toml"
    path.write_text(f"[[model]]\nmatch = ['openai-api/fake/model']\nmost_output = 100\nprice = {PRICE}\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(OWN_FACTS, str(path))
        patch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        yield


def planned():
    return study("flips", agent=SPEC, **STUDY)


def decided(trials):
    """What was decided, and with which block."""
    return {one.question.name: (one.verdict, one.at) for one in answers(planned(), SPEC, trials)}


def keyed(trials):
    return {trial.key: trial for trial in trials}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The trials of a run that nothing interrupts, and the number of requests that they take."""
    with here(counted) as server, pytest.MonkeyPatch.context() as patch:
        patch.setenv("FAKE_BASE_URL", server.url)
        trials = run_study(planned(), tmp_path_factory.mktemp("whole"))
        return trials, server.account()["arrived"]


def test_it_decides_one_condition_before_the_other_and_buys_it_no_longer(whole):
    trials, arrived = whole
    bought = Counter(trial.condition for trial in trials)
    (first, second), found = CONDITIONS, decided(trials)
    assert {verdict for verdict, _ in found.values()} == {"effect"}
    assert found[first][1] < found[second][1] < STUDY["most"]
    assert bought[first] < bought[second] == bought["truth"] < STUDY["most"]
    assert arrived == sum(len(trial.steps) for trial in trials)
    assert due(planned(), SPEC, trials) == []


def typed(directory):
    """Starts ``lockprobe run --until decided --budget`` in a process of its own."""
    conditions = [word for one in CONDITIONS for word in ("--condition", one)]
    size = ["--until", "decided", "--most", STUDY["most"], "--max-steps", STUDY["max_steps"], "--box", STUDY["box"]]
    asked = ["run", "flips", "--agent", SPEC, *conditions, *size, "--budget", 50, "--connections", CONNECTIONS]
    return start(*asked, "--no-report", "--out", directory)


@pytest.mark.slow
def test_killed_at_random_moments_it_decides_the_same_and_buys_nothing_twice(tmp_path, monkeypatch, whole):
    trials, asked = whole
    luck, directory, kills, lost = random.Random(11), tmp_path / "killed", 0, 0
    with elsewhere(Manner(answer="counted", median=0.006 * KILLS)) as url:
        monkeypatch.setenv("FAKE_BASE_URL", url)
        while kills < KILLS and ended(partial(typed, directory), directory, luck) == -signal.SIGKILL:
            kills += 1
            seen, replies = settled(url), sum(call.reply is not None for call in read_calls(directory))
            assert 0 <= seen["arrived"] - replies - lost <= CONNECTIONS
            lost = seen["arrived"] - replies
            there = load(directory)
            assert all(trial == keyed(trials)[trial.key] for trial in there)
        assert kills == KILLS
        assert len(there) < len(trials)
        assert typed(directory).wait() == 0
        arrived = account(url)["arrived"]
    found = load(directory)
    assert keyed(found) == keyed(trials)
    assert decided(found) == decided(trials)
    calls = [call for call in read_calls(directory) if call.reply is not None]
    assert set(Counter((call.key, call.step, call.turn) for call in calls).values()) == {1}
    assert (len(calls), arrived - lost) == (asked, asked)
    assert (len(replaced_records(directory)), unanswered(directory)) == (0, [])
    assert 0 < Ledger(read_study(directory), read_calls(directory)).total.dollars < 50
    print(f"{kills} kills, {len(found)} trials, {len(calls)} calls, {lost} on their way at a kill; {decided(found)}")


@pytest.mark.parametrize(("connections", "seed"), [(3, 2), *[(1, 1), (10, 3)] * (KILLS > 3)])
def test_it_decides_the_same_in_any_order_of_arrival_and_a_budget_ends_it(
    tmp_path, monkeypatch, whole, connections, seed
):
    trials, asked = whole
    with here(counted, Manner(median=0.002, sigma=1.5, seed=seed)) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)

        def play(dollars):
            with Journal.open(tmp_path / "d", planned()) as journal:
                journal.calls.limit(Budget(planned(), dollars))
                run(planned(), journal, limits=Limits(access=Access(connections=connections)))

        with pytest.raises(BudgetReached):
            play(SOME)
        some = load(tmp_path / "d")
        assert 0 < len(some) < len(trials)
        assert 0 < Ledger(planned(), read_calls(tmp_path / "d")).total.dollars <= SOME
        play(50)
        assert server.account()["arrived"] == asked
    found = load(tmp_path / "d")
    assert [trial.key for trial in found] != [trial.key for trial in trials]
    assert keyed(found) == keyed(trials)
    assert decided(found) == decided(trials)

"""Everything that somebody edits in a study is found, or is said to be what nobody can find."""

import asyncio
import json
import shutil
import sqlite3
from copy import deepcopy

import pytest
from builders import make_trial, play_study, write_study
from provider_server import Manner, here
from saboteur import Evidence, Sent, flipped, played_by, relabelled, reply_of
from stored import sql
from typed import in_process

from lockprobe import run_study, study
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.llm.settings import Access
from lockprobe.report.verify.verification import verify
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.running.runner import Limits
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.trial_json import trial_to_json

MODEL = "llm:openai-api/fake/model?repairs=1&temperature=0.5"
PLANNED = study("flips", agent=[MODEL, "random"], p=[0, 0.4], trials=6, repetitions=1, max_steps=9, name="small")


@pytest.fixture
def directory(once, tmp_path_factory, tmp_path):
    """The study, played against a provider that repeats reports and sometimes replies in another form; no report."""

    def play():
        played, manner = tmp_path_factory.mktemp("played") / "out", Manner(faults={"wrong schema": 0.2}, seed=3)
        with pytest.MonkeyPatch.context() as patch, here(manner=manner) as server:
            patch.setenv("FAKE_BASE_URL", server.url)
            patch.setenv("FAKE_API_KEY", "sk-private-0123456789")
            run_study(PLANNED, played, limits=Limits(access=Access(connections=1)))
        return played

    return shutil.copytree(once("sabotaged", play), tmp_path / "out")


def failing(directory, **hashes):
    return {check.name: check.failed or (check.said,) for check in verify(directory, **hashes) if not check.holds}


def test_the_study_has_what_the_edits_need(directory):
    files = Evidence(directory)
    assert all(len(files.of(MODEL, ending)) >= n for ending, n in (("solved", 2), ("budget", 2), ("error", 1)))
    assert any(len(step["decision"]["replies"]) == 2 for one in files.of(MODEL) for step in one["steps"])
    first, *others = verify(directory)
    assert all(check.holds for check in (first, *others))
    assert "of 24 trials ended as an error (reply " in first.said


def each(change, ending=None, agent=MODEL):
    """Change every record of an agent that ended so."""
    return lambda files: [change(record) for record in files.of(agent, ending)]


def first(change, ending=None):
    """Change the files by the first record that ended so."""
    return lambda files: change(files, files.of(MODEL, ending)[0])


def decisions(change, after=0):
    return each(lambda record: [change(step["decision"]) for step in record["steps"][after:]])


def calls(change):
    return lambda files: [change(call.answer) for call in files.calls]


def then(*edits):
    return lambda files: [edit(files) for edit in edits]


def errors_with_made_up_replies(files):
    """Failures as early errors, with no call after them, and another last reply."""
    for record in files.of(MODEL, "budget"):
        relabelled(record, steps=2)
        files.calls = [one for one in files.calls if one.key != record["key"] or one.answer["step"] <= 3]
        files.calls_of(record)[-1]["reply"] = record["error"]["replies"][-1] = '{"move": "A"}'


def faulty(record):
    relabelled(record)
    record["error"] = {"boundary": "model", "message": "no reply within 120 s", "step": record["error"]["step"]}


def an_error_as_a_success(files, record):
    (solved, *_) = files.of("random", "solved") or files.of(MODEL, "solved")
    played_by(record, deepcopy(solved))


def perfect(record):
    """The trial as the best player plays it."""
    plan = PLANNED.plan(MODEL, PLANNED.labelled(record["condition"]), record["repetition"], record["trial"])
    trial, _ = asyncio.run(play_timed(plan, resolve("ideal-observer").make()))
    played_by(record, json.loads(trial_to_json(trial)))


def said_so(decision):
    """Its last reply says what it decides."""
    decision["replies"][-1] = reply_of(decision)


def calls_of_these_steps(files):
    for record in files.of(MODEL):
        own = files.calls_of(record)
        for call, step in zip(own, record["steps"], strict=False):
            call |= {"step": step["step"], "turn": 1, "reply": step["decision"]["replies"][0]}
            step["decision"]["usage"] = call["usage"]
        left = {id(call) for call in own[len(record["steps"]) :]}
        files.calls = [call for call in files.calls if id(call.answer) not in left]


def calls_of_these_replies(files):
    for record in files.of(MODEL):
        own = {(call["step"], call["turn"]): call for call in files.calls_of(record)}
        for step in record["steps"][1:]:
            own[step["step"], len(step["decision"]["replies"])]["reply"] = step["decision"]["replies"][-1]


def facts(**changes):
    return each(lambda record: record["facts"].update(changes))


def sent(files, record, number):
    """A call of a trial as it is stored, by its place among them."""
    return [call for call in files.calls if call.key == record["key"]][number]


def one_more_call(files, record):
    files.calls.append(deepcopy(sent(files, record, -1)))
    files.calls[-1].answer["reply"] = '{"last_action": "moved", "hypothesis": "", "joint": "A"}'


PLACE = ("key", "agent", "condition", "repetition", "trial")


def place_of(line):
    """What names its trial in a call or a record."""
    return {name: line[name] for name in PLACE}


def of_another(agent=MODEL, **place):
    """Calls that are said to be of another agent, whose costs they then are, or of another place."""
    return lambda files: [said.update({"agent": agent} | place) for call in files.calls for said in call.said]


def of_another_agent_and_owed(files, record):
    files.drop(lambda one: one != record["key"])
    for call in files.calls:
        for said in call.said if call.key == record["key"] else ():
            said["agent"] = "llm:openai-api/fake/cheap"


def never_asked(files, record):
    sent(files, record, -1).asked = None


def without_an_outcome(files, record):
    files.calls.append(Sent(deepcopy(sent(files, record, -1).asked), None))


def a_cheaper_bound(files, record):
    files.calls_of(record)[-1].update(unanswered=1, most={"calls": 1, "input_tokens": 1, "output_tokens": 1})


def forgotten(files, record):
    mark = place_of(record) | {"step": 0, "turn": 0, "request": "", "reply": None, "error": "owed anew"}
    files.calls += [Sent(None, mark), *(deepcopy(one) for one in files.calls if one.key == record["key"])]


def dropped(*, lowered=True, calls=False):
    """Trials from the third on are dropped together with a lowered number."""

    def edit(files):
        files.settings |= {"trials": 2} if lowered else {}
        files.drop(lambda key: int(key.rpartition("=")[2]) <= 2, calls=calls)

    return edit


def left_out(agent, *, calls=False):
    def edit(files):
        files.settings["agents"].remove(agent)
        of = {record["key"] for record in files.of(agent)}
        files.drop(lambda key: key not in of, calls=calls)

    return edit


def outcomes_left_out(files):
    left_out(MODEL)(files)
    for call in files.calls:
        call.answer = None


def a_second_record(files):
    files.records.append(deepcopy(files.of("random", "budget")[0]))
    files.records[-1]["steps"][0]["decision"]["hypothesis"] = "made up"


flipped_claims = then(decisions(flipped, after=1), decisions(said_so, after=1))
perfect_replies = then(each(perfect), decisions(lambda one: one.update(replies=[reply_of(one)])))

FOUND = {
    "failures as errors": (each(relabelled, "budget"), "replies"),
    "failures as errors, replies made up": (errors_with_made_up_replies, "replies"),
    "failures as faults of the provider": (each(faulty, "budget"), "complete"),
    "an error as a success": (first(an_error_as_a_success, "error"), "replies"),
    "a perfect player with calls": (then(perfect_replies, calls_of_these_steps), "replies"),
    "flipped claims with replies": (flipped_claims, "replies"),
    "flipped claims with calls of another prompt": (then(flipped_claims, calls_of_these_replies, facts(prompt="chat 0123456789ab", picture_prompt="chat 0123456789ab")), "replies"),
    "repaired replies left out": (decisions(lambda one: one.update(replies=one["replies"][-1:])), "replies"),
    "rewritten message of an error": (first(lambda files, one: one["error"].update(message="no usable reply in 2 turns: not one JSON object"), "error"), "replies"),
    "another model": (facts(model="openai-api/fake/large"), "agents"),
    "another top_p": (facts(top_p=0.9), "replies"),
    "another schema": (facts(schema="none"), "replies"),
    "other repairs": (facts(repairs=4), "agents"),
    "a fact of one trial": (first(lambda files, one: one["facts"].update(host="http://elsewhere")), "agents"),
    "another model answered": (decisions(lambda one: one.update(served="fake-large")), "replies"),
    "cheaper calls": (calls(lambda call: call.get("reply") and call["usage"].update(output_tokens=1)), "replies"),
    "a call dropped": (first(lambda files, one: files.calls.remove(sent(files, one, -1)), "solved"), "replies"),
    "one more call": (first(one_more_call, "budget"), "replies"),
    "a call of another trial": (first(lambda files, one: [said.update(place_of(files.of(MODEL)[1])) for said in sent(files, one, 0).said]), "replies"),
    "an outcome of another trial": (first(lambda files, one: files.calls_of(one)[0].update(place_of(files.of(MODEL)[1]))), "records"),
    "calls of another agent": (of_another("llm:openai-api/fake/cheap"), "replies"),
    "calls of another agent for an owed trial": (first(of_another_agent_and_owed), "replies"),
    "calls of another condition": (of_another(condition="truth"), "replies"),
    "calls of another repetition": (of_another(repetition=2), "replies"),
    "calls of another place": (of_another(trial=1), "replies"),
    "edited calls": (calls(lambda call: call.update(reply=call["reply"] and call["reply"].replace("in turn", "I see the plan"))), "replies"),
    "a call that was never asked": (first(never_asked, "solved"), "replies"),
    "a cheaper bound": (first(a_cheaper_bound), "replies"),
    "no bound": (first(lambda files, one: files.calls_of(one)[-1].update(unanswered=1)), "replies"),
    "an outcome of another request": (first(lambda files, one: sent(files, one, 0).asked.update(request="0123456789ab")), "replies"),
    "a call of another agent when it was sent": (first(lambda files, one: sent(files, one, 0).asked.update(agent="random")), "replies"),
    "a call without an outcome": (first(without_an_outcome), "replies"),
    "replies to be forgotten": (first(forgotten, "budget"), "replies"),
    "replays without the record before": (then(first(forgotten, "budget"), first(lambda files, one: one.update(replays=1), "budget")), "replies"),
    "trials dropped": (dropped(lowered=False), "complete"),
    "trials dropped, number lowered": (dropped(), "replies"),
    "the model left out": (left_out(MODEL), "replies"),
    "the model left out, outcomes too": (outcomes_left_out, "replies"),
    "a second record": (a_second_record, "records"),
}  # fmt: skip
"""An edit with right columns -> the edit, and the check that finds it."""


@pytest.mark.parametrize("name", FOUND)
def test_an_edit_is_found(directory, name):
    edit, check = FOUND[name]
    files = Evidence(directory)
    edit(files)
    files.save()
    assert check in failing(directory), failing(directory)


ROWS = {
    "key": "'small/random/truth/rep=1/trial=99'", "agent": "'random'", "player": "'participant:aaaa01'", "condition": "'truth'",
    "repetition": "2", "trial": "7 - trial", "fork": "'lie'", "ending": "'solved'", "owed": "1", "steps": "steps + 1",
    "identity": "'0123456789ab'", "alike": "x'00'", "current": "0",
    "record": "(select record from trial where ending = 'solved')",
}  # fmt: skip
"""A column -> what somebody puts there in the row of a failure under flips."""

SAID = dict.fromkeys(["key", "record"], "its record is damaged (it is of small/")
SAID |= {"identity": "which is no trial of the study in study.json", "current": "its last record does not count"}


@pytest.mark.parametrize("column", ROWS)
def test_a_row_that_is_not_that_of_its_record_is_found(directory, column):
    (number, key), *_ = sql(
        directory, f"select id, key from trial where ending = 'budget' and condition != 'truth' and agent = '{MODEL}'"
    )
    sql(directory, f"update trial set {column} = {ROWS[column]} where id = ?", number)
    found = failing(directory)
    named = [one for places in found.values() for one in places if column == "key" or key in one]
    assert any(SAID.get(column, f"its {column} are not those of its record") in one for one in named), found


def test_a_record_that_was_replaced_cannot_count_again(tmp_path):
    """Neither the one before a fault, nor both."""
    planned = study("flips", agent="random", p=[0], trials=1, repetitions=1)
    (finished,) = play_study(planned)
    directory = write_study(tmp_path, planned, [make_trial([0], agent="random", broken="plant"), finished])
    assert failing(directory) == {}
    with pytest.raises(sqlite3.IntegrityError):
        sql(directory, "update trial set current = 1")
    sql(directory, "update trial set current = 0")
    sql(directory, "update trial set current = 1 where owed")
    assert failing(directory)["records"] == (f"study.db: {finished.key}: its last record does not count",)


def rewritten_last_reply(files):
    record = files.of(MODEL, "budget")[0]
    files.calls_of(record)[-1]["reply"] = record["steps"][-1]["decision"]["replies"][-1] = reply_of(
        record["steps"][-1]["decision"] | {"hypothesis": "made up"}
    )
    record["steps"][-1]["decision"]["hypothesis"] = "made up"


def cheaper_everywhere(files):
    record = files.of(MODEL, "solved")[0]
    for call in files.calls_of(record):
        call["usage"]["input_tokens"] = 1
    for step in record["steps"]:
        step["decision"]["usage"]["input_tokens"] = len(step["decision"]["replies"])


NOT_FOUND = {
    "calls and records made up together": rewritten_last_reply,
    "costs made up together": cheaper_everywhere,
    "the plan and all of it": dropped(calls=True),
    "an agent and all of it": left_out(MODEL, calls=True),
}


@pytest.mark.parametrize("name", NOT_FOUND)
def test_what_no_check_can_find_is_said_and_is_found_by_a_published_hash(directory, name):
    published = json.loads(in_process("status", directory, "--json").stdout)
    files = Evidence(directory)
    NOT_FOUND[name](files)
    files.save()
    assert failing(directory) == {}
    found = failing(directory, settings=published["settings_hash"], results=published["results_hash"])
    assert "results hash" in found
    assert ("settings hash" in found) == (published["settings_hash"] != read_study(directory).settings_hash)
    assert ("settings hash" in found) == (name.startswith(("the plan", "an agent")))

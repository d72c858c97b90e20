"""Everything that somebody edits in a study is found, or is said to be what nobody can find."""

import asyncio
import json
import shutil

import pytest
import typer
from provider_server import Manner, here
from saboteur import Evidence, played_by, relabelled, reply_of
from typed import typed

from lockprobe import run_study, study
from lockprobe.agents.catalogue import resolve
from lockprobe.agents.model_access import Access
from lockprobe.cli import verify as command
from lockprobe.report.opened import open_study
from lockprobe.report.parallel import one_thread
from lockprobe.report.report_files import report_files
from lockprobe.report.verify.verification import NOT_SHOWN, verify
from lockprobe.report.write import write_report
from lockprobe.studies.options.settings import read_study
from lockprobe.studies.running.runner import Limits
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.trial_json import trial_to_json

pytest.importorskip("inspect_ai")
MODEL = "llm:openai-api/fake/model?repairs=1&temperature=0.5"
PLANNED = study("flips", agent=[MODEL, "random"], p=[0, 0.4], trials=6, repetitions=1, max_steps=9, name="small")


def play(directory, seed):
    """Play the study against a provider that repeats reports and sometimes replies in another form."""
    with pytest.MonkeyPatch.context() as patch, here(manner=Manner(faults={"wrong schema": 0.2}, seed=seed)) as server:
        patch.setenv("FAKE_BASE_URL", server.url)
        patch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        run_study(PLANNED, directory, limits=Limits(access=Access(connections=1)))


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    directory = tmp_path_factory.mktemp("played") / "out"
    play(directory, seed=3)
    return directory


@pytest.fixture
def directory(played, tmp_path):
    """The study without a report, which takes seconds to make again."""
    return shutil.copytree(played, tmp_path / "out")


def failing(directory, **hashes):
    return {check.name: check.failed or (check.said,) for check in verify(directory, **hashes) if not check.holds}


def test_the_study_has_what_the_edits_need(directory):
    files = Evidence(directory)
    endings = {ending: len(files.of(MODEL, ending)) for ending in ("solved", "budget", "error")}
    assert endings["solved"] >= 2
    assert endings["budget"] >= 2
    assert endings["error"] >= 1
    assert any(len(step["decision"]["replies"]) == 2 for one in files.of(MODEL) for step in one["steps"])
    assert failing(directory) == {}


def failures_as_errors(files):
    for record in files.of(MODEL, "budget"):
        relabelled(record)


def failures_as_early_errors(files):
    for record in files.of(MODEL, "budget"):
        relabelled(record, steps=2)


def failures_as_errors_without_their_calls(files):
    for record in files.of(MODEL, "budget"):
        relabelled(record, steps=2)
        files.calls = [one for one in files.calls if one["key"] != record["key"] or one["step"] <= 3]


def failures_as_errors_without_their_calls_and_requests(files):
    failures_as_errors_without_their_calls(files)
    for record in files.of(MODEL, "error"):
        last = record["error"]["step"]
        files.asked = [one for one in files.asked if one["key"] != record["key"] or one["step"] <= last]


def failures_as_errors_with_other_replies(files):
    failures_as_errors_without_their_calls_and_requests(files)
    for record in files.of(MODEL, "error"):
        calls = files.calls_of(record)
        calls[-1]["reply"] = record["error"]["replies"][-1] = '{"move": "A"}'


def failures_as_faults_of_the_provider(files):
    for record in files.of(MODEL, "budget"):
        relabelled(record)
        record["error"] = {"boundary": "model", "message": "no reply within 120 s", "step": record["error"]["step"]}


def an_error_as_a_success(files):
    (record, *_), (solved, *_) = files.of(MODEL, "error"), files.of("random", "solved") or files.of(MODEL, "solved")
    played_by(record, json.loads(json.dumps(solved)))


def perfect(record):
    """The trial as the best player plays it."""
    plan = PLANNED.plan(MODEL, PLANNED.labelled(record["condition"]), record["repetition"], record["trial"])
    trial, _ = asyncio.run(play_timed(plan, resolve("ideal-observer").make()))
    return json.loads(trial_to_json(trial))


def a_perfect_player(files):
    for record in files.of(MODEL):
        played_by(record, perfect(record))


def a_perfect_player_with_replies(files):
    a_perfect_player(files)
    for record in files.of(MODEL):
        for step in record["steps"]:
            step["decision"]["replies"] = [reply_of(step["decision"])]


def a_perfect_player_with_calls(files):
    a_perfect_player_with_replies(files)
    for record in files.of(MODEL):
        calls = files.calls_of(record)
        for call, step in zip(calls, record["steps"], strict=False):
            call |= {"step": step["step"], "turn": 1, "reply": step["decision"]["replies"][0]}
            step["decision"]["usage"] = call["usage"]
        left = {id(call) for call in calls[len(record["steps"]) :]}
        files.calls = [call for call in files.calls if id(call) not in left]


def flipped(decision):
    decision["claimed"] = {"moved": "blocked", "blocked": "moved"}[decision["claimed"]]


def flipped_claims(files):
    for record in files.of(MODEL):
        for step in record["steps"][1:]:
            flipped(step["decision"])


def flipped_claims_with_replies(files):
    flipped_claims(files)
    for record in files.of(MODEL):
        for step in record["steps"][1:]:
            step["decision"]["replies"][-1] = reply_of(step["decision"])


def flipped_claims_with_calls(files):
    flipped_claims_with_replies(files)
    for record in files.of(MODEL):
        calls = {(call["step"], call["turn"]): call for call in files.calls_of(record)}
        for step in record["steps"][1:]:
            calls[step["step"], len(step["decision"]["replies"])]["reply"] = step["decision"]["replies"][-1]


def flipped_claims_with_calls_of_another_prompt(files):
    flipped_claims_with_calls(files)
    facts(prompt="chat 0123456789ab", picture_prompt="chat 0123456789ab")(files)


def rewritten_replies(files):
    for record in files.of(MODEL):
        for step in record["steps"]:
            step["decision"]["replies"][-1] = step["decision"]["replies"][-1].replace("in turn", "I see the plan")
            step["decision"]["hypothesis"] = "I see the plan"


def repaired_replies_left_out(files):
    for record in files.of(MODEL):
        for step in record["steps"]:
            step["decision"]["replies"] = step["decision"]["replies"][-1:]


def rewritten_replies_of_an_error(files):
    files.of(MODEL, "error")[0]["error"]["replies"][0] = "I refuse."


def rewritten_message_of_an_error(files):
    files.of(MODEL, "error")[0]["error"]["message"] = "no usable reply in 2 turns: not one JSON object"


def facts(**changes):
    def edit(files):
        for record in files.of(MODEL):
            record["facts"] |= changes

    return edit


def a_fact_of_one_trial(files):
    files.of(MODEL)[0]["facts"]["host"] = "http://elsewhere"


def another_served(files):
    for record in files.of(MODEL):
        for step in record["steps"]:
            step["decision"]["served"] = "fake-large"


def another_served_in_the_calls(files):
    for call in files.calls:
        call["served"] = "fake-large"


def cheaper_records(files):
    for record in files.of(MODEL):
        for step in record["steps"]:
            step["decision"]["usage"]["input_tokens"] = 1


def cheaper_calls(files):
    for call in files.calls:
        if call.get("reply"):
            call["usage"]["output_tokens"] = 1


def without_calls(files):
    files.calls, files.asked = [], []


def without_a_call(files):
    files.calls.remove(files.calls_of(files.of(MODEL, "solved")[0])[-1])


def one_more_call(files):
    last = files.calls_of(files.of(MODEL, "budget")[0])[-1]
    files.calls.append(last | {"reply": '{"last_action": "moved", "hypothesis": "", "joint": "A"}'})


PLACE = ("key", "agent", "condition", "repetition", "trial")


def place_of(line):
    """What names its trial in a call or a record."""
    return {name: line[name] for name in PLACE}


def a_call_of_another_trial(files):
    one, other = files.of(MODEL)[:2]
    call = files.calls_of(one)[0]
    call |= place_of(other)


def calls_of_another(agent=MODEL, **place):
    """Calls that are said to be of another agent, whose costs they then are, or of another place."""

    def edit(files):
        for call in (*files.calls, *files.asked):
            call.update({"agent": agent} | place)

    return edit


def calls_of_another_agent_for_an_owed_trial(files):
    key = files.of(MODEL)[0]["key"]
    files.drop(lambda one: one != key, "records", "timings")
    for call in (*files.calls, *files.asked):
        if call["key"] == key:
            call["agent"] = "llm:openai-api/fake/cheap"


def edited_calls(files):
    for call in files.calls:
        call["reply"] = call["reply"] and call["reply"].replace("in turn", "I see the plan")


def a_call_that_was_never_asked(files):
    place = files.calls_of(files.of(MODEL, "solved")[0])[-1]
    files.asked = [one for one in files.asked if (one["key"], one["step"]) != (place["key"], place["step"])]


def fewer_lost_attempts(files):
    last = files.calls_of(files.of(MODEL)[0])[-1]
    lost = {name: last[name] for name in (*PLACE, "step", "turn", "request")} | {"reply": None, "unanswered": 2}
    files.asked.append(lost)


def a_cheaper_bound(files):
    record = files.of(MODEL)[0]
    call = files.calls_of(record)[-1]
    call["unanswered"], call["most"] = 1, {"calls": 1, "input_tokens": 1, "output_tokens": 1}


def a_request_without_a_call(files):
    files.asked.append(files.asked[-1] | place_of(files.of(MODEL)[0]))


def replies_to_be_forgotten(files):
    record = files.of(MODEL, "budget")[0]
    mark = place_of(record) | {"step": 0, "turn": 0, "request": "", "reply": None, "error": "owed anew"}
    own = files.calls_of(record)
    files.calls += [mark, *own]


def replays_without_the_record_before(files):
    replies_to_be_forgotten(files)
    record = files.of(MODEL, "budget")[0]
    record["replays"] = 1


def dropped(*files_too, lowered=True):
    """Trials from the third on are dropped together with a lowered number."""

    def edit(files):
        if lowered:
            files.settings["trials"] = 2
        files.drop(lambda key: int(key.rpartition("=")[2]) <= 2, "records", *files_too)

    return edit


def left_out(agent, *files_too):
    def edit(files):
        files.settings["agents"].remove(agent)
        of = {record["key"] for record in files.of(agent)}
        files.drop(lambda key: key not in of, "records", *files_too)

    return edit


def a_second_record(files):
    record = json.loads(json.dumps(files.of("random", "budget")[0]))
    record["steps"][0]["decision"]["hypothesis"] = "made up"
    files.records.append(record)


FOUND = {
    "failures as errors": (failures_as_errors, "replies"),
    "failures as early errors": (failures_as_early_errors, "replies"),
    "failures as errors, calls dropped": (failures_as_errors_without_their_calls, "replies"),
    "failures as errors, calls and requests dropped": (failures_as_errors_without_their_calls_and_requests, "replies"),
    "failures as errors, replies made up": (failures_as_errors_with_other_replies, "replies"),
    "failures as faults of the provider": (failures_as_faults_of_the_provider, "complete"),
    "an error as a success": (an_error_as_a_success, "replies"),
    "a perfect player": (a_perfect_player, "replies"),
    "a perfect player with replies": (a_perfect_player_with_replies, "replies"),
    "a perfect player with calls": (a_perfect_player_with_calls, "replies"),
    "flipped claims": (flipped_claims, "replies"),
    "flipped claims with replies": (flipped_claims_with_replies, "replies"),
    "flipped claims with calls": (flipped_claims_with_calls, "replies"),
    "flipped claims with calls of another prompt": (flipped_claims_with_calls_of_another_prompt, "replies"),
    "rewritten replies": (rewritten_replies, "replies"),
    "repaired replies left out": (repaired_replies_left_out, "replies"),
    "rewritten replies of an error": (rewritten_replies_of_an_error, "replies"),
    "rewritten message of an error": (rewritten_message_of_an_error, "replies"),
    "another model": (facts(model="openai-api/fake/large"), "agents"),
    "another temperature": (facts(temperature=1.0), "agents"),
    "another top_p": (facts(top_p=0.9), "replies"),
    "another effort": (facts(effort="high"), "replies"),
    "another schema": (facts(schema="none"), "replies"),
    "another limit": (facts(max_tokens=77), "replies"),
    "other repairs": (facts(repairs=4), "agents"),
    "a fact of one trial": (a_fact_of_one_trial, "agents"),
    "another model answered": (another_served, "replies"),
    "another model answered in the calls": (another_served_in_the_calls, "replies"),
    "cheaper records": (cheaper_records, "replies"),
    "cheaper calls": (cheaper_calls, "replies"),
    "no calls": (without_calls, "replies"),
    "a call dropped": (without_a_call, "replies"),
    "one more call": (one_more_call, "replies"),
    "a call of another trial": (a_call_of_another_trial, "replies"),
    "calls of another agent": (calls_of_another("llm:openai-api/fake/cheap"), "replies"),
    "calls of another agent for an owed trial": (calls_of_another_agent_for_an_owed_trial, "replies"),
    "calls of another condition": (calls_of_another(condition="truth"), "replies"),
    "calls of another repetition": (calls_of_another(repetition=2), "replies"),
    "calls of another place": (calls_of_another(trial=1), "replies"),
    "edited calls": (edited_calls, "replies"),
    "a call that was never asked": (a_call_that_was_never_asked, "replies"),
    "fewer lost attempts": (fewer_lost_attempts, "replies"),
    "a cheaper bound": (a_cheaper_bound, "replies"),
    "a request without a call": (a_request_without_a_call, "replies"),
    "replies to be forgotten": (replies_to_be_forgotten, "replies"),
    "replays without the record before": (replays_without_the_record_before, "replies"),
    "trials dropped": (dropped(lowered=False), "complete"),
    "trials dropped, number lowered": (dropped(), "replies"),
    "trials dropped, calls too": (dropped("calls", "timings"), "replies"),
    "trials dropped, requests too": (dropped("calls", "asked"), "complete"),
    "the model left out": (left_out(MODEL, "timings"), "replies"),
    "the model left out, calls too": (left_out(MODEL, "timings", "calls"), "replies"),
    "a strategy left out": (left_out("random"), "complete"),
    "a second record": (a_second_record, "records"),
}


@pytest.mark.parametrize("name", FOUND)
def test_an_edit_is_found(directory, name):
    edit, check = FOUND[name]
    files = Evidence(directory)
    edit(files)
    files.save()
    assert check in failing(directory), failing(directory)


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
    "calls.jsonl and records made up together": rewritten_last_reply,
    "costs made up together": cheaper_everywhere,
    "the plan and every file": dropped("calls", "asked", "timings"),
    "an agent and every file": left_out("random", "timings"),
}


@pytest.mark.parametrize("name", NOT_FOUND)
def test_what_no_check_can_find_is_said_and_is_found_by_a_published_hash(directory, name):
    published = typed_status(directory)
    files = Evidence(directory)
    NOT_FOUND[name](files)
    files.save()
    assert failing(directory) == {}
    found = failing(directory, settings=published["settings_hash"], results=published["results_hash"])
    assert "results hash" in found
    assert ("settings hash" in found) == (published["settings_hash"] != read_study(directory).settings_hash)
    assert ("settings hash" in found) == (name.startswith(("the plan", "an agent")))


def typed_status(directory):
    return json.loads(typed("status", directory, "--json").stdout)


# The report.


@pytest.fixture(scope="module")
def reported(played, tmp_path_factory, drawn):
    """The study with its report, with one real figure."""
    directory = shutil.copytree(played, tmp_path_factory.mktemp("reported") / "out")
    with drawn("fig4"):
        write_report(directory)
    return directory


@pytest.fixture(scope="module")
def made_again(reported, drawn):
    """The files of its report, made once for all edits."""
    with drawn("fig4"), one_thread():
        return list(report_files(open_study(reported), tell=lambda said: None, each=map))


@pytest.fixture
def with_report(reported, made_again, tmp_path, monkeypatch):
    monkeypatch.setattr("lockprobe.report.report_files.report_files", lambda *opened, **how: iter(made_again))
    return shutil.copytree(reported, tmp_path / "out")


def another_digit(path):
    """Change one digit of the visible text of a file."""
    text = path.read_text("utf-8")
    start = text.index("<h1") if path.suffix == ".html" else len(text) // 2
    place = next(i for i in range(start, len(text)) if text[i] in "12345678" and text[i - 1] in " >;,")
    path.write_text(text[:place] + str(int(text[place]) + 1) + text[place + 1 :], "utf-8")


def another_pixel(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))


@pytest.mark.parametrize(
    "name",
    ["report.html", "tables/conditions.csv", "figures/fig4.svg"],
)
def test_an_edited_page_table_or_drawing_is_named(with_report, name):
    assert failing(with_report) == {}
    another_digit(with_report / name)
    assert failing(with_report) == {"report": (name,)}


def test_an_edited_picture_is_named(with_report):
    another_pixel(with_report / "figures" / "fig4.png")
    assert failing(with_report) == {"report": ("figures/fig4.png",)}


def test_another_drawing_in_a_page_is_named(with_report):
    page = with_report / "report.html"
    first, mark, rest = page.read_text("utf-8").partition("data:image/svg+xml,")
    page.write_text(f"{first}{mark}AAAA{rest}", "utf-8")
    assert failing(with_report) == {"report": ("report.html: its figures",)}


def test_a_figure_of_another_program_is_drawn_again_first(with_report):
    for path in (with_report / "figures").glob("*.svg"):
        path.write_text(path.read_text("utf-8").replace("Matplotlib v3", "Matplotlib v2"), "utf-8")
    (check,) = [check for check in verify(with_report) if not check.holds]
    assert "figures were drawn by Matplotlib v2" in check.said
    assert check.said.endswith("lockprobe report first")


def test_results_and_page_edited_together_are_named(with_report):
    for name in ("results.json", "report.html", "tables/conditions.csv"):
        another_digit(with_report / name)
    assert failing(with_report).keys() == {"results", "report"}


def test_files_that_are_not_there_are_counted(with_report):
    shutil.rmtree(with_report / "figures")
    (check,) = [check for check in verify(with_report) if check.name == "report"]
    assert check.holds
    assert check.said.endswith("are not there")


def test_the_command_counts_broken_trials_first_and_says_what_it_cannot_show(directory, capsys):
    write_report(directory)
    for as_json in (False, True):
        with pytest.raises(typer.Exit) as end:
            command.verify(directory, json=as_json)
        assert end.value.exit_code == 0
    first, *_, last, of_machines = capsys.readouterr().out.splitlines()
    assert "of 24 trials ended as an error (reply " in first
    assert last == f"{NOT_SHOWN}."
    found = json.loads(of_machines)
    assert (found["holds"], found["not_shown"]) == (True, NOT_SHOWN)

"""Verification finds what was edited, dropped, altered or played with other luck, and nothing where nothing was.

One table of sabotages holds it: each edits the files of a study as somebody does who knows them.
"""

import asyncio
import json
import shutil
from copy import deepcopy
from functools import cache, partial

import pytest
from builders import SOLUTION, make_trial, small_study, write_study
from provider_server import ENDS, Manner, here
from saboteur import Evidence, flipped, relabelled, reply_of
from stored import acts, sql
from taking_part import take_part
from tool_player import AGENT, Player, calls
from typed import in_process

from lockprobe import run_study, study
from lockprobe.agents.llm.settings import Access
from lockprobe.agents.local import LocalModel
from lockprobe.interfaces.mcp import ToolSession
from lockprobe.report.page import write_report
from lockprobe.report.verify import NOT_SHOWN, verify
from lockprobe.studies.branch import FORKS, branching, play_forks
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.journal import Journal
from lockprobe.studies.records.merge import gather
from lockprobe.studies.records.read_records import load, results_hash, stored_records
from lockprobe.studies.records.store import read
from lockprobe.studies.running.runner import Limits
from lockprobe.studies.running.trial_setup import play_timed
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import ForkName, TrialName

LOCAL, HOSTED = "llm:local", "llm:openai-api/fake/model"
MODEL = f"{HOSTED}?repairs=1&temperature=0.5"
PLANNED = study("flips", agent=[MODEL, "random"], p=[0, 0.4], trials=6, repetitions=1, max_steps=9, name="small")
STRATEGY = "flips/cognitive:careful/flip?p=0.4/rep=1/trial=2"
PLANT = """
from lockprobe.plants.symbolic import SymbolicPlant


class Bench(SymbolicPlant):
    def __init__(self, *, box, labels, rng):
        super().__init__(box)
"""


class Engine:
    """A model whose probabilities are those of the lengths of what it reads."""

    def __init__(self):
        self.facts = {"model": "x"}

    def restart(self, constant):
        pass

    def tokens(self, text, *, opening=False):
        return [len(text), sum(map(ord, text))]

    def score(self, prompt, candidates):
        raw = [1 + (sum(prompt) * (i + 1) + sum(one)) % 7 for i, one in enumerate(candidates)]
        return [one / sum(raw) for one in raw]


def forked(directory):
    """Strategies with forks."""
    planned = study("flips", agent=["random", "cognitive:careful"], p=[0, 0.4], trials=3, repetitions=1, max_steps=8)
    run_study(planned, directory)
    asked = branching(planned, load(directory), at=["2"], told=["truth", "lie"], times=2)
    with Journal.open(directory / FORKS, planned) as journal:
        play_forks(asked, journal)


def local(directory):
    planned = study("flips", agent=[LOCAL], p=[0, 0.4], trials=3, repetitions=1, max_steps=6)
    model = LocalModel(Engine(), temperature=0.7)
    write_study(directory, planned, [asyncio.run(play_timed(plan, model))[0] for plan in planned.plans(LOCAL)])


def client(directory):
    async def played():
        planned = study("flips", agent=[AGENT], p=[0.0, 0.3], trials=2, repetitions=1, max_steps=6)
        async with ToolSession.open(directory, planned, AGENT) as session:
            await Player(calls(session)).play()

    asyncio.run(played())


def people(directory):
    """People, and a strategy that no diary is of."""
    planned = small_study(["participant", "random"], p=[0.0], repetitions=1, trials=2)
    take_part(directory, planned, "aaaa01", [(0.0, 1, 1), (0.0, 1, 2)])
    run_study(planned, directory)


def provider(**manner):
    """The provider of a hosted model."""
    return here(manner=Manner(**manner))


def bench(directory):
    """A model and a strategy on a plant of one's own, with replies that could not be used."""
    (directory.parent / "own_bench.py").write_text(PLANT, "utf-8")
    faults = {"wrong schema": 0.2, "refusal": 0.05}
    with provider(faults=faults, seed=3), pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(directory.parent)
        plant = "python:own_bench:Bench"
        planned = study(
            "flips", agent=[HOSTED, "random"], p=[0, 0.4], trials=3, repetitions=1, max_steps=8, plant=plant
        )
        run_study(planned, directory, limits=Limits(access=Access(connections=1, pause=0.01)))


def hosted(directory, faults=None, retries=6, **given):
    planned = study("flips", **({"agent": HOSTED, "trials": 2, "repetitions": 1, "max_steps": 6} | given))
    with provider(faults=faults or {}):
        run_study(planned, directory, limits=Limits(access=Access(connections=2, pause=0.01, retries=retries)))


def resumed(directory):
    """Calls broke and were made again later."""
    for faults in ({"dropped": 1.0}, {"dropped": 0.2}, {}):
        hosted(directory, faults, retries=2, p=[0])


def branched(directory):
    """A hosted model with forks."""
    hosted(directory, p=[0, 0.4])
    planned = read_study(directory)
    asked = branching(planned, load(directory), at=["2"], told=["truth", "lie"])
    with provider(), Journal.open(directory / FORKS, planned) as journal:
        play_forks(asked, journal, limits=Limits(access=Access(connections=2)))


def sabotaged(directory):
    """A model whose provider repeats reports and sometimes replies in another form, beside a strategy."""
    with provider(faults={"wrong schema": 0.2}, seed=3):
        run_study(PLANNED, directory, limits=Limits(access=Access(connections=1, pause=0.01)))


STUDIES = {one.__name__: one for one in (forked, local, client, people, bench, resumed, branched, sabotaged)} | {
    name: partial(hosted, **given)
    for name, given in {
        "asked": {"condition": ["nudge?after=2", "hypothesis?ask=after", "tremble?p=0.5"]},
        "faulty": {
            "p": [0, 0.4],
            "assessment": False,
            "layout": "shuffled",
            "faults": {"wrong schema": 0.2, "429": 0.1, "dropped": 0.1, "500": 0.1},
        },
        "ended": {
            "p": [0, 0.4],
            "agent": f"{HOSTED}?max_tokens=50&schema=none&top_p=0.5",
            "faults": dict.fromkeys(ENDS, 0.15),
        },
    }.items()
}


@pytest.fixture(scope="module")
def played(tmp_path_factory):
    """A copy of a study, which is played once."""

    @cache
    def play(name):
        STUDIES[name](directory := tmp_path_factory.mktemp(name) / "out")
        return directory

    return lambda name, to: shutil.copytree(play(name), to)


def failing(directory, **hashes):
    return {check.name: tuple(check.failed) for check in verify(directory, **hashes) if not check.holds}


SAID = {
    "forked": ("forks", "forks follow from their trials, their choices and the seed"),
    "local": ("choices", "6 trials of local models, by their recorded probabilities"),
    "client": ("attempts", "4 trials of clients and people are as their servers wrote them step by step"),
    "people": ("attempts", "2 trials of clients and people are as their servers wrote them step by step"),
    "bench": ("replies", "6 of these are not played, and held by their words alone"),
    "branched": ("fork replies", "8 trials, and all of them"),
    "sabotaged": ("records", "of 24 trials ended as an error (reply "),
}


@pytest.mark.parametrize("name", STUDIES)
def test_a_study_as_it_was_played_holds_and_says_what_was_held_against_what(played, tmp_path, name):
    checks = {check.name: check for check in verify(played(name, tmp_path / "out"))}
    assert [check for check in checks.values() if not check.holds] == []
    of, said = SAID.get(name, ("replies", "replies in the log of calls are the decisions of"))
    assert said in checks[of].said
    if name == "bench":
        assert "more need a plant or an intervention that does not ship, or a real box" in checks["luck"].said


def one(change, key=STRATEGY):
    """An edit of one record."""
    return lambda files: change(next(record for record in files.records if record["key"] == key))


def without_last(files):
    files.settings["trials"] -= 1
    files.drop(lambda key: not key.endswith(f"trial={files.settings['trials'] + 1}"))


def of_the_model(change):
    return lambda files: change(next(record for record in files.of(HOSTED) if len(record["steps"]) > 2)["steps"][1])


def another_joint(step):
    step["decision"]["joint"] = next(one for one in "ABCD" if one != step["decision"]["joint"])


def without_last_of_a_fork(files):
    sql(files.directory / FORKS, "delete from call where id = (select max(id) from call)")


def each(change, ending=None, agent=MODEL):
    """Change every record of an agent that ended so."""
    return lambda files: [change(record) for record in files.of(agent, ending)]


def first(change, ending=None):
    """Change the files by the first record that ended so."""
    return lambda files: change(files, files.of(MODEL, ending)[0])


def decisions(change, agent=MODEL):
    """An edit of every decision of an agent but the first of a trial."""
    return each(lambda record: [change(step["decision"]) for step in record["steps"][1:]], agent=agent)


def cheaper(files):
    for call in files.calls:
        if call.get("reply"):
            call["usage"].update(output_tokens=1)


def faulty(record):
    relabelled(record)
    record["error"] = {"boundary": "model", "message": "no reply within 120 s", "step": record["error"]["step"]}


def one_more_call(files, record):
    files.calls.append(deepcopy(files.calls_of(record)[-1]))
    files.calls[-1]["reply"] = '{"last_action": "moved", "hypothesis": "", "joint": "A"}'


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


def a_second_record(files):
    files.records.append(deepcopy(files.of("random", "budget")[0]))
    files.records[-1]["steps"][0]["decision"]["hypothesis"] = "made up"


def flipped_and_said(decision):
    flipped(decision)
    decision["replies"][-1] = reply_of(decision)


EDITS = {
    "another outcome told": ("forked", one(lambda of: of["steps"][1].update(told_moved=not of["steps"][1]["told_moved"])), "luck", "step 2, told_moved"),
    "a trial dropped": ("forked", lambda files: files.drop(lambda key: key != STRATEGY), "complete", ""),
    "other doses": ("forked", lambda files: files.settings["conditions"][1]["interventions"][0].update(doses=["p"]), "settings", "the doses of flip?p=0.4"),
    "another seed": ("forked", lambda files: files.settings.update(seed=files.settings["seed"] + 1), "forks", ""),
    "other claims of a local model": ("local", decisions(flipped, LOCAL), "choices", ""),
    "a client's trials dropped": ("client", without_last, "attempts", ""),
    "a person's trial dropped": ("people", lambda files: files.drop(lambda key: key != files.records[0]["key"]), "attempts", "is not on record"),
    "a joint on a plant of one's own": ("bench", of_the_model(another_joint), "replies", "step 2, decision"),
    "no reply there": ("bench", of_the_model(lambda step: step["decision"].pop("replies")), "replies", ""),
    "a reply of a fork dropped": ("branched", without_last_of_a_fork, "fork replies", ""),
    "failures as errors": ("sabotaged", each(relabelled, "budget"), "replies", ""),
    "failures as faults of the provider": ("sabotaged", each(faulty, "budget"), "complete", ""),
    "flipped claims with replies": ("sabotaged", decisions(flipped_and_said), "replies", ""),
    "another model": ("sabotaged", each(lambda of: of["facts"].update(model="openai-api/fake/large")), "agents", ""),
    "cheaper calls": ("sabotaged", cheaper, "replies", ""),
    "a call dropped": ("sabotaged", first(lambda files, one: files.calls.remove(files.calls_of(one)[-1]), "solved"), "replies", ""),
    "one more call": ("sabotaged", first(one_more_call, "budget"), "replies", ""),
    "a call of another agent": ("sabotaged", first(lambda files, one: files.calls_of(one)[0].update(agent="random")), "replies", "its calls name no trial on record, or another agent"),
    "trials dropped, number lowered": ("sabotaged", dropped(), "replies", ""),
    "the model left out": ("sabotaged", left_out(MODEL), "replies", ""),
    "a second record": ("sabotaged", a_second_record, "records", ""),
}  # fmt: skip
"""An edit with right columns -> the study, the edit, the check that finds it, and what it says of it."""


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_is_found_though_columns_are_right(played, tmp_path, name):
    of, edit, check, said = EDITS[name]
    directory = played(of, tmp_path / "out")
    files = Evidence(directory)
    edit(files)
    files.save()
    found = failing(directory)
    assert check in found, found
    assert any(said in place for place in found[check])
    if of in ("bench", "branched"):
        assert list(found) == [check]


def rewritten_last_reply(files):
    record = files.of(MODEL, "budget")[0]
    files.calls_of(record)[-1]["reply"] = record["steps"][-1]["decision"]["replies"][-1] = reply_of(
        record["steps"][-1]["decision"] | {"hypothesis": "made up"}
    )
    record["steps"][-1]["decision"]["hypothesis"] = "made up"


NOT_FOUND = {
    "calls and records made up together": rewritten_last_reply,
    "the plan and all of it": dropped(calls=True),
    "an agent and all of it": left_out(MODEL, calls=True),
}


@pytest.mark.parametrize("name", NOT_FOUND)
def test_what_no_check_can_find_is_said_and_is_found_by_a_published_hash(played, tmp_path, name):
    directory = played("sabotaged", tmp_path / "out")
    study = read_study(directory)
    with read(directory) as store:
        settings, results = study.settings_hash, results_hash(study, stored_records(store))
    files = Evidence(directory)
    NOT_FOUND[name](files)
    files.save()
    assert failing(directory) == {}
    found = failing(directory, settings=settings, results=results)
    assert "results hash" in found
    assert ("settings hash" in found) == (settings != read_study(directory).settings_hash)
    assert ("settings hash" in found) == (name.startswith(("the plan", "an agent")))


def test_files_beside_the_records_are_held_against_them(played, tmp_path):
    directory = played("client", tmp_path / "client")
    for _ in range(2):  # attempts come with an import, once
        gather(tmp_path / "merged", [directory])
    assert failing(tmp_path / "merged") == {}
    sql(directory, "delete from attempt")
    assert len(failing(directory)["attempts"]) == 4
    whole, torn = (Picture(kind="rgb", png=b"png" + end) for end in (b"", b" "))
    shown = [make_trial(SOLUTION, trial=i, pictures=[{"rgb": one.name}]) for i, one in enumerate((whole, torn), 1)]
    directory = write_study(tmp_path / "seeing", small_study(["random"], (0.0,), 1, 2), shown)
    (directory / "pictures").mkdir()
    for one in (whole, torn):
        (directory / "pictures" / one.name).write_bytes(whole.png)
    assert failing(directory)["pictures"] == (torn.name,)
    for name, place in (("told", lambda entry: entry), ("claimed", lambda entry: entry["act"])):
        directory = played("people", tmp_path / name)
        number, entry = next((i, one) for i, one in enumerate(acts(directory, "aaaa01"), 1) if one.get("box") == 1)
        place(entry)[name] = "moved"
        change = "update act set entry = ?1, crc = checksum(participant, number, ?1) where number = ?2"
        sql(directory, change, json.dumps(entry), number)
        assert failing(directory).keys() & {"attempts", "records"}


def renamed(record, arm, **place):
    """Make a record of a fork one of another arm or of another trial, with the key that it then has."""
    place = {name: record[name] for name in ("study", "agent", "condition", "repetition", "trial")} | place
    record |= place
    record["fork"] |= {"parent": str(TrialName(**place)), "arm": arm}
    record["key"] = str(ForkName(**record["fork"]))


@pytest.mark.parametrize(
    "edit",
    [
        lambda forks: forks[0]["steps"][3].update(told="Nothing."),
        lambda forks: renamed(forks[0], forks[0]["fork"]["arm"], trial=9),
        lambda forks: renamed(forks[0], "hint"),
        lambda forks: [renamed(of, {"truth": "lie", "lie": "truth"}[of["fork"]["arm"]]) for of in forks],
    ],
)
def test_an_edited_fork_is_found(played, tmp_path, edit):
    directory = played("forked", tmp_path / "out")
    files = Evidence(directory / FORKS)
    edit(files.records)
    files.save()
    assert failing(directory).keys() & {"forks", "records"}  # a trial that the study has not is refused when it is read


def test_a_trial_whose_file_is_elsewhere_is_not_checked_and_no_failure(played, tmp_path):
    directory = played("forked", tmp_path / "out")
    shutil.rmtree(directory / FORKS)
    files = Evidence(directory)
    files.settings["plant"] = "twin?digest=0123456789abcdef&model=gate.xml"
    files.save()
    checks = {check.name: check for check in verify(directory)}
    assert checks["luck"].said.endswith("more are not checked: gate.xml is not here")
    assert (checks["luck"].failed, checks["choices"].failed) == ([], [])


# The report.


@pytest.fixture(scope="module")
def reported(tmp_path_factory):
    directory = write_study(tmp_path_factory.mktemp("report") / "study", small_study(["random"], (0.0, 0.3), 1, 3))
    write_report(directory)
    return directory


@pytest.fixture
def edited(reported):
    """Puts another content into a file of it, for this test."""
    before = {}

    def put(name, content):
        path = reported / name
        before.setdefault(path, path.read_bytes() if path.exists() else None)
        path.unlink() if content is None else path.write_bytes(content)
        return failing(reported)

    yield put
    for path, content in before.items():
        path.unlink() if content is None else path.write_bytes(content)


def another_digit(content):
    """Change one digit of the text that is seen."""
    start = max(content.find(b"<h1"), 0) or len(content) // 2
    at = next(i for i in range(start, len(content)) if content[i] in b"12345678" and content[i - 1] in b" >;,")
    return content[:at] + bytes([content[at] + 1]) + content[at + 1 :]


def test_an_edited_page_table_or_figure_is_named(reported, edited):
    assert failing(reported) == {}
    edits = {"figures/fig4.svg": lambda content: content + b" "}
    edits |= {"report.html": another_digit, "tables/conditions.csv": another_digit}
    for name, edit in edits.items():
        before = (reported / name).read_bytes()
        assert edited(name, edit(before)) == {"report": (name,)}
        edited(name, before)
    assert edited("tables/conditions.csv", None) == {}
    assert next(one.said for one in verify(reported) if one.name == "report").endswith("; 1 are not there")


def test_an_altered_result_is_named_as_it_is_written_and_as_it_is_computed(reported, edited):
    text = (reported / "results.json").read_text("utf-8")
    (line,) = [
        one.strip(" ,")
        for one in text.splitlines()
        if '"success", "agent": "random", "condition": "truth"' in one and '"of"' not in one and '"axis"' not in one
    ]
    for before, after in (('"count": ', '"count": 1'), ('"test": ""', '"test": "", "note": null')):
        found = edited("results.json", text.replace(line, line.replace(before, after)).encode())
        assert found == {"results": (f"written: {line.replace(before, after)}", f"computed: {line}")}


def test_the_command_ends_with_one_and_names_what_fails(reported, edited):
    def verified(*more):
        return in_process("verify", reported, *more)

    assert verified().exit_code == 0
    edited("results.json", b"{")
    done = verified()
    assert done.exit_code == 1
    assert "FAILS  results   " in done.stdout
    assert done.stdout.splitlines()[-1] == f"{NOT_SHOWN}."
    found = json.loads(verified("--json").stdout)
    assert (found["holds"], [one["name"] for one in found["checks"] if not one["holds"]]) == (False, ["results"])
    assert found["not_shown"] == NOT_SHOWN

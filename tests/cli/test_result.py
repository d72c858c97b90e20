"""What a study found is the end of its run, of its report and of Ctrl-C: answer, numbers of each agent, next command."""

import json
import shlex

import pytest
from typed import in_process

from lockprobe.cli.report import report
from lockprobe.cli.result import found as said_of
from lockprobe.cli.result import read_result
from lockprobe.report.rows import Estimate, Fact, Results

pytestmark = pytest.mark.usefixtures("placeholders")

STUDY = ("run", "flips", "--agent", "cognitive:perseverant", "--agent", "random", "--p", "0,0.6", "--trials", 20,
         "--repetitions", 1)  # fmt: skip


@pytest.fixture(scope="module")
def played(tmp_path_factory, placeholders):
    directory = tmp_path_factory.mktemp("result") / "a study"
    return directory, in_process(*STUDY, "--out", directory)


def test_a_run_ends_with_the_answer_the_numbers_and_the_next_command(played):
    directory, done = played
    lines = done.stdout.splitlines()
    answer = next(i for i, line in enumerate(lines) if line.startswith("Answer: "))
    assert lines[answer - 1] == f"Report: {directory / 'report.html'}"
    assert lines[answer][8:] == json.loads((directory / "results.json").read_text("utf-8"))["answer"]
    found = read_result(directory)
    truth = found.one("success", agent="cognitive:perseverant", condition="truth")
    change = found.one(
        "success_difference", agent="cognitive:perseverant", condition="flip?p=0.6", axis="flip rate", versus=""
    )
    first, second = lines[answer + 1 : answer + 3]  # every agent has one
    assert first.startswith(f"  cognitive:perseverant  {100 * truth.value:.0f} % [")
    assert " told the truth, " in first
    assert f"] at flip rate 0.6  {100 * change.value:+.0f} [" in first
    assert second.startswith("  random ")
    assert second.endswith("plays alike")
    assert lines[answer + 3].startswith("Next: lockprobe replay '")


def test_a_report_says_the_same_and_programs_get_it_too(played, capsys):
    directory, done = played
    report([directory])
    again = capsys.readouterr().out.splitlines()
    assert again == done.stdout.splitlines()[-len(again) :]
    report([directory], json=True)
    ended, (_, facts) = json.loads(capsys.readouterr().out), said_of(read_result(directory), directory)
    assert {name: ended[name] for name in facts} == facts


def test_without_results_that_can_be_read_nothing_is_said(tmp_path):
    assert read_result(tmp_path) is None
    (tmp_path / "results.json").write_text("{")
    assert read_result(tmp_path) is None


def test_a_trial_to_look_at_and_its_forks_are_the_next_commands_and_can_be_typed(played):
    directory, _ = played
    following = [shlex.split(command)[1:] for command in said_of(read_result(directory), directory)[1]["next"]]
    assert [words[0] for words in following] == ["replay", "branch"]
    assert "step" in in_process(*following[0]).stdout
    nothing = Results.model_validate({**json.loads((directory / "results.json").read_text("utf-8")), "answer": ""})
    assert not said_of(nothing, directory)[0][0].startswith("Answer")


@pytest.mark.parametrize(("replayed", "command"), [("yes", ""), ("no", " with another --out")])
def test_where_every_trial_broke_nothing_but_what_mends_it_is_next(played, replayed, command):
    directory, _ = played
    found = read_result(directory)
    (agent,) = found.subjects
    rows = [row for row in found.rows if (row.quantity, row.agent) != ("success", agent)]
    broken = Estimate(quantity="broken", agent=agent, of="reply", value=120)
    again = Fact(about=f"{agent}, broken at reply", name="will be replayed", text=replayed)
    lines, _ = said_of(found.changed(rows=(*rows, broken), facts=(*found.facts, again)), directory)
    assert lines == [
        f"Answer: {found.answer}",
        f"Next: the same command{command}  plays the broken trials again, when their cause is mended",
    ]
    assert len(said_of(found.changed(rows=(*found.rows, broken)), directory)[0]) > 3

"""An instruction of one's own: what is in it, and that it is what a model gets and a record holds."""

import json
import os
from dataclasses import replace
from pathlib import Path

import pytest
from provider_server import here, truthful, words

from lockprobe.agents.prompt import FIELDS, INSTRUCTIONS, conversation, example
from lockprobe.foundation.errors import BadFile, BadValue, SettingsChanged, UserMistake
from lockprobe.interventions.catalogue import interventions_of
from lockprobe.interventions.prompt import LARGEST_TEMPLATE, OwnPrompt
from lockprobe.interventions.warn import Warn
from lockprobe.report.write import write_report
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.running.runner import run_study
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.briefing import Briefing
from lockprobe.trial.condition import spec_of
from lockprobe.trial.trial_json import trial_from_json, trial_to_json

CURT = Path(__file__).with_name("curt.txt")
LEAST = "{joints} {target} {reply}"


def written(path, text):
    path.write_text(text, "utf-8")
    return OwnPrompt(file=str(path))


def said(*interventions, shown=None):
    briefing = Briefing()
    for one in interventions:
        briefing = one.brief(briefing, (), None, None)
    return [message.text for message in conversation(replace(shown or example(), briefing=briefing))]


@pytest.mark.parametrize("shown", [example(), example(1), example(2), example(assessment=False)])
def test_the_usual_instruction_as_a_file_is_the_usual_instruction(tmp_path, shown):
    assert said(written(tmp_path / "usual.txt", INSTRUCTIONS), shown=shown) == said(shown=shown)


def test_the_documentation_shows_it():
    assert f"```text\n{INSTRUCTIONS}\n```" in (CURT.parents[2] / "docs" / "interventions.md").read_text("utf-8")


def test_fields_are_filled_in_and_nothing_else_changes():
    first, *others = said(OwnPrompt(file=str(CURT)))
    assert first.startswith("Open the box. Its 2 joints (B, A) lock each other, 0 and 1. Move A in 20 steps.\nThen you")
    assert '{"last_action": "moved" or' in first
    assert others == said()[1:]


def test_a_warning_is_said_also_where_the_template_has_no_place_for_it(tmp_path):
    plain = written(tmp_path / "plain.txt", LEAST)
    assert "sometimes false." in said(plain, Warn())[0]
    assert said(OwnPrompt(file=str(CURT)), Warn())[0].count("sometimes false.") == 1


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f"{LEAST} {{p}}", "no field of a template is called 'p'; there are: " + ", ".join(FIELDS)),
        (f"{LEAST} {{joints.__class__}}", "no field of a template is called"),
        (f"{LEAST} {{budget:>99999999}}", "no field of a template is called"),
        (f"{LEAST} {{}}", "no field of a template is called"),
        (f"{LEAST} {{", "fields in single braces, and all other braces doubled"),
        ("{joints} {target}", "fields of a template: got 'joints, target', expected at least joints, target, reply"),
    ],
)
def test_a_template_that_cannot_be_used_is_refused_in_one_line(tmp_path, text, expected):
    with pytest.raises(UserMistake) as refused:
        written(tmp_path / "bad.txt", text)
    assert expected in str(refused.value)
    assert "\n" not in str(refused.value)


def test_doubled_braces_stay_as_one(tmp_path):
    assert said(written(tmp_path / "braces.txt", f"{LEAST} {{{{so}}}}"))[0].startswith("B, A A Reply with")
    assert "{so}" in said(written(tmp_path / "braces.txt", f"{LEAST} {{{{so}}}}"))[0]


def test_files_are_read_with_bounds(tmp_path):
    with pytest.raises(BadFile, match="larger than"):
        written(tmp_path / "large.txt", LEAST + "x" * LARGEST_TEMPLATE)
    (tmp_path / "bytes.txt").write_bytes(b"\xff" + LEAST.encode())
    with pytest.raises(BadFile, match="not UTF-8"):
        OwnPrompt(file=str(tmp_path / "bytes.txt"))
    with pytest.raises(BadFile, match="a directory"):
        OwnPrompt(file=str(tmp_path))
    with pytest.raises(BadValue, match="a file with an instruction"):
        interventions_of("prompt")


def test_its_spec_names_the_content_and_refuses_another(tmp_path):
    one = written(tmp_path / "one.txt", LEAST)
    spec = spec_of(one)
    assert spec.endswith(f"&sha256={one.sha256}")
    assert interventions_of(spec) == (one,)
    (tmp_path / "one.txt").write_text(f"{LEAST}!")
    with pytest.raises(BadValue, match="the hash of its present content"):
        interventions_of(spec)


def test_strategies_play_as_before():
    assert run_trial(condition=f"prompt?file={CURT}").steps == run_trial().steps


def test_two_prompts_reach_the_wire_and_are_in_the_record(tmp_path, monkeypatch):
    pytest.importorskip("lockprobe.agents.llm.model")
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)
    kind = written(tmp_path / "kind.txt", f"Please open the box. {LEAST}")
    with here(truthful, keep=True) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        trials, sent = [], []
        for acting in (
            (),
            (OwnPrompt(file=str(CURT)),),
            (kind,),
            interventions_of("hypothesis?ask=after"),
        ):
            begun = len(server.requests)
            answer = run_trial(agent="llm:openai-api/fake/model", condition=acting)
            trials.append(answer)
            sent.append(server.requests[begun:])
    openings = [words(requests[0]["messages"][0]) for requests in sent]
    assert openings[0].startswith("You are trying to open a lockbox")
    assert openings[1].startswith("Open the box. Its 4 joints (")
    assert openings[2].startswith("Please open the box. ")
    assert [trial.interventions for trial in trials[:3]] == [
        (),
        ({"intervention": "OwnPrompt", "file": str(CURT), **facts(CURT)},),
        ({"intervention": "OwnPrompt", "file": kind.file, **facts(Path(kind.file))},),
    ]
    assert [trial.actions for trial in trials[1:3]] == [trials[0].actions] * 2
    form = sent[3][0]["response_format"]["json_schema"]["schema"]["properties"]
    assert list(form) == ["last_action", "joint", "hypothesis"]
    assert {step.decision.hypothesis for step in trials[3].steps} == {"in turn"}
    for trial in trials:
        assert trial_from_json(trial_to_json(trial)) == trial


def facts(path):
    one = OwnPrompt(file=str(path))
    assert json.loads(json.dumps(one.text)) == path.read_text("utf-8").strip()
    return {"sha256": one.sha256, "text": one.text}


def test_two_prompts_are_two_conditions_of_one_study(tmp_path, monkeypatch):
    pytest.importorskip("lockprobe.agents.llm.model")
    for name in os.environ:
        if name.endswith(("_API_KEY", "_BASE_URL")):
            monkeypatch.delenv(name)
    curt, kind = tmp_path / "curt.txt", tmp_path / "kind.txt"
    curt.write_text(f"Open it. {LEAST}", "utf-8")
    kind.write_text(f"Please open the box. {LEAST}", "utf-8")
    asked = {"agent": "llm:openai-api/fake/model", "trials": 1, "repetitions": 1}
    asked["condition"] = [f"prompt?file={curt}", f"prompt?file={kind}"]
    planned = study("flips", **asked)
    with here(truthful, keep=True) as server:
        monkeypatch.setenv("FAKE_BASE_URL", server.url)
        monkeypatch.setenv("FAKE_API_KEY", "sk-private-0123456789")
        trials = run_study(planned, tmp_path / "study")
        openings = {words(request["messages"][0]).split(".")[0] for request in server.requests}
    assert openings == {
        "You are trying to open a lockbox, a panel with 4 joints",
        "Open it",
        "Please open the box",
    }
    texts = sorted([one["text"] for one in trial.interventions] for trial in trials)  # they end in any order
    assert texts == [[], [f"Open it. {LEAST}"], [f"Please open the box. {LEAST}"]]
    assert len({trial.condition for trial in trials}) == 3
    monkeypatch.setattr("lockprobe.report.figures.render", lambda figure, form: b"<svg/>")  # words are looked at here
    page = write_report(tmp_path / "study").read_text()
    assert "curt.txt" in page
    assert "kind.txt" in page
    kind.write_text(f"Kindly open the box. {LEAST}", "utf-8")
    assert study("flips", **asked).identity != planned.identity
    with pytest.raises(SettingsChanged, match="kind.txt"):
        run_study(study("flips", **asked), tmp_path / "study")

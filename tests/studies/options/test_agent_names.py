"""A name stands in keys, pages and tables in place of an agent's spec, and changes no draw."""

import json
from dataclasses import replace

import pytest
from builders import play_study, write_study

from lockprobe.foundation.errors import BadFile, BadValue, SettingsChanged
from lockprobe.studies.options.agent_names import named_agents
from lockprobe.studies.options.study_options import read_options_file
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.merge import gather, source_of_directory
from lockprobe.studies.records.read_records import load
from lockprobe.studies.running.runner import run_study

SPEC = "human-inspired?lapse=0.1"


def small(*agents):
    return study("flips", agent=list(agents), p=[0, 0.4], trials=2, repetitions=1)


NAMED, PLAIN = small(f"careful={SPEC}", "random"), small(SPEC, "random")


def test_a_name_changes_no_draw():
    called, plain = play_study(NAMED), play_study(PLAIN)
    assert [replace(one, key="", called="") for one in called] == [replace(one, key="") for one in plain]


def test_study_files_name_agents_and_run_no_code_behind_a_name(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(f'agent = ["careful={SPEC}", "random"]\np = [0, 0.4]\ntrials = 2\nrepetitions = 1\n')
    assert study(str(path)) == NAMED
    path.write_text('agent = "mine=python:os:getcwd"\n')
    with pytest.raises(BadFile, match="agent: python:os:getcwd would run code"):
        read_options_file(path)


@pytest.mark.parametrize(
    ("agents", "said"),
    [
        (["a=random", "b=random"], "got 'b=random', expected random once: the same seed gives the same trials"),
        (["random", "b=random"], "got 'b=random', expected random once: the same seed gives the same trials"),
        (["a=random", "a=round-robin"], "agents: got \\['a', 'a'\\], expected at least one, and every one once"),
        (["random=human-inspired"], "another name: random is an agent"),
        (["me=participant"], "participant without a name"),
        ([" =random"], "NAME=SPEC"),
        (["a="], "NAME=SPEC"),
        (["a\x1b=random"], "visible characters"),
        ([f"{'a' * 201}=random"], "at most 200 visible characters"),
        ([f"human-inspired?lapse=0.{'1' * 200}"], "at most 200 characters, not 223, or a name: --agent 'NAME=SPEC'"),
    ],
)
def test_names_that_cannot_be_are_one_line(agents, said):
    with pytest.raises(BadValue, match=said) as caught:
        study("flips", agent=agents)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("text", ["llm:openai/gpt-4o?effort=low", "python:mine:Agent?x=1", SPEC, "mcp:client"])
def test_an_equals_sign_within_a_spec_names_nothing(text):
    assert named_agents([text]) == ([text], {})


@pytest.mark.parametrize("other", ["kind", ""])
def test_another_name_is_told_as_one(tmp_path, other):
    write_study(tmp_path, NAMED)
    renamed = small(f"{other}={SPEC}" if other else SPEC, "random")
    with pytest.raises(SettingsChanged, match=f"name of {SPEC[:8]}.* is 'careful' there, '{other or SPEC[:8]}"):
        run_study(renamed, tmp_path)
    path = tmp_path / "study.json"
    path.write_text(json.dumps(renamed.settings()))
    with pytest.raises(BadFile, match="holds flips/careful/truth.*which is no trial of the study in study.json"):
        load(tmp_path)


def test_named_agents_that_were_played_apart_are_one_study(tmp_path):
    sources = [write_study(tmp_path / str(i), small(one)) for i, one in enumerate((f"careful={SPEC}", "b=random"))]
    gathered = gather(tmp_path / "both", [source_of_directory(one) for one in sources])
    assert (gathered.taken, gathered.agents) == (8, ("careful", "b"))
    assert read_study(tmp_path / "both") == small(f"careful={SPEC}", "b=random")
    assert {trial.key for trial in load(tmp_path / "both")} == {
        one.key for one in play_study(read_study(tmp_path / "both"))
    }
    with pytest.raises(BadFile, match="name of random is 'c', not 'b'"):
        gather(tmp_path / "both", [source_of_directory(write_study(tmp_path / "c", small("c=random")))])

"""Prompts of the three modalities differ in the observation alone, and every difference is shown."""

import json
import re
from itertools import permutations

import pytest

from lockprobe.agents.prompt import INSTRUCTIONS
from lockprobe.studies.options.studyfile import study
from lockprobe.studies.prompts import prompt_parts, side_by_side

PARTS = ["first message", "report after the first step", "form of the reply"]
OF_OBSERVATIONS = re.compile(
    r"two positions|you are (shown|told)|find out by|The (first )?picture|You attempted|At 1|\{\"(attempted|positions)\""
)


def passages(part, **options):
    return side_by_side(prompt_parts(study("modalities", **options))[part])


@pytest.mark.parametrize("as_paper", [True, False])
def test_what_differs_between_modalities_is_about_the_observation(as_paper):
    for part in PARTS:
        for modalities, text in passages(part, as_paper=as_paper):
            assert len(modalities) in (1, 3)
            assert len(modalities) == 3 or OF_OBSERVATIONS.search(text), text


@pytest.mark.parametrize("as_paper", [True, False])
def test_the_rest_of_the_instruction_and_the_form_of_the_reply_are_the_same(as_paper):
    common = " ".join(text for modalities, text in passages(PARTS[0], as_paper=as_paper) if len(modalities) == 3)
    task = INSTRUCTIONS.split("{names}. ")[1].split("{observation}")[0].format(budget=20)
    assert " ".join(task.split()) in common
    assert re.search(r'"last_action": .* "joint": the joint to attempt next}', common)
    assert re.search(r"The panel's joints: ., ., ., .\. The target joint: .\.", common)
    assert ("hypothesis" in common) == (not as_paper)
    ((modalities, form),) = passages(PARTS[2], as_paper=as_paper)
    assert len(modalities) == 3
    assert ("hypothesis" in json.loads(form)["properties"]) == (not as_paper)


def test_each_prompt_is_its_passages_in_order():
    for prompts in prompt_parts(study("modalities", as_paper=True)).values():
        found = side_by_side(prompts)
        for modality, said in prompts.items():
            assert " ".join(one.text for one in found if modality in one.modalities) == " ".join(said)


@pytest.mark.parametrize("words", sorted({*permutations("abbc")}))
def test_passages_of_any_sentences_give_each_text_back(words):
    prompts = {"one": list(words), "two": ["a", "b", "c"], "three": ["b", "d"]}
    found = side_by_side(prompts)
    for name, said in prompts.items():
        assert " ".join(one.text for one in found if name in one.modalities) == " ".join(said)


def test_an_intervention_changes_no_prompt_and_one_modality_stands_alone():
    plain, nudged = (prompt_parts(study("flips", **asked)) for asked in ({"p": [0]}, {"condition": "warn"}))
    assert plain == nudged
    assert {len(side_by_side(prompts)) for prompts in plain.values()} == {1}

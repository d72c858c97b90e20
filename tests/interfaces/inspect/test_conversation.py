"""A trial's conversation, made again from its record, is the one that was had."""

from dataclasses import replace
from pathlib import Path

import pytest
from builders import make_trial, play_study, small_study

from lockprobe.agents.prompt import fingerprint
from lockprobe.foundation.errors import UnknownName
from lockprobe.interfaces.inspect.conversation import exchanges_of, instruction, last_report
from lockprobe.studies.running.single import run_trial
from lockprobe.testing import ScriptedProvider, completion, in_turn, words
from lockprobe.trial.pictures.picture import Picture
from lockprobe.trial.record import TrialError

GOOD = '{"last_action": "moved", "hypothesis": "", "joint": "D"}'


def replied(*replies):
    """A trial of three steps; the second was decided after these replies."""
    trial = make_trial([3, 3, 3], budget=3, facts={"prompt": f"chat {fingerprint('x')}"})
    steps = [replace(step, told=f"told {step.step}") for step in trial.steps]
    steps[1] = replace(steps[1], decision=replace(steps[1].decision, replies=replies))
    return replace(trial, steps=tuple(steps), opening="first")


def test_a_malformed_reply_is_followed_by_what_was_then_asked():
    said = [exchange for exchange in exchanges_of(replied("no idea", GOOD)) if exchange.step == 2]
    assert [(exchange.turn, exchange.last, exchange.reply) for exchange in said] == [
        (1, False, "no idea"),
        (2, True, GOOD),
    ]
    assert said[0].told.text == "told 1"
    assert said[1].told.text.startswith("That reply could not be used (not one JSON object)")


def test_a_trial_that_a_reply_broke_ends_with_it():
    trial = replied(GOOD)
    error = TrialError(boundary="reply", message="no", step=2, replies=("a", "b"))
    said = exchanges_of(replace(trial, steps=trial.steps[:1], ending="error", error=error))
    assert [(exchange.step, exchange.turn, exchange.reply) for exchange in said[1:]] == [(2, 1, "a"), (2, 2, "b")]


def test_a_hosted_model_was_told_the_instruction_and_a_strategy_was_not():
    hosted, scripted = replied(GOOD), make_trial([0], budget=1)
    assert "Reply with one JSON object" in instruction(hosted)
    assert exchanges_of(hosted)[0].told.text == f"{instruction(hosted)}\n\nfirst"
    assert instruction(scripted) == "Joints A, B, C, D; the target is A; 1 steps."


def test_what_was_told_is_said_as_the_record_has_it():
    trial = replied(GOOD)
    told = {tell: instruction(replace(trial, channels=({"channel": "TextChannel", "tell": tell},))) for tell in
            ("state", "outcome")}  # fmt: skip
    assert "You are not told whether a joint moved" in told["state"]
    assert "Then you are told whether it moved.\n" in told["outcome"]
    assert instruction(replace(trial, channels=({"channel": "TextChannel"},))) == instruction(trial)


def test_of_a_strategy_is_said_what_it_chose():
    (trial, *_) = play_study(small_study(["human-inspired"], p=[0.3], repetitions=1, trials=1))
    said = exchanges_of(trial)
    assert [exchange.told.text for exchange in said[1:]] == [step.told for step in trial.steps[:-1]]
    assert last_report(trial).text == trial.steps[-1].told
    assert all(step.decision.joint in exchange.reply for step, exchange in zip(trial.steps, said, strict=True))


def test_pictures_are_those_that_were_shown_and_are_there(tmp_path):
    shown, kept = Picture(kind="rgb", png=b"seen"), Picture(kind="depth16", png=b"kept")
    for picture in (shown, kept):
        (tmp_path / picture.name).write_bytes(picture.png)
    gone = Picture(kind="rgb", png=b"gone").name
    trial = make_trial([0], budget=1, pictures=[{"rgb": shown.name, "depth16": kept.name}, {"rgb": gone}])
    assert [picture.png for picture in exchanges_of(trial, tmp_path)[0].told.pictures] == [b"seen"]
    assert last_report(trial, tmp_path).pictures == ()
    assert exchanges_of(trial)[0].told.pictures == ()


def test_only_the_newest_pictures_were_sent_where_the_settings_say_so(tmp_path):
    files = [Picture(kind="rgb", png=bytes([i])) for i in range(4)]
    for file in files:
        (tmp_path / file.name).write_bytes(file.png)
    names = [{"rgb": file.name} for file in files]
    trial = make_trial([0] * 3, budget=3, pictures=names, facts={"prompt": "chat x"})
    trial = replace(trial, facts={**trial.facts, "images": 2})
    shown = [[message.pictures for message in exchange.asked[::2]] for exchange in exchanges_of(trial, tmp_path)]
    kept = [[tuple(picture.png for picture in pictures) for pictures in step] for step in shown]
    one = [(file.png,) for file in files]
    assert kept == [one[:1], one[:2], [(), *one[1:3]]]
    assert exchanges_of(trial, tmp_path)[2].asked[0].text == f"{instruction(trial)}\n\n(picture no longer shown)"


def test_the_words_of_a_hypothesis_are_left_as_they_are():
    trial = make_trial([0, 1], budget=2, hypothesis="f( x)", claims=[None, "moved"])
    assert [exchange.reply for exchange in exchanges_of(trial)] == [
        "(f( x) Attempts A.)",
        "(It moved. f( x) Attempts B.)",
    ]
    assert exchanges_of(make_trial([0], budget=1))[0].reply == "(Attempts A.)"


CURT = Path(__file__).parents[2] / "interventions" / "curt.txt"


@pytest.mark.parametrize(
    "spec",
    [
        "truth", f"prompt?file={CURT}", "hypothesis?ask=off", "hypothesis?ask=after", "warn?rate=0.4",
        "distract?p=1", "nudge + remark", "flip?p=0.3 + nudge + symbolic?tell=outcome",
        f"prompt?file={CURT} + warn + drop?p=0.5",
    ],
)  # fmt: skip
def test_what_is_retold_is_what_was_said_on_the_wire(spec):
    """Word for word, a malformed reply and what was asked after it included."""
    pytest.importorskip("inspect_ai")
    came = []

    def answer(request):
        came.append(request)
        return completion("no idea") if len(came) == 3 else in_turn(request)

    with ScriptedProvider(answer) as provider:
        trial = run_trial(agent=provider.agent, condition=spec, max_steps=12)
    assert trial.error is None
    sent = [[(message["role"], words(message)) for message in request["messages"]] for request in provider.requests]
    assert [[(message.role, message.text) for message in one.asked] for one in exchanges_of(trial)] == sent


def test_a_record_s_template_that_is_none_is_refused():
    trial = replace(replied(GOOD), interventions=({"intervention": "OwnPrompt", "text": "{joints.__class__}"},))
    with pytest.raises(UnknownName, match="field of a template"):
        instruction(trial)

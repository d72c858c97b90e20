"""A server that is set up wrongly is named once in a run, with what to set; one odd reply is none."""

from provider_server import completion, truthful
from stored import records

from lockprobe.cli.run import run
from lockprobe.cli.server_marks import ENOUGH, ServerMarks
from lockprobe.cli.status import status
from lockprobe.trial.model_call import Call

SPEC = "llm:openai-api/fake/model"


def call(reply):
    return Call(key="k", step=1, turn=1, request="", reply=reply)


def test_only_marks_in_every_reply_are_spoken_of_and_once_for_each_agent():
    marks = ServerMarks()
    said = [marks.notice("a", call('Hm</think>{"joint": "A"}')) for _ in range(ENOUGH + 3)]
    assert [bool(line) for line in said] == [number == ENOUGH for number in range(1, ENOUGH + 4)]
    line = said[ENOUGH - 1]
    assert line.startswith(
        "a: every reply so far holds marks that its server should have removed, such as '</think>'; "
    )
    assert "--reasoning-parser" in line
    assert [marks.notice("b", call('{"joint": "A"}<|im_end|>')) for _ in range(ENOUGH)][-1].endswith("PARAMETER stop)")
    assert marks.notice("c", call('{"joint": "A"}')) == ""
    assert {marks.notice("c", call('{"joint": "A"}</s>')) for _ in range(9)} == {""}
    assert {marks.notice("d", call(reply)) for reply in (None, "") for _ in range(9)} == {""}


def leaking(request):
    return completion(f"Hm</think>{truthful(request)[1]['choices'][0]['message']['content']}")


def test_a_run_says_so_in_one_line_and_status_counts(tmp_path, provider, capsys):
    provider[1](leaking)
    out = tmp_path / "s"
    run("flips", agent=[SPEC], p=["0,0.2"], trials=1, repetitions=1, out=out)
    lines = [line for line in capsys.readouterr().out.splitlines() if "should have removed" in line]
    assert len(lines) == 1
    assert "'</think>'" in lines[0]
    status(out)
    told = capsys.readouterr().out
    steps = sum(len(record["steps"]) for record in records(out))
    assert f"tidied      {steps} of {steps} replies before they were read: reasoning in the text {steps}" in told

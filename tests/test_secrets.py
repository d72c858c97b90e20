"""No key, token, password or header is ever in a log, a record or a report, whatever a provider repeats of them."""

import base64
import contextlib
import json
import os
from collections import Counter
from typing import ClassVar
from urllib.parse import quote

import pytest
from placeholders import undrawn
from provider_server import completion, failure, here, names, truthful
from stored import contents, records
from typed import typed_here

from lockprobe.foundation.errors import ModelFault, ReplyFault
from lockprobe.foundation.redaction import without_secrets
from lockprobe.studies.running.single import run_trial
from lockprobe.trial.record import Decision

KEY = "planted/key+0123456789"
PASSWORD = "planted%password"
TOKEN = "planted-token-4567"
ORGANISATION = "org-planted8901"
HEADER = "planted=header=2345"
SECRETS = (KEY, PASSWORD, TOKEN, ORGANISATION, HEADER, f"user:{PASSWORD}")


def plant(monkeypatch, url="http://127.0.0.1:9/v1"):
    """Put every secret into the environment; the URL with user, password and token."""
    with_user = f"{url.replace('://', f'://user:{quote(PASSWORD)}@')}?token={TOKEN}"
    monkeypatch.setenv("FAKE_API_KEY", KEY)
    monkeypatch.setenv("OPENAI_ORG_ID", ORGANISATION)
    monkeypatch.setenv("OPENAI_CUSTOM_HEADERS", f"X-Planted: {HEADER}")
    monkeypatch.setenv("FAKE_BASE_URL", url)
    monkeypatch.setenv("HTTPS_PROXY_FOR_TESTS", with_user)
    return with_user


def forms(secret):
    """How a secret may be written."""
    yield from (secret, quote(secret, safe=""), json.dumps(secret)[1:-1])
    for shift in range(3):  # within a longer text, the characters of base64 depend on where it begins
        encoded = base64.b64encode(b" " * shift + secret.encode()).decode().rstrip("=")
        yield encoded[(0, 2, 3)[shift] : -1]


def leaks(content):
    """The secrets that these bytes hold, in whatever form."""
    return {form for secret in SECRETS for form in forms(secret) if form.encode() in content}


def everything(directory):
    """Every file below a directory, and every row of a store, whose records are as they are read."""
    for path in directory.rglob("*"):
        if path.is_file():
            yield str(path), path.read_bytes()
    for name, rows in contents(directory).items():
        for number, row in enumerate(rows if isinstance(rows, list) else ()):
            values = [one if isinstance(one, bytes) else str(one).encode() for one in row]
            yield f"{name}!{row[0]} {number}", b" ".join(values)


def repeating(echo):
    """Answers that repeat secrets, in errors, in replies that cannot be used and in such that can."""
    times = Counter()

    def answer(request):
        name, turn = names(request["messages"])[1], len(request["messages"]) // 2
        times[name] += 1
        status, body = truthful(request)
        said = json.loads(body["choices"][0]["message"]["content"])
        if times[name] == 1 and turn == 1:
            return failure(403, echo)
        if times[name] == 1 and turn == 2:
            return 400, f"<html>{echo}</html>".encode()
        if times[name] == 1 and turn == 3:
            return completion(f"I was told {echo}")
        status, body = completion(json.dumps(said | {"hypothesis": echo}))
        return status, body | {"model": f"model of {KEY}"}

    return answer


def command(*arguments):
    """What the command prints, to both streams."""
    done = typed_here(*arguments)
    return done.stdout + done.stderr


@pytest.fixture(autouse=True)
def no_other_keys(monkeypatch):
    for name in os.environ:
        if name.endswith(("_KEY", "_TOKEN", "_URL")):
            monkeypatch.delenv(name)


@pytest.mark.parametrize(
    ("said", "kept"),
    [
        ("Incorrect API key provided: sk-other-012345.", "Incorrect API key provided: [secret]"),
        ("Incorrect API key provided: sk-proj-****wxyz", "Incorrect API key provided: [secret]"),
        ("API key not valid: AIzaSyA1234567890abcdefg", "API key not valid: [secret]"),
        ("Authorization: Bearer abc.def-ghi", "Authorization: [secret]"),
        ("{'authorization': 'Basic YTpi', 'x-api-key': 'a'}", "{'authorization': '[secret]', 'x-api-key': '[secret]'}"),
        ("sent bearer abcdef to us", "sent bearer [secret] to us"),
        ("no route to http://a:b@host:1/v1?k=v", "no route to http://[secret]@host:1/v1?[secret]"),
        ("Bearer token required", "Bearer token required"),
        ("api_key client option must be set", "api_key client option must be set"),
        ("see https://host/account/api-keys", "see https://host/account/api-keys"),
        ("joint: 'sk' is none of A, B", "joint: 'sk' is none of A, B"),
    ],
)
def test_what_looks_like_a_secret_is_struck_out_of_what_a_provider_says_and_no_more(said, kept):
    assert without_secrets(said) == kept
    assert str(ModelFault(said)) == kept


def test_a_key_is_struck_out_before_a_long_message_is_cut(monkeypatch):
    plant(monkeypatch)
    for before in range(960, 1010):
        assert "planted" not in str(ModelFault("x" * before + KEY))


class Repeating:
    """Somebody's own agent, which says what it should not."""

    facts: ClassVar = {}

    def __init__(self, *, usable):
        self._usable = usable

    async def decide(self, situation, rng):
        said = f"I was given {KEY}"
        if not self._usable:
            raise ReplyFault(said, (said,))
        joint = situation.task.joints[len(situation.past) % len(situation.task.joints)]
        return Decision(joint=joint, hypothesis=said, replies=(said,), served=KEY)


def test_whatever_agent_repeats_a_key_it_is_not_recorded(monkeypatch):
    plant(monkeypatch)
    told = "I was given [secret]"
    broken = run_trial(agent=Repeating(usable=False)).error
    assert (broken.message, broken.replies) == (told, (told,))
    decision = run_trial(agent=Repeating(usable=True)).steps[0].decision
    assert (decision.hypothesis, decision.replies, decision.served) == (told, (told,), "[secret]")


@pytest.mark.parametrize(("answers", "ending"), [(True, "solved"), (False, "error")])
def test_a_url_with_user_password_and_token_reaches_the_provider_and_no_file(tmp_path, monkeypatch, answers, ending):
    run = ["run", "flips", "--agent", "llm:openai-api/fake/model", "--p", "0", "--trials", "1", "--repetitions", "1"]
    with contextlib.ExitStack() as stack:
        server = stack.enter_context(here())
        if not answers:
            stack.close()
        monkeypatch.setenv("FAKE_BASE_URL", plant(monkeypatch, server.url))
        printed = command(*run, "--retries", "0", "--no-report", "--out", tmp_path / "study")
    assert [one["ending"] for one in records(tmp_path / "study")] == [ending]
    assert leaks(printed.encode()) == set()
    assert {name: found for name, content in everything(tmp_path) if (found := leaks(content))} == {}


def test_nothing_that_is_written_or_printed_holds_a_secret(tmp_path, monkeypatch):
    study = tmp_path / "study"
    encoded = base64.b64encode(f"user:{PASSWORD}".encode()).decode()
    echo = (
        f"key {KEY}; Authorization: Bearer {KEY}; Basic {encoded}; {{'x-planted': '{HEADER}'}}; {ORGANISATION}; "
        f"{quote(KEY, safe='')} http://user:{quote(PASSWORD)}@127.0.0.1/v1?token={TOKEN}"
    )
    run = ["run", "flips", "--agent", "llm:openai-api/fake/model", "--p", "0", "--trials", "2", "--repetitions", "1"]
    with here(repeating(echo)) as server, undrawn():
        plant(monkeypatch, server.url)
        ways = (["--no-report"], ["--no-report", "--json"], [])
        printed = [command(*run, "--connections", "2", "--out", study, *more) for more in ways]
    assert any(KEY in line for line in server.headers)
    lines = (
        ["status", study], ["status", study, "--json"], ["export", study, "--out", tmp_path / "export.csv"],
        ["export", study, "--format", "jsonl", "--out", tmp_path / "export.jsonl"],
        ["export", study, "--table", "records", "--format", "jsonl"], ["replay", study, records(study)[-1]["key"]],
    )  # fmt: skip
    printed += [command(*line) for line in lines]
    written = dict(everything(tmp_path))
    assert {"export.csv", "export.jsonl"} <= {path.name for path in tmp_path.iterdir()}
    assert {name: found for name, content in written.items() if (found := leaks(content))} == {}
    assert [leaks(text.encode()) for text in printed] == [set()] * len(printed)
    for table in ("trial", "call"):  # what was struck out, and the rest of what was said, is there
        rows = [content for name, content in written.items() if f"study.db!{table} " in name]
        assert any(b"key [secret]; " in content for content in rows)
    assert "model" in [one["error"]["boundary"] for one in records(study) if "error" in one]

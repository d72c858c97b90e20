"""Every reason for which a participant is refused has its HTTP status."""

import json
from typing import get_args

from lockprobe.people.refusals import ActRefused, Code
from lockprobe.people.web.refusals import STATUS, RequestRefused, refused


def test_every_code_has_its_status():
    assert set(get_args(Code)) <= set(STATUS)
    assert {code: STATUS[code] for code in get_args(Code)} == {
        "malformed": 400, "incomplete": 400, "forged": 401, "wrong-code": 403, "stale": 409,
        "elsewhere": 409, "impossible": 422,
    }  # fmt: skip


def test_the_answer_says_the_code_and_why():
    answer = refused(ActRefused("stale", "not the scene that is shown"), words=1)
    assert answer.status_code == 409
    assert json.loads(answer.body) == {"error": "stale", "message": "not the scene that is shown", "words": 1}
    assert refused(RequestRefused("too-large", "a body")).status_code == 413

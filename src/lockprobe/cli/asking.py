"""What can be asked of ``lockprobe run``, option by option."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lockprobe.errors import BadValue
from lockprobe.studies.study import LayoutKind

__all__ = [
    "Again",
    "Agents",
    "AsJson",
    "Assessment",
    "Batch",
    "BoxName",
    "Budget",
    "Conditions",
    "Connections",
    "EstimateOnly",
    "Flip",
    "Full",
    "Layout",
    "MaxSteps",
    "Modalities",
    "Name",
    "Out",
    "P",
    "PlantSpec",
    "Repetitions",
    "Retries",
    "Seed",
    "Shuffle",
    "Sweeps",
    "Timeout",
    "Trials",
    "Workers",
    "WriteReport",
]

_STUDY = "The study; mechanisms.toml comes with the package."
_AGENTS = "Agent spec; may be repeated (flips: llm:local, random, round-robin, human-inspired)."
_TRIALS = "Trials per repetition and condition (6; 10 with --full, or if --p or --repetitions is given)."
_PLANT = "What is acted on: symbolic (flips), fast-twin (modalities) or twin; options as twin?looks=varied."
_MODALITY = "How the box is shown: symbolic (flips), rgb, rgbd, rgbd?depth=height; may be repeated (modalities: all)."
_CONDITION = (
    "What acts, with plus signs between: 'flip?p=0.4 + nudge'; may be repeated. lockprobe interventions lists them."
)
_SWEEP = "One condition for each dose: 'tremble?p=0,0.1,0.2'; may be repeated."
_LAYOUT = "fixed (flips): one panel for all trials; shuffled (modalities): joints dealt anew to it in every trial."
_ASSESSMENT = "Ask, with every reply, what the last action did; asking may change behaviour (--assessment)."
_BUDGET = "US dollars that the study may cost, earlier runs included; it stops before more could be spent."
_BATCH = "Use the provider's batch interface: cheaper, and hours instead of seconds."
_ESTIMATE = "Only say what it would cost; nothing is asked, and nothing written."
_REPORT = "Write the report; without, `lockprobe report DIR` does it later."
_AGAIN = "reply: play anew what ended because no reply was usable; the earlier records stay in the file (nothing)."
_RETRIES = "How often a request that the provider did not answer is made again."
_WORKERS = "Processes for local models and simulated plants (one a core)."


def _directory(path: str) -> Path:
    """Nothing is the current directory only for those who write a dot."""
    if not path:
        raise BadValue("out", path, "a directory")
    return Path(path)


Name = Annotated[str, typer.Argument(metavar="flips|modalities|FILE.toml", help=_STUDY)]
Agents = Annotated[
    list[str] | None,
    typer.Option(help=_AGENTS),
]
BoxName = Annotated[str | None, typer.Option(help="A box by name, random-N-SEED, or a TOML file (chain-4).")]
P = Annotated[str | None, typer.Option(help="Flip rates, how often reports are inverted (0,0.2,0.4,0.6).")]
Trials = Annotated[
    int | None,
    typer.Option(help=_TRIALS),
]
Repetitions = Annotated[int | None, typer.Option(help="Repetitions (3).")]
Seed = Annotated[int | None, typer.Option(help="Seed of everything (1).")]
MaxSteps = Annotated[int | None, typer.Option(help="Budget of a trial in steps (20).")]
Flip = Annotated[str | None, typer.Option(help="A false report is transient, sticky or outcome-only (transient).")]
PlantSpec = Annotated[str | None, typer.Option(help=_PLANT)]
Modalities = Annotated[list[str] | None, typer.Option(help=_MODALITY)]
Conditions = Annotated[list[str] | None, typer.Option(help=_CONDITION)]
Sweeps = Annotated[list[str] | None, typer.Option(help=_SWEEP)]
Layout = Annotated[LayoutKind | None, typer.Option(help=_LAYOUT)]
Shuffle = Annotated[
    bool | None, typer.Option("--shuffle/--no-shuffle", help="Shuffle labels and their listing per trial (--shuffle).")
]
Assessment = Annotated[bool | None, typer.Option("--assessment/--no-assessment", help=_ASSESSMENT)]
Full = Annotated[bool, typer.Option("--full", help="The paper's 7 x 3 x 10 trials per agent (flips).")]
Out = Annotated[Path | None, typer.Option(metavar="DIR", parser=_directory, help="Directory of the study.")]
Workers = Annotated[int | None, typer.Option(min=1, help=_WORKERS)]
Connections = Annotated[int, typer.Option(min=1, help="Requests to a provider on their way at once.")]
Timeout = Annotated[float, typer.Option(help="Seconds after which a request that hangs is made again.")]
Retries = Annotated[int, typer.Option(help=_RETRIES)]
Budget = Annotated[float | None, typer.Option(metavar="DOLLARS", help=_BUDGET)]
Batch = Annotated[bool, typer.Option("--batch", help=_BATCH)]
WriteReport = Annotated[bool, typer.Option("--report/--no-report", help=_REPORT)]
EstimateOnly = Annotated[bool, typer.Option("--estimate", help=_ESTIMATE)]
Again = Annotated[str | None, typer.Option(metavar="reply", help=_AGAIN)]
AsJson = Annotated[bool, typer.Option("--json", help="One JSON object a line.")]

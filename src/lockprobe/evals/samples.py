"""Samples of an Inspect log: their names, their content, and their metadata in the viewer."""

from __future__ import annotations

from lockprobe.errors import needing
from lockprobe.evals.scoring import SCORER, VALUES
from lockprobe.plan import Plan
from lockprobe.record import Trial

with needing("Inspect logs", "providers"):
    from inspect_ai.viewer import SampleScoreView, TaskSamplesColumn, TaskSamplesView, ViewerConfig

__all__ = ["OPTIONS", "SETTINGS", "VERSION", "VIEW", "metadata_of", "sample_id"]

SETTINGS = "lockprobe"
"""Where in the metadata of a log the settings of its study stand."""

OPTIONS = ("schema", "images", "detail", "repairs")
"""Parameters of a task that say how its model is asked, where Inspect has no option for it."""

VERSION = "1-A"
"""Of the tasks: what makes results incomparable raises the number, what changes their parameters the letter."""

VIEW = ViewerConfig(
    sample_score_view=SampleScoreView(default="chips"),
    task_samples_view=TaskSamplesView(
        name="trials",
        columns=[
            TaskSamplesColumn(id="sampleStatus"),
            TaskSamplesColumn(id="sampleId"),
            TaskSamplesColumn(id="epoch", visible=False),
            TaskSamplesColumn(id="input", visible=False),
            TaskSamplesColumn(id="target", visible=False),
            TaskSamplesColumn(id="answer"),
            *(TaskSamplesColumn.score(SCORER, value) for value in VALUES),
            TaskSamplesColumn(id="error"),
        ],
        multiline=False,
    ),
)
"""How ``inspect view`` lists the trials: how each ended, and its scores; the instruction is the same in all."""


def sample_id(trial: Trial | Plan) -> str:
    """The name of a trial in a log: its place in the study, for example ``p=0.4/rep=2/trial=7``."""
    return trial.key.removeprefix(f"{trial.study}/{trial.group}/")


def metadata_of(trial: Trial | Plan) -> dict[str, object]:
    """The metadata of a trial: its place in the study, and shared settings that change what the agent sees."""
    if isinstance(trial, Trial):
        flip, box = trial.flip, trial.box
    else:
        flip, box = "" if trial.condition.flip is None else trial.condition.flip.persistence, trial.box.name
    return {
        "condition": sample_id(trial).rpartition("/rep=")[0],
        "p": trial.p,
        "repetition": trial.repetition,
        "trial": trial.trial,
        "modality": trial.modality,
        "flip": flip,
        "box": box,
        "max_steps": trial.budget,
        "seed": trial.seed,
        "assessment": trial.assessment,
        "study": trial.study,
    }

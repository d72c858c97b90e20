"""Samples of an Inspect log: their names, their content, and their metadata in the viewer."""

from __future__ import annotations

from lockprobe.foundation.errors import needing
from lockprobe.interfaces.inspect.scoring import SCORER, VALUES
from lockprobe.trial.plan import Plan
from lockprobe.trial.record import Trial

with needing("Inspect logs", "providers"):
    from inspect_ai.viewer import SampleScoreView, TaskSamplesColumn, TaskSamplesView, ViewerConfig

__all__ = ["OPTIONS", "SETTINGS", "VERSION", "VIEW", "metadata_of", "sample_id"]

SETTINGS = "lockprobe"
"""The key of the study's settings in the metadata of a log."""

OPTIONS = ("schema", "images", "detail", "repairs")
"""Parameters of a task for options of its model that Inspect lacks."""

VERSION = "1-A"
"""The version of the tasks: the number changes when results become incomparable, the letter with their parameters."""

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
"""The columns of ``inspect view``: the ending and the scores of each trial, without the common instruction."""


def sample_id(trial: Trial | Plan) -> str:
    """The name of a trial in a log: its place in the study, for example ``flip?p=0.4/rep=2/trial=7``."""
    return trial.name.place


def metadata_of(trial: Trial | Plan) -> dict[str, object]:
    """The metadata of a trial: its place in the study, and shared settings that change what the agent sees."""
    return {
        "condition": trial.name.condition,
        "label": trial.name.condition,
        "p": trial.p,
        "repetition": trial.repetition,
        "trial": trial.trial,
        "modality": trial.modality,
        "box": trial.box if isinstance(trial, Trial) else trial.box.name,
        "max_steps": trial.budget,
        "seed": trial.seed,
        "assessment": trial.assessment,
        "hypothesis": trial.hypothesis,
        "study": trial.study,
    }

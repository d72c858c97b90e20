"""A study read back from the settings on disk."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from lockprobe.boxes.boxfile import box_from_data
from lockprobe.foundation.errors import BadFile, UserMistake
from lockprobe.foundation.validation import plain
from lockprobe.studies.file_names import SETTINGS
from lockprobe.studies.options.condition_settings import ConditionSettings
from lockprobe.studies.records.directory import read_settings
from lockprobe.studies.records.shard import Shard
from lockprobe.studies.study import LARGEST_SEED, Study
from lockprobe.studies.until import EarlierSize, Until
from lockprobe.trial.condition import Contrast

Text = Annotated[str, Field(min_length=1, max_length=1000)]
LONGEST_SPEC = 1000
"""Characters of the spec of an agent, a condition or a plant."""

AgentSpec = Annotated[str, Field(min_length=1, max_length=LONGEST_SPEC)]

Count = Annotated[int, Field(ge=0, le=LARGEST_SEED)]


class _Until(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")
    rule: Literal["decided", "width"]
    points: float

    def until(self) -> Until:
        """The rule."""
        return Until(rule=self.rule, points=self.points)


class _Earlier(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")
    repetitions: Count
    trials: Count
    strategy_trials: Count | None


class _Contrast(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")
    of: list[Text]
    minus: list[Text]


class _Settings(BaseModel):
    model_config = ConfigDict(strict=True, extra="forbid")
    study: Text
    agents: list[AgentSpec]
    names: dict[AgentSpec, Text] = {}
    box: dict[str, Any]
    more_boxes: list[dict[str, Any]] = []
    conditions: list[ConditionSettings]
    repetitions: Count
    trials: Count
    strategy_trials: Count | None
    until: _Until | None = None
    contrasts: dict[Text, _Contrast] = {}
    extended: list[_Earlier] = []
    shard: Text | None = None
    strategy_conditions: list[Text] = []
    max_steps: Count
    seed: Count
    shuffle: Text
    plant: Text
    layout: Text
    assessment: bool
    hypothesis: Text


_AS_THEY_STAND = {field.name for field in fields(Study) if field.init} - {
    *("name", "agents", "box", "more_boxes", "conditions", "until", "contrasts", "earlier", "shard")
}
"""The settings that a study takes from the file as they are."""


def read_study(directory: Path | str) -> Study:
    """The study whose settings lie in a directory.

    Raises:
        BadFile: If they describe none.
    """
    return study_from(read_settings(directory), Path(directory) / SETTINGS)


def study_from(settings: Mapping[str, object], path: Path) -> Study:
    """The study of which these are the :meth:`~lockprobe.studies.study.Study.settings`; messages name the path.

    Raises:
        BadFile: If they describe none.
    """
    try:
        found = _Settings.model_validate(settings)
    except ValidationError as error:
        first = error.errors()[0]
        raise BadFile(path, f"{'.'.join(map(str, first['loc']))}: {plain(first['msg'])}") from None
    try:
        return Study(
            name=found.study,
            agents=tuple(found.agents),
            box=box_from_data(found.box),
            more_boxes=tuple(map(box_from_data, found.more_boxes)),
            conditions=tuple(one.condition() for one in found.conditions),
            until=found.until.until() if found.until else None,
            shard=None if found.shard is None else Shard.parse(found.shard),
            contrasts={name: Contrast(tuple(one.of), tuple(one.minus)) for name, one in found.contrasts.items()},
            earlier=tuple(EarlierSize(**one.model_dump()) for one in found.extended),
            **found.model_dump(include=_AS_THEY_STAND),
        )
    except UserMistake as error:
        raise BadFile(path, str(error)) from None

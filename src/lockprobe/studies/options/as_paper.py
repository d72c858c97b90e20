"""The switch ``--as-paper``: options that make a study as close to the paper's as the paper says.

Each option cites its section; ``docs/as-paper.md`` compares them with Lockprobe's defaults. The settings of such a
study are ordinary settings, so the same options one by one make the same study.
"""

from __future__ import annotations

from lockprobe.foundation.errors import Conflict
from lockprobe.plants.catalogue import PlantSource
from lockprobe.studies.modality import is_pictured
from lockprobe.studies.options import paper
from lockprobe.studies.options.study_options import StudyOptions
from lockprobe.trial.record import STRUCTURED


def as_paper(asked: StudyOptions, plant: PlantSource) -> StudyOptions:
    """The options with everything that they leave out as the paper has it. What they say stays.

    Reports list the label and the state of every joint (Fig. 2). Labels are predefined (Fig. 2), and the panel is the
    same in all trials (Sec. 2.1): both are drawn once from the seed of the study, so that neither labels nor their
    order nor places follow the interlock; a real box keeps its own panel. The agent says what its last action did
    (Sec. 3.1) and is asked for no hypothesis. A trial has 20 steps (Sec. 2.2); flips have 7 rates x 3 repetitions x 10
    trials (Sec. 3.2), modalities 10 trials each (Sec. 2.2); with ``until`` the number of trials is not the paper's.

    Raises:
        Conflict: If the study is none of the paper's, labels are to stand along the panel, or they are painted on a
            real box.
    """
    if asked.study not in ("flips", "modalities"):
        raise Conflict("--as-paper", asked.study, "the studies of the paper are flips and modalities")
    if asked.shuffle == "never":
        raise Conflict("--as-paper", "--shuffle never", "labels along the panel can give the interlock away")
    modal = asked.study == "modalities"
    shown = list(paper.MODALITIES_AS_PAPER if modal and plant.has_camera else [STRUCTURED])
    found = asked.modality or shown
    if plant.painted_labels and any(map(is_pictured, found)):
        raise Conflict("--as-paper", f"pictures of {plant.spec}", "painted labels stand along the panel of its box")
    extent = paper.MODALITY_TRIALS if modal else paper.FULL
    usual = {
        "modality": found,
        "shuffle": "study",
        "layout": "dealt" if plant.lays_out else "fixed",
        "hypothesis": "off",
        "assessment": True,
        "max_steps": paper.MAX_STEPS,
        **({} if asked.until else {"repetitions": extent.repetitions, "trials": extent.trials}),
    }
    return asked.model_copy(update={name: value for name, value in usual.items() if getattr(asked, name) is None})

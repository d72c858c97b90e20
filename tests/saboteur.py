"""Edits of a study directory as somebody makes them who wants its numbers otherwise and knows its files.

The columns of every edited row, the identity too, are those that its record would have.
"""

import json
from pathlib import Path

from stored import records, rewrite, sql, written

from lockprobe.studies.records.directory import read_study
from lockprobe.studies.records.store import checksum


class Evidence:
    """What is stored of a study in a directory.

    Attributes:
        records: As objects; so are the settings, and what was said of calls.
    """

    def __init__(self, directory):
        self.directory = Path(directory)
        self.records = records(self.directory)
        self.calls = [json.loads(one) for one in sql(self.directory, "select call from call order by id")]
        self.settings = json.loads((self.directory / "study.json").read_text("utf-8"))

    def save(self):
        """Write all of them back."""
        (self.directory / "study.json").write_text(json.dumps(self.settings, indent=2), "utf-8")
        study = read_study(self.directory)
        identities = {one.label: study.record_identity(one) for one in study.conditions}
        rewrite(self.directory, self.records, [identities[record["condition"]] for record in self.records])
        rows = [(one["key"], json.dumps(one)) for one in self.calls]
        rows = [(*row, checksum(*row)) for row in rows]
        with written(self.directory) as store, store.transaction() as writing:
            writing.execute("delete from call")
            writing.executemany("insert into call (key, call, crc) values (?, ?, ?)", rows)

    def of(self, agent, ending=None):
        """The records of an agent, those that ended so if that is given."""
        return [one for one in self.records if one["agent"] == agent and ending in (None, one["ending"])]

    def calls_of(self, record):
        """The outcomes of the calls of a trial, oldest first."""
        return [call for call in self.calls if call["key"] == record["key"]]

    def drop(self, keep, *, calls=False):
        """Drop the records, or the calls too, whose key is not to be kept."""
        self.records = [one for one in self.records if keep(one["key"])]
        self.calls = [one for one in self.calls if keep(one["key"]) or not calls]


def relabelled(record):
    """A failure relabelled as a trial whose agent gave no usable reply, in its last step."""
    cut = len(record["steps"]) - 1
    replies = record["steps"][cut]["decision"].get("replies", [])
    del record["steps"][cut:]
    record["changed"] = {spec: min(steps, cut) for spec, steps in record.get("changed", {}).items()}
    record["changed_steps"] = min(record.get("changed_steps", 0), cut)
    record["ending"] = "error"
    record["error"] = {
        "boundary": "reply",
        "message": f"no usable reply in {len(replies)} turns: not one JSON object",
        "step": cut + 1,
        "replies": replies,
        "usage": {"calls": len(replies), "input_tokens": 11 * len(replies), "output_tokens": 5 * len(replies)},
    }


def reply_of(decision):
    """The reply that gives a decision."""
    said = {"moved": "moved", "blocked": "did not move", None: "none"}[decision.get("claimed")]
    return json.dumps({"last_action": said, "hypothesis": decision.get("hypothesis", ""), "joint": decision["joint"]})


def flipped(decision):
    """Make it claim the opposite."""
    decision["claimed"] = {"moved": "blocked", "blocked": "moved"}[decision["claimed"]]

"""run says a hash before the first trial and one after the last; report and verify know them again."""

import json
import re
from subprocess import CompletedProcess

RUN = ("run", "flips", "--agent", "random", "--p", "0,0.4", "--trials", "2", "--repetitions", "1")


def hashes(text):
    return dict(re.findall(r"^(Settings|Results): ([0-9a-f]{32}) ", text, re.MULTILINE))


def test_hashes_are_said_around_the_trials_and_known_again(tmp_path, lockprobe):
    def typed_here(*arguments):
        return CompletedProcess(arguments, *lockprobe(*arguments))

    out = tmp_path / "out"
    lines = typed_here(*RUN, "--out", out).stdout.splitlines()
    said = hashes("\n".join(lines))
    first, trials, last = (
        next(i for i, line in enumerate(lines) if line.startswith(start))
        for start in ("Settings: ", "random: 4 trials", "Results: ")
    )
    assert first < trials < last
    status = json.loads(typed_here("status", out, "--json").stdout)
    assert status["settings_hash"] == said["Settings"]
    assert said["Settings"] in typed_here("status", out).stdout
    assert all(found in (out / "report.html").read_text("utf-8") for found in said.values())
    done = typed_here("verify", out, "--settings", said["Settings"], "--results", said["Results"])
    assert done.returncode == 0
    assert f"these results have the hash {said['Results']}" in done.stdout
    done = typed_here("verify", out, "--settings", said["Results"])
    assert done.returncode == 1
    assert f"FAILS  settings hash  1 exception to: these settings have the hash {said['Results']}" in done.stdout
    assert f"they have {said['Settings']}" in done.stdout
    assert hashes(typed_here(*RUN, "--estimate").stderr) == {"Settings": said["Settings"]}
    done = typed_here("verify", out, "--settings", "")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)

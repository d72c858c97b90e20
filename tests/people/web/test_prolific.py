"""The example for Prolific: a container behind Caddy, its settings, and the way back with the right code."""

import asyncio
import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from seated import Player, go_on, opened, people_study

from lockprobe.cli.serve import PLACEHOLDERS
from lockprobe.people.experiment import read_experiment
from lockprobe.people.responses import Agree
from lockprobe.people.web.address import ADMIN_TOKEN, Address

EXAMPLE = Path(__file__).parents[3] / "examples" / "prolific"
COMPOSE = yaml.safe_load((EXAMPLE / "compose.yaml").read_text("utf-8"))
EXPERIMENT = read_experiment(EXAMPLE / "settings" / "people.toml")
SERVICE = COMPOSE["services"]["lockprobe"]
GIVEN = {"DOMAIN": "study.example.org", ADMIN_TOKEN: "0123456789abcdef"}


@pytest.fixture(scope="module")
def compose():
    """How Docker Compose is called here."""
    version = ["docker", "compose", "version"]
    if shutil.which("docker") and not subprocess.run(version, capture_output=True, check=False).returncode:
        return ["docker", "compose"]
    return ["docker-compose"] if shutil.which("docker-compose") else pytest.skip("no docker compose")


def option(name):
    return next(part.partition("=")[2] for part in SERVICE["command"] if part.startswith(f"--{name}="))


def test_the_proxy_asks_where_the_server_listens_and_under_a_name_that_it_knows():
    caddy, (proxied,) = (
        COMPOSE["services"]["caddy"],
        re.findall(r"LOCKPROBE:(\S+?)\}", (EXAMPLE / "Caddyfile").read_text()),
    )
    assert proxied == "lockprobe:8765"
    assert "lockprobe" in caddy["depends_on"]
    assert "ports" not in SERVICE  # nobody reaches it but the proxy
    public = re.sub(r"\$\{DOMAIN.*?\}", "study.example.org", option("public-url"))
    address = Address(host=option("host"), port=8765, public=public)
    assert address.secure
    assert "study.example.org" in address.hosts
    assert option("out").startswith("/studies/")
    assert {volume.partition(":")[2] for volume in SERVICE["volumes"]} == {"/settings:ro", "/studies"}


def test_every_variable_that_it_needs_stands_in_the_example_of_the_environment():
    given = {line.partition("=")[0] for line in (EXAMPLE / ".env.example").read_text().splitlines() if "=" in line}
    used = set(re.findall(r"\$\{(\w+)", (EXAMPLE / "compose.yaml").read_text()))
    assert used == given == {"DOMAIN", ADMIN_TOKEN}


def test_every_file_that_it_mounts_and_builds_from_is_there_and_every_volume_is_declared():
    mounted = [volume.split(":") for service in COMPOSE["services"].values() for volume in service["volumes"]]
    assert {name for name, *_ in mounted if not name.startswith(".")} == set(COMPOSE["volumes"])
    assert all((EXAMPLE / path).exists() for path, *_ in mounted if path.startswith("."))
    dockerfile = (EXAMPLE / SERVICE["build"] / "Dockerfile").read_text("utf-8")
    assert 'ENTRYPOINT ["lockprobe"]' in dockerfile
    assert COMPOSE["services"]["caddy"]["ports"] == ["80:80", "443:443"]  # a certificate needs both


@pytest.mark.parametrize(("environment", "refused"), [({}, "DOMAIN|LOCKPROBE_ADMIN_TOKEN"), (GIVEN, "")])
def test_compose_takes_the_file_once_the_environment_is_filled_in(compose, environment, refused):
    found = subprocess.run(
        [*compose, "--file", str(EXAMPLE / "compose.yaml"), "config"],
        env={"PATH": os.environ["PATH"], **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert bool(found.returncode) is bool(refused), found.stderr
    if refused:
        assert re.search(refused, found.stderr)
    else:
        assert (
            "--public-url=https://study.example.org" in yaml.safe_load(found.stdout)["services"]["lockprobe"]["command"]
        )


@pytest.mark.skipif(shutil.which("caddy") is None, reason="no caddy")
def test_caddy_takes_its_file():
    asked = ["caddy", "adapt", "--config", str(EXAMPLE / "Caddyfile"), "--validate"]
    found = subprocess.run(asked, env={**os.environ, **GIVEN}, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stderr
    assert '"dial":"lockprobe:8765"' in found.stdout


def test_the_command_is_one_that_lockprobe_takes(tmp_path, monkeypatch):
    from lockprobe.cli import serve

    said = []
    monkeypatch.setattr(
        serve, "_serve", lambda planned, directory, experiment, door, *, json: said.append((planned, experiment, door))
    )
    monkeypatch.chdir(tmp_path)
    line = (
        " ".join(SERVICE["command"]).replace("/settings/", f"{EXAMPLE}/settings/").replace("/studies/", f"{tmp_path}/")
    )
    monkeypatch.setattr("sys.argv", ["lockprobe", *shlex.split(re.sub(r"\$\{DOMAIN.*?\}", "study.example.org", line))])
    from lockprobe.cli import main

    with pytest.raises(SystemExit) as ended:
        main()
    assert not ended.value.code
    ((planned, experiment, door),) = said
    assert (planned.p, experiment.participants, experiment.require_id) == ((0.0, 0.4), 40, True)
    assert door["public"] == "https://study.example.org"


def test_the_ids_are_those_of_prolific_and_every_end_has_a_code_of_its_own():
    assert set(EXPERIMENT.recruitment) <= set(PLACEHOLDERS)
    ends = ("completion", "declined", "screened", "late", "withdrawn", "full")
    codes = [getattr(EXPERIMENT, f"{end}_code") for end in ends]
    assert len(set(codes)) == len(ends)
    for end, code in zip(ends, codes, strict=True):
        assert getattr(EXPERIMENT, f"{end}_url") == f"https://app.prolific.com/submissions/complete?cc={code}"


def test_whoever_comes_from_the_platform_goes_back_with_the_code_and_the_check_is_counted(tmp_path):
    study = people_study(max_steps=3)

    async def plays():
        async with opened(tmp_path, study, EXPERIMENT) as reception:
            ids = {"PROLIFIC_PID": "5f1", "STUDY_ID": "60a", "SESSION_ID": "61b"}
            shown = await reception.enter(None, ids)
            shown = await reception.act(shown.token, shown.lease, 1, Agree(agreed=True), ids)
            shown = await go_on(reception, Player(tmp_path, study, "random"), shown)
            return shown.scene, reception.progress()

    end, progress = asyncio.run(plays())
    assert (end.kind, end.completion_code) == ("debrief", "COMPLETED")
    assert (progress.finished, progress.checks_right, progress.checks_wrong) == (
        1,
        0,
        1,
    )  # wrong, and paid all the same

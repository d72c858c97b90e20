"""The driver's side of a cluster, with a fake Ray that loses what it is told to lose, and clusters that do not answer."""

import socket
import sys
from types import SimpleNamespace

import pytest

from lockprobe.foundation.errors import BadValue, Missing
from lockprobe.foundation.workers import Cluster, Lost, cluster


class RayError(Exception):
    pass


class RayTaskError(RayError):
    def __init__(self, cause):
        super().__init__(str(cause))
        self.cause = cause


class FakeRay:
    """Calls are answered in order, in this process. ``lose(actor, job)`` names an error instead."""

    exceptions = SimpleNamespace(RayError=RayError, RayTaskError=RayTaskError)

    def __init__(self, processors=2, lose=lambda actor, job: None):
        self.processors, self.lose = processors, lose
        self.actors = self.calls = 0
        self.killed, self.worked = set(), []

    def nodes(self):
        node = {"Alive": True, "Resources": {"CPU": float(self.processors)}}
        return [node, node | {"Alive": False}, node | {"Resources": {}}]

    def remote(self, **options):
        assert options == {"num_cpus": 1, "max_restarts": 0, "max_task_retries": 0}
        return lambda kind: SimpleNamespace(remote=lambda begin: self._actor(kind(begin)))

    def _actor(self, made):
        self.actors += 1
        number = self.actors
        return SimpleNamespace(
            number=number,
            ready=SimpleNamespace(remote=lambda: self._call(number, made.ready, None)),
            work=SimpleNamespace(remote=lambda job: self._call(number, made.work, job)),
        )

    def _call(self, actor, method, job):
        self.calls += 1
        return (self.calls, actor, method, job)

    def wait(self, calls, num_returns, timeout):
        return calls[:num_returns], calls[num_returns:]

    def get(self, call):
        _, actor, method, job = call
        if (error := self.lose(actor, job)) is not None:
            raise type(error, (RayError,), {})
        try:
            answer = method() if job is None else method(job)
        except Exception as error:
            raise RayTaskError(error) from error
        self.worked += [] if job is None else [job]
        return answer

    def kill(self, actor):
        self.killed.add(actor.number)


@pytest.fixture(autouse=True)
def known_versions(monkeypatch):
    monkeypatch.setattr(cluster, "_versions", lambda: {"lockprobe": "1", "Ray": "2", "Python": "3"})


def squares():
    return lambda job: job * job


def results_of(ray, jobs=range(40)):
    return list(Cluster(ray).each(squares, jobs))


def test_every_job_has_one_result():
    assert sorted(results_of(ray := FakeRay())) == [(job, job * job) for job in range(40)]
    assert ray.actors == 2
    assert ray.killed == {1, 2}
    assert sorted(ray.worked) == list(range(40))


@pytest.mark.parametrize("lost", [0, 7, 39])
def test_a_lost_actors_job_is_done_by_another_one(lost):
    sent = []

    def lose(actor, job):
        if job == lost:
            sent.append(actor)
        return "ActorDiedError" if job == lost and len(sent) == 1 else None

    ray = FakeRay(lose=lose)
    assert sorted(results_of(ray)) == [(job, job * job) for job in range(40)]
    assert ray.killed == {*range(1, ray.actors + 1)} >= {1, 2, 3}
    assert len({*sent}) == len(sent) == 2


def test_a_job_that_kills_every_actor_is_given_up_and_the_others_are_done():
    ray = FakeRay(lose=lambda actor, job: "ActorDiedError" if job == 5 else None)
    found = dict(results_of(ray, range(400)))
    assert found.pop(5) == Lost("ActorDiedError")
    assert found == {job: job * job for job in range(400) if job != 5}


def test_losses_in_a_row_end_the_work():
    often = "workers were lost 4 times in a row, with nothing finished in between .ActorDiedError"
    with pytest.raises(Missing, match=often):
        results_of(FakeRay(lose=lambda actor, job: "ActorDiedError"))


@pytest.mark.parametrize("address", ["", "here", "host:", ":1", "host:0", "host:x", "ray://host:1", "host:99999"])
def test_what_is_no_address_is_refused(address):
    with pytest.raises(BadValue, match="auto, or HOST:PORT of the head node"), Cluster.connect(address):
        pass


def test_where_nobody_listens_nobody_waits_and_without_ray_it_is_said_how_to_get_it(monkeypatch):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        with pytest.raises(Missing, match=f"no Ray cluster answers at {address}"), Cluster.connect(address):
            pass
    monkeypatch.setitem(sys.modules, "ray", None)
    expected = r"clusters need the package ray: uv sync --extra cluster"
    with pytest.raises(Missing, match=expected), Cluster.connect("auto"):
        pass

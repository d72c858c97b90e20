"""What every simulated plant needs is checked before one is made, in one line."""

import pytest
from lockprobe_robot.rendering.probe import require_mujoco

from lockprobe.foundation.errors import BadValue, Missing


@pytest.mark.parametrize(("module", "package"), [("mujoco", "mujoco"), ("PIL", "pillow")])
def test_a_missing_package_is_one_line_that_says_how_to_install_it(monkeypatch, module, package):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == module else object())
    with pytest.raises(Missing, match=rf"^the twins need the package {package}.*pip install 'lockprobe\[twin\]'"):
        require_mujoco()


def test_a_platform_of_opengl_that_does_not_work_here_is_named(monkeypatch):
    def fail(name):
        raise RuntimeError(name)

    monkeypatch.setenv("MUJOCO_GL", "no-such-platform")
    monkeypatch.setattr("importlib.import_module", fail)
    with pytest.raises(BadValue, match="^MUJOCO_GL: got 'no-such-platform', expected a platform that works here"):
        require_mujoco()


def test_a_complete_machine_passes(monkeypatch):
    pytest.importorskip("mujoco")
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    require_mujoco()

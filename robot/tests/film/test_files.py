"""Films as files: what is added is what is played, for as long as was asked."""

import re
import subprocess
import sys

import numpy as np
import pytest
from lockprobe_robot.film import files
from lockprobe_robot.film.files import open_film
from PIL import Image

from lockprobe.foundation.errors import BadFile, BadValue, Missing
from lockprobe.foundation.storage.atomic_file import write_file


def picture(row):
    """Grey with a red line in one row; wide as it is to be compressed well."""
    painted = np.full((48, 64, 3), 128, np.uint8)
    painted[row] = (190, 30, 30)
    return painted


def shot(path, seconds=(0.4, 1.2, 0.08)):
    film = open_film(path)
    for row, lasting in enumerate(seconds):
        film.add(picture(10 * row), lasting)
    film.close()
    return path


def test_a_gif_holds_the_pictures_and_their_times(tmp_path):
    with Image.open(shot(tmp_path / "a.gif")) as gif:
        assert (gif.n_frames, gif.size, gif.info["loop"]) == (3, (64, 48), 0)
        for i, milliseconds in enumerate((400, 1200, 80)):
            gif.seek(i)
            assert gif.info["duration"] == milliseconds
            seen = np.asarray(gif.convert("RGB")).astype(int)
            assert abs(seen - picture(10 * i)).max() <= 8
    assert [path.name for path in tmp_path.iterdir()] == ["a.gif"]


def test_what_stays_still_costs_nothing(tmp_path):
    still = open_film(tmp_path / "still.gif")
    rng = np.random.default_rng(0)
    noisy = rng.integers(0, 256, (48, 64, 3), dtype=np.uint8)
    for i in range(50):
        changed = noisy.copy()
        changed[:4, :4] = i % 2 * 255
        still.add(changed, 0.08)
    still.close()
    one = open_film(tmp_path / "one.gif")
    one.add(noisy, 0.08)
    one.close()
    size = {path.stem: path.stat().st_size for path in tmp_path.iterdir()}
    assert size["still"] < size["one"] + 50 * 100


def test_a_colour_that_comes_late_is_there(tmp_path):
    film = open_film(tmp_path / "late.gif")
    film.add(np.full((48, 64, 3), 128, np.uint8), 0.4)
    film.add(picture(5), 0.4)
    film.close()
    with Image.open(tmp_path / "late.gif") as gif:
        gif.seek(1)
        assert gif.convert("RGB").getpixel((3, 5)) == (190, 30, 30)


def test_an_mp4_lasts_as_long_as_was_asked(tmp_path):
    import imageio_ffmpeg

    path = shot(tmp_path / "a.mp4", seconds=(0.4, 1.2, 0.02, 0.02, 0.4))
    pictures, seconds = imageio_ffmpeg.count_frames_and_secs(str(path))
    assert pictures == 51  # two halves of a picture are one
    assert seconds == pytest.approx(2.04, abs=0.05)
    said = subprocess.run([imageio_ffmpeg.get_ffmpeg_exe(), "-i", path], capture_output=True, text=True).stderr
    assert re.search(r"Video: h264.*yuv420p.*64x48", said)
    assert [path.name for path in tmp_path.iterdir()] == ["a.mp4"]


def test_a_directory_gets_every_picture(tmp_path):
    shot(tmp_path / "frames")
    assert sorted(path.name for path in (tmp_path / "frames").iterdir()) == [f"0000{i}.png" for i in (1, 2, 3)]
    with Image.open(tmp_path / "frames" / "00002.png") as second:
        assert (np.asarray(second) == picture(10)).all()
    with pytest.raises(BadFile, match="is there and not an empty directory"):
        open_film(tmp_path / "frames")


@pytest.mark.parametrize("name", ["a.gif", "a.mp4", "pictures"])
def test_a_film_is_there_from_its_first_picture_on_and_without_one_there_is_none(tmp_path, name):
    open_film(tmp_path / name).close()
    assert list(tmp_path.iterdir()) == []
    film = open_film(tmp_path / name)
    film.add(picture(0), 0.4)
    write_file(tmp_path / "beside.csv", "")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([name, "beside.csv"])
    film.close()
    film.close()


def test_a_film_whose_process_is_killed_plays_up_to_there(tmp_path):
    code = f"""
import os, signal, sys
import numpy as np
from lockprobe_robot.film.files import open_film
for name in ("a.gif", "a.mp4"):
    film = open_film(__import__("pathlib").Path({str(tmp_path)!r}, name))
    for shade in range(60):
        painted = np.full((48, 64, 3), 128, np.uint8)
        painted[shade % 48] = (190, 30, 30)
        film.add(painted, 0.08)
    keep = globals().setdefault("keep", []) + [film]
os.kill(os.getpid(), signal.SIGKILL)
"""
    assert subprocess.run([sys.executable, "-c", code]).returncode == -9
    with Image.open(tmp_path / "a.gif") as gif:
        assert gif.n_frames >= 59
        gif.seek(58)
        assert gif.convert("RGB").getpixel((3, 58 % 48)) == (190, 30, 30)
    import imageio_ffmpeg

    assert imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "a.mp4"))[0] >= 25


def test_what_cannot_be_written_is_refused_before_anything_is_played(tmp_path, monkeypatch):
    with pytest.raises(BadValue, match=r"out: got '.*a\.avi', expected a name that ends in \.gif or \.mp4"):
        open_film(tmp_path / "a.avi")
    with pytest.raises(BadFile, match="its directory does not exist"):
        open_film(tmp_path / "no" / "a.gif")
    missing = "imageio_ffmpeg"
    monkeypatch.setattr(files.importlib.util, "find_spec", lambda name: None if name == missing else name)
    with pytest.raises(Missing, match=r"MP4 needs the package imageio-ffmpeg: pip install 'lockprobe-robot\[film\]'"):
        open_film(tmp_path / "a.mp4")
    missing = "PIL"
    with pytest.raises(Missing, match=r"films need the package pillow: pip install 'lockprobe\[twin\]'"):
        open_film(tmp_path / "a.gif")

"""No picture that a record names is lost in a log: what no message shows is kept beside."""

import base64

import pytest
from builders import make_trial

from lockprobe.trial.pictures.picture import Picture

album = pytest.importorskip("lockprobe.interfaces.inspect.sample_pictures")

from inspect_ai.model import ChatMessageUser, ContentImage, ContentText  # noqa: E402


def test_only_what_is_not_shown_is_kept_beside(tmp_path):
    shown, kept, gone = (Picture(kind="rgb", png=png) for png in (b"shown", b"kept", b"gone"))
    for picture in (shown, kept):
        (tmp_path / picture.name).write_bytes(picture.png)
    names = {"rgb": shown.name, "depth16": kept.name, "depth": gone.name}
    uri = "data:image/png;base64," + base64.b64encode(shown.png).decode()
    message = ChatMessageUser(content=[ContentText(text="x"), ContentImage(image=uri)])
    store = album.beside(make_trial([0], budget=1, pictures=[names]), [message], tmp_path)
    assert list(store[album.PICTURES]) == [kept.name]
    assert dict(album.pictures_of([message], store)) == {shown.name: shown.png, kept.name: kept.png}


@pytest.mark.parametrize(
    "uri", ["https://example.org/x.png", "data:image/png;base64,!!", "", "data:text/html;base64,eA=="]
)
def test_what_is_no_picture_is_passed_over(uri):
    assert list(album.pictures_of([], {album.PICTURES: {"x": uri, "y": 3}})) == []
    assert list(album.pictures_of([], {album.PICTURES: "no mapping"})) == []

"""A stand-in for OpenCV's webcam."""

from types import SimpleNamespace


class FakeCapture:
    """Hands out what ``show`` returns, in OpenCV's order of colours; None is a failure. Five frames in front are stale."""

    def __init__(self, show, opens=True):
        self.show, self.opens, self.grabbed, self.released = show, opens, 0, False

    def isOpened(self):  # noqa: N802 - OpenCV's name
        return self.opens

    def grab(self):
        self.grabbed += 1

    def read(self):
        picture = self.show()
        return picture is not None, None if picture is None else picture[..., ::-1]

    def release(self):
        self.released = True


def fake_cv2(capture):
    logging = SimpleNamespace(setLogLevel=lambda level: None, LOG_LEVEL_SILENT=0)
    return SimpleNamespace(
        VideoCapture=lambda device: capture, error=RuntimeError, utils=SimpleNamespace(logging=logging)
    )

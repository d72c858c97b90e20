"""Drawn pictures of a board with handles: wood with a grain, dark ways, marks at their ends, shadows, noise."""

import numpy as np

from lockprobe.interventions.camera import encode
from lockprobe.trial.pictures.frame import to_png
from lockprobe.trial.pictures.picture import Picture

WIDTH, HEIGHT = 320, 240
HANDLES = tuple(((40.0 + 60 * i, 90.0 + 20 * (i % 2)), (40.0 + 60 * i, 140.0 + 20 * (i % 2))) for i in range(5))


def board(positions, seed=1):
    """The picture in colours, shape (240, 320, 3), 0 to 255."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    grain = 1 + 0.08 * np.sin(y / 3 + rng.random() * 6)
    image = grain[..., None] * np.array((0.80, 0.63, 0.43))
    for place, position in zip(HANDLES, positions, strict=True):
        (left, top), (_, bottom) = place
        image[(abs(x - left) < 5) & (y > top) & (y < bottom)] = 0.1
        for (column, row), shade in zip(place, (0.95, 0.12), strict=True):
            image[(x - column) ** 2 + (y - row) ** 2 < 14**2] = 0.95
            image[(x - column) ** 2 + (y - row) ** 2 < 11**2] = shade
        column, row = place[position]
        image[(x - column - 8) ** 2 + (y - row - 6) ** 2 < 11**2] *= 0.45
        image[(x - column) ** 2 + (y - row) ** 2 < 11**2] = (0.86, 0.13, 0.10)
    angle = rng.random() * 6.28
    lit = 1 + 0.3 * ((x / WIDTH - 0.5) * np.cos(angle) + (y / HEIGHT - 0.5) * np.sin(angle))
    image = image * lit[..., None] + 0.02 * rng.standard_normal(image.shape)
    return (255 * np.clip(image, 0, 1)).astype(np.uint8)


def coloured(positions, seed=1):
    """The picture as a file."""
    return Picture(kind="rgb", png=to_png(board(positions, seed)))


def in_depth(positions, seed=1):
    """Depth of a tilted board in colours, red is near, black is no reading, as a file."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    depth = 0.72 - 0.10 * y / HEIGHT
    for place, position in zip(HANDLES, positions, strict=True):
        column, row = place[position]
        depth[(x - column) ** 2 + (y - row) ** 2 < 11**2] -= 0.05
    depth += 0.0005 * np.random.default_rng(seed).standard_normal(depth.shape)
    depth[:8] = depth[-8:] = 0
    shown = encode(depth.astype(np.float32), 0.5, 0.8)
    return Picture(kind="depth", png=to_png(shown))


def deep(positions, away=0.72):
    """Depth in metres from straight above: a board so far away, and handles that stand 5 cm out of it."""
    y, x = np.mgrid[:HEIGHT, :WIDTH]
    depth = np.full((HEIGHT, WIDTH), away, np.float32)
    for place, position in zip(HANDLES, positions, strict=True):
        column, row = place[position]
        depth[(x - column) ** 2 + (y - row) ** 2 < 11**2] -= 0.05
    return depth


def heights_at(camera, depth):
    """The heights above the board, metres, of what is seen at a depth: they are linear in it."""
    z, (down, right) = camera.panel[:3, 2], np.mgrid[: camera.height, : camera.width]
    right, down = right - (camera.width - 1) / 2, down - (camera.height - 1) / 2
    return depth * ((z[0] * right + z[1] * down) / camera.focal + z[2]) - float(z @ camera.panel[:3, 3])

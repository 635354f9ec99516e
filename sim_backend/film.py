"""Films a simulated robot: notes its poses while it walks, draws them afterwards into an animated GIF."""

import contextlib
import copy
import io
import itertools
import math
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import mujoco
import numpy as np
from PIL import Image, ImageChops, ImageDraw, ImageFont

from robotwalk.errors import UsageError
from sim_backend.drawing import ELEVATION_DEG, CapsulePainter, Painter, View, azimuth_deg
from sim_backend.relief import TILE_M
from sim_backend.solids import Array
from sim_backend.terrain.course import FLAT, Ground

_MAX_FPS = 50  # common viewers slow a GIF down whose frames last less than 20 ms
_FOLLOW_S = 0.5  # the camera follows the body's path, smoothed by a Gaussian of this width
_FRAMING = 1.15  # larger shows more around the robot
_LOWERED = 0.15  # of the reach: how far below the body the camera looks
_TRAIL_FRAMES = 200
_PALETTE_FRAMES = 8  # the shared palette is chosen from as many
_COLOURS = 63  # 64 with the transparent one; more make the file larger, hardly the picture better
_TRANSPARENT = 63  # marks pixels that stay as they were
_UNSEEN = 9  # a smaller change of a pixel, of 255, is left out
_GL_FLOOR = np.array([0.80, 0.82, 0.85, 1.0], np.float32)
_GL_TILE = np.array([0.72, 0.74, 0.78, 1.0], np.float32)
_GL_TILES = 10  # to each side of the robot
_GL_TILE_HEIGHT_M = 0.0005
_GL_OFF = ("disable", "disabled", "off", "false", "0")  # values of MUJOCO_GL, from MuJoCo's gl_context


class Shot(NamedTuple):
    """What is kept of one frame until it is drawn."""

    slot: int  # number of frame periods since the start
    qpos: Array
    caption: str


class Film:
    """Poses of one model at `fps` frames per second of simulated time."""

    def __init__(
        self, model: mujoco.MjModel, *, ground: Ground = FLAT, fps: int = 20, size: tuple[int, int] = (480, 320),
    ) -> None:
        if not 1 <= fps <= _MAX_FPS:
            raise UsageError(f"a film has 1 to {_MAX_FPS} frames per second, not {fps}")
        self._model, self._ground = model, ground
        self._fps = fps
        self._size = size
        self._shots: list[Shot] = []
        self._start: float | None = None
        self._slot = 0

    def due(self, sim_seconds: float) -> bool:
        """Return whether the next frame is to be shot now. The first call starts the film."""
        if self._start is None:
            self._start = sim_seconds
        self._slot = math.floor((sim_seconds - self._start) * self._fps + 1e-6)
        return not self._shots or self._slot > self._shots[-1].slot

    def shoot(self, data: mujoco.MjData, caption: str) -> None:
        """Take down the pose as it is now. Takes microseconds."""
        after_last = self._shots[-1].slot + 1 if self._shots else 0
        self._shots.append(Shot(max(self._slot, after_last), data.qpos.copy(), caption))

    def save(self, path: Path, progress: Callable[[float], None] | None = None) -> None:
        """Draw the frames and write them as a GIF that loops.

        Args:
            path: the file; one that is there is replaced.
            progress: is told the share that is done, 0 to 1.

        Raises:
            UsageError: no frame was shot, or the file cannot be written.
        """
        if not self._shots:
            raise UsageError(f"cannot write {path}: the film has no frames")
        check_writable(path)
        with _painter(self._model, self._size, self._ground) as painter:
            content = self._encode(painter, progress or (lambda share: None))
        try:
            path.write_bytes(content)
        except OSError as error:
            raise UsageError(f"cannot write {path}: {error.strerror}") from error

    def _encode(self, painter: Painter, progress: Callable[[float], None]) -> bytes:
        data = mujoco.MjData(self._model)
        views = _views(self._model, data, self._shots, self._fps, azimuth_deg(self._ground))

        def draw(number: int) -> Image.Image:
            shot = self._shots[number]
            _pose(self._model, data, shot)
            picture = painter.paint(data, views[number])
            _write_caption(picture, shot.caption)
            return picture

        palette = _shared_palette([draw(number) for number in _spread(len(self._shots), _PALETTE_FRAMES)])

        def frames() -> Iterator[Image.Image]:
            shown = draw(0)
            for number in range(len(self._shots)):
                shown = _with_visible_changes(shown, draw(number))
                frame = shown.quantize(palette=palette, dither=Image.Dither.NONE)
                frame.putpalette(_with_transparent(palette))
                progress((number + 1) / len(self._shots))
                yield frame

        rest = frames()
        first = next(rest)
        buffer = io.BytesIO()
        first.save(
            buffer, "GIF", save_all=True, append_images=rest, duration=self._durations_ms(), loop=0,
            palette=_with_transparent(palette), transparency=_TRANSPARENT, optimize=True, disposal=1,
        )
        return buffer.getvalue()

    def _durations_ms(self) -> list[int]:
        """Return how long each frame is shown; a GIF counts in 10 ms."""
        slots = [shot.slot for shot in self._shots]
        ticks = [round(100 * slot / self._fps) for slot in [*slots, slots[-1] + 1]]
        return [10 * (after - before) for before, after in itertools.pairwise(ticks)]


def check_writable(path: Path) -> None:
    """Find out before the walk whether a file can be written. A file that is there stays as it is.

    Raises:
        UsageError: it cannot.
    """
    try:
        is_new = not os.path.lexists(path)
        path.open("ab").close()
        if is_new:
            path.unlink()
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from error


class GlPainter:
    """Paints with MuJoCo's renderer, on the GL that MuJoCo chose when it was imported (see MUJOCO_GL)."""

    def __init__(self, model: mujoco.MjModel, size: tuple[int, int], ground: Ground) -> None:
        self._ground = ground
        self._model = copy.copy(model)  # the light and the ground's colour are the film's own
        self._model.stat.extent = min(self._model.stat.extent, 2.0)  # else tiles flicker: it sets the depth's grain
        self._model.vis.quality.shadowsize = 1024  # the default, 4096, takes 0.1 s a frame in software
        self._model.vis.headlight.ambient[:] = 0.4
        self._model.vis.headlight.diffuse[:] = 0.4
        self._model.geom_rgba[model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE] = _GL_FLOOR
        self._renderer = mujoco.Renderer(self._model, width=size[0], height=size[1])

    def paint(self, data: mujoco.MjData, view: View) -> Image.Image:
        """Return an RGB picture of the film's size."""
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:] = view.target
        camera.distance, camera.azimuth, camera.elevation = view.distance, view.azimuth_deg, ELEVATION_DEG
        mujoco.mj_comPos(self._model, data)  # lights may follow a centre of mass
        mujoco.mj_camlight(self._model, data)
        self._renderer.update_scene(data, camera)
        self._add_tiles(view.target)
        return Image.fromarray(self._renderer.render())

    def _add_tiles(self, target: Array) -> None:
        """Lay every other tile on the ground where it is level, so that the robot is seen to move."""
        scene = self._renderer.scene
        first, second = (2 * round(float(target[axis]) / (2.0 * TILE_M)) for axis in (0, 1))
        for column in range(first - _GL_TILES, first + _GL_TILES):
            for row in range(second - _GL_TILES + column % 2, second + _GL_TILES, 2):
                heights = {
                    self._ground.height((column + dx) * TILE_M, (row + dy) * TILE_M)
                    for dx in (0.01, 0.5, 0.99) for dy in (0.01, 0.5, 0.99)}
                if len(heights) > 1:
                    continue
                centre = np.array([(column + 0.5) * TILE_M, (row + 0.5) * TILE_M, heights.pop()])
                size = np.array([0.5 * TILE_M, 0.5 * TILE_M, _GL_TILE_HEIGHT_M])
                kind = mujoco.mjtGeom.mjGEOM_BOX
                mujoco.mjv_initGeom(scene.geoms[scene.ngeom], kind, size, centre, np.eye(3).ravel(), _GL_TILE)
                scene.ngeom += 1

    def close(self) -> None:
        """Give the GL context back."""
        self._renderer.close()


@contextlib.contextmanager
def _painter(model: mujoco.MjModel, size: tuple[int, int], ground: Ground) -> Iterator[Painter]:
    """Provide MuJoCo's renderer where it works, else the painter that needs no GL."""
    gl_painter = _open_gl_painter(model, size, ground) if _gl_is_likely() else None
    if gl_painter is None:
        yield CapsulePainter(model, size, ground)
        return
    with contextlib.closing(gl_painter):
        yield gl_painter


def _gl_is_likely() -> bool:
    """Return whether a try is worth its time: a backend was asked for, or there is a screen."""
    asked = os.environ.get("MUJOCO_GL", "").lower().strip()
    if asked:
        return asked not in _GL_OFF
    return sys.platform != "linux" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _open_gl_painter(model: mujoco.MjModel, size: tuple[int, int], ground: Ground) -> GlPainter | None:
    with _silence():
        try:
            return GlPainter(model, size, ground)
        except Exception:  # each GL backend fails in its own way: AttributeError, FatalError, GLError
            return None


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """Keep what GL libraries and their wrappers print from the user."""
    sys.stderr.flush()
    saved = os.dup(2)
    try:
        with open(os.devnull, "wb") as nowhere, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            os.dup2(nowhere.fileno(), 2)
            yield
    finally:
        os.dup2(saved, 2)
        os.close(saved)


def _pose(model: mujoco.MjModel, data: mujoco.MjData, shot: Shot) -> None:
    data.qpos[:] = shot.qpos
    mujoco.mj_kinematics(model, data)


def _views(
    model: mujoco.MjModel, data: mujoco.MjData, shots: list[Shot], fps: int, azimuth: float
) -> list[View]:
    """Plan the camera's way: it follows the body smoothly and keeps its direction and distance."""
    free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    body = int(model.jnt_bodyid[free[0]]) if free.size else min(1, model.nbody - 1)
    geoms = np.flatnonzero(model.body_rootid[model.geom_bodyid] == body)
    path, reach = np.zeros((len(shots), 3)), 0.0
    for number, shot in enumerate(shots):
        _pose(model, data, shot)
        path[number] = data.xpos[body]
        extent = np.linalg.norm(data.geom_xpos[geoms] - path[number], axis=1) + model.geom_rbound[geoms]
        reach = max(reach, float(extent.max(initial=0.0)))
    reach = reach or 1.0
    distance = _FRAMING * reach / math.tan(math.radians(model.vis.global_.fovy) / 2.0)
    targets = _smooth(path, _FOLLOW_S * fps) - np.array([0.0, 0.0, _LOWERED * reach])
    return [
        View(targets[number], distance, reach, path[max(0, number + 1 - _TRAIL_FRAMES) : number + 1], azimuth)
        for number in range(len(shots))
    ]


def _smooth(path: Array, width: float) -> Array:
    """Return `path` (n, 3) smoothed without delay by a Gaussian of `width` samples."""
    radius = math.ceil(3.0 * width)
    weights = np.exp(-0.5 * (np.arange(-radius, radius + 1) / width) ** 2)
    padded = np.pad(path, ((radius, radius), (0, 0)), mode="reflect", reflect_type="odd")
    columns = [np.convolve(column, weights / weights.sum(), mode="valid") for column in padded.T]
    return np.column_stack(columns)


def _spread(count: int, most: int) -> list[int]:
    """Return up to `most` numbers below `count`, evenly spread."""
    return sorted({round(float(number)) for number in np.linspace(0, count - 1, most)})


def _write_caption(picture: Image.Image, caption: str) -> None:
    """Write a line on a label in the upper left corner."""
    if not caption:
        return
    height = max(11, picture.height // 24)
    font = ImageFont.load_default(height)
    draw = ImageDraw.Draw(picture)
    corner, pad = height * 0.8, height * 0.5
    left, top, right, bottom = draw.textbbox((corner + pad, corner + pad), caption, font, anchor="lt")
    draw.rounded_rectangle((left - pad, top - pad, right + pad, bottom + pad), pad, fill=(255, 255, 255))
    draw.text((corner + pad, corner + pad), caption, (38, 56, 84), font, anchor="lt")


def _with_visible_changes(shown: Image.Image, new: Image.Image) -> Image.Image:
    """Return `new`, but as `shown` where nobody sees the difference: this halves the file."""
    red, green, blue = ImageChops.difference(shown, new).split()
    change = ImageChops.lighter(ImageChops.lighter(red, green), blue)
    return Image.composite(new, shown, change.point([0] * _UNSEEN + [255] * (256 - _UNSEEN)))


def _shared_palette(samples: list[Image.Image]) -> Image.Image:
    """Choose the colours for a whole film from some of its frames."""
    pixels = np.concatenate([np.asarray(sample).reshape(-1, 3) for sample in samples]).astype(np.uint32)
    codes, counts = np.unique(pixels @ np.array([1 << 16, 1 << 8, 1], np.uint32), return_counts=True)
    colours = np.stack([codes >> 16, codes >> 8 & 255, codes & 255], axis=1).astype(np.uint8)
    # The ground has most of the pixels: a weight below their number leaves colours for the robot.
    weighted = np.repeat(colours, np.ceil(counts**0.6).astype(int), axis=0)
    sheet = Image.fromarray(weighted[None])
    return sheet.quantize(_COLOURS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def _with_transparent(palette: Image.Image) -> bytes:
    """Return the palette's colours, with one more behind them for `_TRANSPARENT`."""
    colours = bytes(palette.getpalette("RGB") or [])[: 3 * _COLOURS]
    return colours.ljust(3 * _COLOURS, b"\0") + b"\xff\x00\xff"

"""Paints a MuJoCo scene with Pillow alone: the same picture on every machine, GL or not.

Limbs are flat areas of a few tones, painted from far to near over a tiled ground with soft shadows.
Every area is the exact outline of "lit at least this much" on its solid, so the tones meet without seams.
Whatever could fade smoothly goes in steps: few colours keep a GIF small.
Drawn: planes (the first one, as the ground), boxes, capsules, spheres, and the shapes of a ground, over which
the robot is always seen. Other geoms are left out.
"""

import math
from typing import NamedTuple, Protocol

import mujoco
import numpy as np
from PIL import Image, ImageChops, ImageDraw, ImageFilter

from sim_backend.relief import TILE_M, Relief
from sim_backend.solids import LIGHT, Array, Box, Capsule, Solid, unit
from sim_backend.terrain.build import GROUP
from sim_backend.terrain.course import FLAT, Ground

Colour = tuple[int, int, int]

AZIMUTH_DEG = 118.0  # three-quarter view: a robot that walks along x comes towards the viewer's right
_FROM_BEHIND_DEG = 60.0
_FAR_AHEAD_M = 10.0
ELEVATION_DEG = -31.0

_SUPERSAMPLING = 2
_SKY: Colour = (226, 233, 240)  # where the ground fades out
_FLOOR: Colour = (247, 249, 251)
_INK: Colour = (38, 56, 84)  # tiles and shadows
_TRAIL: Colour = (240, 178, 122)
_SLIPPERY: Colour = (70, 150, 215)
_FAR_RELIEF = 0.4  # how much of the ground's shades is seen far away
_FOOTING_M = 0.15  # the ground is taken as plane so far around the robot, for its shadow
_TILES = 32  # to each side of the robot
_TILE_DARKNESS = 14  # of 255
_SHADOW_DARKNESS = 75  # of 255
_SHADOW_STEPS = 3
_FLOOR_STEPS = 10
_NEAR_M = 0.05  # the camera sees nothing nearer than this
_HAZE = 0.42  # how far the robot's far side fades into the sky
_HAZE_STEPS = 5
_OUTLINE = 0.011  # of the camera's distance
_DEFAULT_GROUPS = 3  # MuJoCo's viewers show the geom groups 0, 1 and 2

_EDGE_TONE = -0.62


def azimuth_deg(ground: Ground) -> float:
    """Return whence a ground is seen best: uphill from behind, where risers face the viewer, else from before."""
    uphill = ground.shapes and ground.height(_FAR_AHEAD_M, 0.0) >= 0.0
    return _FROM_BEHIND_DEG if uphill else AZIMUTH_DEG


class View(NamedTuple):
    """What the camera sees of the world in one frame."""

    target: Array  # m, the point in the middle of the picture
    distance: float  # m, from the camera to the target
    reach: float  # m, how far the robot extends around the target
    trail: Array  # (n, 3), m, where the body has been
    azimuth_deg: float = AZIMUTH_DEG


class Painter(Protocol):
    """Makes a picture of a posed robot."""

    def paint(self, data: mujoco.MjData, view: View) -> Image.Image:
        """Return an RGB picture of the film's size."""
        ...


class Camera:
    """A pinhole camera; x goes right and y down in the picture, in pixels."""

    def __init__(self, view: View, fovy_deg: float, size: tuple[int, int]) -> None:
        azimuth, elevation = math.radians(view.azimuth_deg), math.radians(ELEVATION_DEG)
        level = math.cos(elevation)
        forward = np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation)])
        right = np.array([math.sin(azimuth), -math.cos(azimuth), 0.0])
        self._axes = np.column_stack([right, np.cross(forward, right), forward])
        self._centre = 0.5 * np.array(size)
        self._focal = 0.5 * size[1] / math.tan(math.radians(fovy_deg) / 2.0)
        self.eye: Array = view.target - view.distance * forward

    def project(self, points: Array) -> Array:
        """Return the pixels (n, 2) of points (n, 3) in the world."""
        seen = (points - self.eye) @ self._axes
        pixels: Array = self._centre + self._focal * seen[:, :2] / seen[:, 2:]
        return pixels

    def fill(
        self, draw: ImageDraw.ImageDraw, polygon: Array, colour: Colour | int, outline: int | None = None
    ) -> None:
        """Draw what of a polygon (n, 3) is before the camera."""
        depth = (polygon - self.eye) @ self._axes[:, 2] - _NEAR_M
        if depth.min() < 0.0:
            polygon = _cut(polygon, depth)
        if len(polygon) > 2:
            draw.polygon(self.project(polygon).ravel().tolist(), fill=colour, outline=outline)

    def project_lines(self, starts: Array, ends: Array) -> tuple[Array, Array]:
        """Return the pixels (m, 2) of the ends of line segments (n, 3), less what lies behind the camera."""
        forward = self._axes[:, 2]
        before, after = (starts - self.eye) @ forward - _NEAR_M, (ends - self.eye) @ forward - _NEAR_M
        seen = (before > 0.0) | (after > 0.0)
        starts, ends, before, after = starts[seen], ends[seen], before[seen, None], after[seen, None]
        cut = starts + before / np.where(before == after, 1.0, before - after) * (ends - starts)
        starts, ends = np.where(before < 0.0, cut, starts), np.where(after < 0.0, cut, ends)
        return self.project(starts), self.project(ends)


class CapsulePainter:
    """Paints the model's geoms; see the module."""

    def __init__(self, model: mujoco.MjModel, size: tuple[int, int], ground: Ground = FLAT) -> None:
        self._model = model
        self._ground_shape, self._relief = ground, Relief(ground) if ground.shapes else None
        self._size = (size[0] * _SUPERSAMPLING, size[1] * _SUPERSAMPLING)
        self._fovy_deg = float(model.vis.global_.fovy)
        shown = (model.geom_group < _DEFAULT_GROUPS) & (model.geom_rgba[:, 3] > 0.0)
        if self._relief is not None:
            shown &= model.geom_group != GROUP
        self._geoms = [int(geom) for geom in np.flatnonzero(shown)]
        planes = np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_PLANE)
        self._ground = int(planes[0]) if planes.size else None
        self._floor, self._fade, self._haze = _floor(self._size), _tile_strength(size), _relief_strength(self._size)

    def paint(self, data: mujoco.MjData, view: View) -> Image.Image:
        """Return an RGB picture of the film's size."""
        camera = Camera(view, self._fovy_deg, self._size)
        solids = self._solids(data)
        picture = self._paint_ground(camera, data, view, list(solids.values()))
        draw = ImageDraw.Draw(picture)

        def order(geom: int) -> tuple[bool, float]:
            """Put the terrain behind the robot, and what is far behind what is near."""
            robot = bool(self._model.geom_bodyid[geom] != 0)
            return robot, -float(np.linalg.norm(solids[geom].centre - camera.eye))

        for geom in sorted(solids, key=order):
            solid = solids[geom]
            towards = unit(camera.eye - solid.centre)
            colour = self._model.geom_rgba[geom, :3]
            depth = float((view.target - solid.centre) @ unit(camera.eye - view.target)) / view.reach
            haze = _HAZE * round(_HAZE_STEPS * min(1.0, max(0.0, 0.5 + 0.5 * depth))) / _HAZE_STEPS
            for outline in solid.silhouette(towards, 0.4 * _OUTLINE * view.distance):
                camera.fill(draw, outline, _tint(colour, _EDGE_TONE, haze))
            for tone, area in solid.areas(towards):
                camera.fill(draw, area, _tint(colour, tone, haze))
        return picture.reduce(_SUPERSAMPLING)

    def _solids(self, data: mujoco.MjData) -> dict[int, Solid]:
        """Return what is to be painted, by geom; limbs begin where they leave the body's box."""
        solids = {geom: solid for geom in self._geoms if (solid := self._solid(geom, data)) is not None}
        root = self._model.body_rootid[self._model.geom_bodyid]
        for own, box in [(root[geom], solid) for geom, solid in solids.items() if isinstance(solid, Box)]:
            for geom, solid in solids.items():
                if isinstance(solid, Capsule) and root[geom] == own:
                    solids[geom] = solid.outside(box)
        return solids

    def _solid(self, geom: int, data: mujoco.MjData) -> Solid | None:
        """Return the geom as a solid where it stands, or None if it is of another kind."""
        kind, size = self._model.geom_type[geom], self._model.geom_size[geom]
        centre, axes = data.geom_xpos[geom].copy(), data.geom_xmat[geom].reshape(3, 3).T
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            return Capsule(centre, np.zeros(3), float(size[0]))
        if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
            return Capsule(centre, axes[2] * size[1], float(size[0]))
        if kind == mujoco.mjtGeom.mjGEOM_BOX:
            return Box(centre, axes * size[:, None])
        return None

    def _paint_ground(
        self, camera: Camera, data: mujoco.MjData, view: View, solids: list[Solid]
    ) -> Image.Image:
        """Return the floor with its tiles, the shadows and the body's trail."""
        origin, axes = np.zeros(3), np.eye(3)
        if self._ground is not None:
            origin, axes = data.geom_xpos[self._ground].copy(), data.geom_xmat[self._ground].reshape(3, 3).T
        stripes = [self._stripes(camera, view.target, origin, axes[[along, 1 - along]]) for along in (0, 1)]
        tiles = ImageChops.multiply(ImageChops.difference(*stripes), self._fade)
        shade = tiles.resize(self._size, Image.Resampling.NEAREST)
        picture = self._floor.copy()
        trail = view.trail - ((view.trail - origin) @ axes[2])[:, None] * axes[2]
        normal = axes[2]
        if self._relief is not None:
            tint = self._relief.paint(camera, view.target, view.distance, shade)
            shade = ImageChops.multiply(shade, self._haze)
            if tint is not None:
                picture.paste(_SLIPPERY, mask=tint)
            origin, normal = _footing(self._ground_shape, view.trail[-1])
            heights = [self._ground_shape.height(x, y) for x, y in view.trail[:, :2].tolist()]
            trail = np.column_stack([view.trail[:, :2], heights])
        picture.paste(_INK, mask=ImageChops.add(shade, self._shadows(camera, origin, normal, solids)))
        draw = ImageDraw.Draw(picture)
        for start, end in zip(*camera.project_lines(trail[:-1], trail[1:]), strict=True):
            draw.line([*start, *end], fill=_TRAIL, width=2 * _SUPERSAMPLING)
        return picture

    def _stripes(self, camera: Camera, target: Array, origin: Array, axes: Array) -> Image.Image:
        """Return every other stripe along the ground's first axis, as a mask; two such masks make tiles."""
        along, over = axes @ (target - origin)
        numbers = np.arange(-_TILES, _TILES) + 2 * round(0.5 * over / TILE_M)
        middle = origin + along * axes[0] + (TILE_M * numbers)[:, None] * axes[1]
        reach = TILE_M * _TILES * axes[0]
        starts, ends = camera.project_lines(middle - reach, middle + reach)
        mask = Image.new("L", self._fade.size)  # antialiased, the tiles would make up half the file
        draw = ImageDraw.Draw(mask)
        for first in range(0, len(starts) - 1, 2):
            corners = np.stack([starts[first], ends[first], ends[first + 1], starts[first + 1]])
            draw.polygon((corners / _SUPERSAMPLING).ravel().tolist(), fill=_TILE_DARKNESS)
        return mask

    def _shadows(self, camera: Camera, origin: Array, normal: Array, solids: list[Solid]) -> Image.Image:
        """Return the solids' shadows on the ground, as a mask."""
        mask = Image.new("L", self._size)
        draw = ImageDraw.Draw(mask)
        for solid in solids:
            for outline in solid.silhouette(LIGHT, 0.0):
                fall = (outline - origin) @ normal / float(LIGHT @ normal)
                camera.fill(draw, outline - fall[:, None] * LIGHT, _SHADOW_DARKNESS)
        step = _SHADOW_DARKNESS // _SHADOW_STEPS
        soft = mask.filter(ImageFilter.BoxBlur(1.5 * _SUPERSAMPLING))
        return soft.point([step * round(value / step) for value in range(256)])


def _cut(polygon: Array, depth: Array) -> Array:
    """Return the part of a polygon (n, 3) whose `depth` (n) is not negative (Sutherland and Hodgman)."""
    corners = []
    for first, second, here, there in zip(
            polygon, np.roll(polygon, -1, axis=0), depth, np.roll(depth, -1), strict=True):
        if here >= 0.0:
            corners.append(first)
        if (here < 0.0) != (there < 0.0):
            corners.append(first + here / (here - there) * (second - first))
    return np.array(corners)


def _footing(ground: Ground, body: Array) -> tuple[Array, Array]:
    """Return a point and the normal of the plane that the ground is, roughly, around a place."""
    x, y = float(body[0]), float(body[1])
    ahead, behind, left, right = (
        ground.height(x + dx * _FOOTING_M, y + dy * _FOOTING_M) for dx, dy in ((1, 0), (-1, 0), (0, 1), (0, -1)))
    slope = np.array([behind - ahead, right - left, 2.0 * _FOOTING_M])
    return np.array([x, y, 0.25 * (ahead + behind + left + right)]), unit(slope)


def _floor(size: tuple[int, int]) -> Image.Image:
    """Return the ground without tiles; it fades into the sky towards the top."""
    near = _steps(np.linspace(0.0, 1.0, size[1]) / 0.6)[:, None, None]
    rows = np.array(_SKY) + near * (np.array(_FLOOR, float) - np.array(_SKY))
    return Image.fromarray(np.repeat(rows, size[0], axis=1).astype(np.uint8))


def _tile_strength(size: tuple[int, int]) -> Image.Image:
    """Return how much of the tiles is seen, as a mask."""
    near = _steps((np.linspace(0.0, 1.0, size[1]) - 0.25) / 0.45)[:, None]
    return Image.fromarray(np.repeat(255.0 * near, size[0], axis=1).astype(np.uint8))


def _relief_strength(size: tuple[int, int]) -> Image.Image:
    """Return how much of the shades of a ground is seen, as a mask."""
    near = _steps(np.linspace(0.0, 1.0, size[1]) / 0.6)[:, None]
    rows = 255.0 * (_FAR_RELIEF + (1.0 - _FAR_RELIEF) * near)
    return Image.fromarray(np.repeat(rows, size[0], axis=1).astype(np.uint8))


def _steps(share: Array) -> Array:
    """Return `share`, limited to 0 to 1, in steps."""
    steps: Array = np.round(_FLOOR_STEPS * np.clip(share, 0.0, 1.0)) / _FLOOR_STEPS
    return steps


def _tint(rgb: Array, tone: float, haze: float) -> Colour:
    """Return a colour made darker or lighter, then mixed with the sky."""
    pole = np.ones(3) if tone > 0.0 else np.array(_INK) / 255.0 * 0.4
    toned = rgb + abs(tone) * (pole - rgb)
    mixed = 255.0 * toned + haze * (np.array(_SKY) - 255.0 * toned)
    red, green, blue = (round(float(part)) for part in mixed)
    return red, green, blue

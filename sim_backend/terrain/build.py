"""Builds a ground into MuJoCo's model."""

import math
from typing import Any

import mujoco

from robotwalk.types import Vec3
from sim_backend.terrain.course import Ground
from sim_backend.terrain.shapes import Blocks, HeightField, Incline, LooseBody, Shape, Slab

GROUP = 1  # of all geoms of the ground
LOOSE_GROUP = 2

_RGBA = (0.80, 0.82, 0.84, 1.0)
_SLIPPERY_RGBA = (0.62, 0.76, 0.88, 1.0)
_LOOSE_RGBA = (0.52, 0.44, 0.36, 1.0)
_PLANK = 0.04  # m, thickness of an incline
_BASE = 0.05  # m, of a height field below its lowest point
_SMALL = 1e-9  # m


def add_floor(spec: mujoco.MjSpec, ground: Ground, friction: list[float]) -> None:
    """Add the plane under all. Ground meets the robot and loose bodies (contype 1 & their conaffinity 1)."""
    spec.worldbody.add_geom(
        name="ground", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 0.05], pos=[0.0, 0.0, ground.floor],
        **_surface(None, friction))


def add_ground(spec: mujoco.MjSpec, ground: Ground, friction: list[float]) -> None:
    """Add all but the floor, behind the robot: MuJoCo numbers joints in that order.

    Args:
        spec: of the world.
        ground: what to add.
        friction: sliding, torsional and rolling, where the ground says nothing else.
    """
    for shape in ground.shapes:
        _add_shape(spec, shape, ground.floor, friction)
    if ground.bodies:
        # Bodies at rest cost nothing until something touches them: the loose course runs twice as fast.
        spec.option.enableflags |= mujoco.mjtEnableBit.mjENBL_SLEEP
    for number, body in enumerate(ground.bodies):
        _add_body(spec, number, body, friction)


def _add_shape(spec: mujoco.MjSpec, shape: Shape, floor: float, friction: list[float]) -> None:
    surface = _surface(shape.friction, friction)
    match shape:
        case Slab():
            _add_slab(spec, shape, floor, surface)
        case Blocks():
            for block in shape.each():
                _add_slab(spec, block, floor, surface)
        case Incline():
            _add_incline(spec, shape, surface)
        case HeightField():
            _add_height_field(spec, shape, surface)


def _surface(own: float | None, friction: list[float]) -> dict[str, Any]:
    """Return what all geoms of a ground have in common.

    Of two friction coefficients MuJoCo takes the larger, unless one geom has priority; that one's dimension of
    friction then counts too.
    """
    common = {"group": GROUP, "contype": 1, "conaffinity": 0}
    if own is None:
        return {**common, "rgba": _RGBA, "friction": friction}
    return {**common, "rgba": _SLIPPERY_RGBA, "friction": [own, *friction[1:]], "priority": 1, "condim": 4}


def _add_slab(spec: mujoco.MjSpec, slab: Slab, floor: float, surface: dict[str, Any]) -> None:
    if slab.height - floor < _SMALL:
        return
    x0, x1, y0, y1 = slab.span
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, pos=[0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * (floor + slab.height)],
        size=[0.5 * (x1 - x0), 0.5 * (y1 - y0), 0.5 * (slab.height - floor)], **surface)


def _add_incline(spec: mujoco.MjSpec, incline: Incline, surface: dict[str, Any]) -> None:
    x0, x1, y0, y1 = incline.span
    angle = math.atan2(incline.end - incline.start, x1 - x0)
    middle = Vec3(0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.5 * (incline.start + incline.end))
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[middle.x + 0.5 * _PLANK * math.sin(angle), middle.y, middle.z - 0.5 * _PLANK * math.cos(angle)],
        quat=[math.cos(0.5 * angle), 0.0, -math.sin(0.5 * angle), 0.0],
        size=[0.5 * (x1 - x0) / math.cos(angle), 0.5 * (y1 - y0), 0.5 * _PLANK], **surface)


def _add_height_field(spec: mujoco.MjSpec, field: HeightField, surface: dict[str, Any]) -> None:
    """Add a height field. MuJoCo's rows lie along y, its columns along x."""
    x0, x1, y0, y1 = field.span
    lowest = min(map(min, field.heights))
    depth = max(max(map(max, field.heights)) - lowest, _SMALL)
    name = f"heights_{len(spec.hfields)}"
    spec.add_hfield(
        name=name, nrow=len(field.heights[0]), ncol=len(field.heights),
        size=[0.5 * (x1 - x0), 0.5 * (y1 - y0), depth, _BASE],
        userdata=[(row[column] - lowest) / depth for column in range(len(field.heights[0])) for row in field.heights])
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_HFIELD, hfieldname=name, pos=[0.5 * (x0 + x1), 0.5 * (y0 + y1), lowest], **surface)


def _add_body(spec: mujoco.MjSpec, number: int, loose: LooseBody, friction: list[float]) -> None:
    """Add a body that lies around; it meets the ground, the robot and its like."""
    body = spec.worldbody.add_body(
        name=f"loose_{number}", pos=list(loose.position),
        quat=[math.cos(0.5 * loose.yaw), 0.0, 0.0, math.sin(0.5 * loose.yaw)])
    body.add_freejoint(name=f"loose_{number}")
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.5 * edge for edge in loose.size], mass=loose.mass, rgba=_LOOSE_RGBA,
        group=LOOSE_GROUP, contype=1, conaffinity=1, friction=friction)

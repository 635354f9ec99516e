"""The robot as locomotion sees it: chains, masses and limits, in SI units and one joint order.

Joints are ordered leg by leg as in the robot's file, and along each leg from the body to the foot.
"""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cached_property
from typing import NamedTuple

from robotwalk.config.safety import SafetyConfig
from robotwalk.config.schema import LegConfig, LocomotionConfig, RobotConfig, Solver
from robotwalk.settings import (
    ContactSettings,
    Heights,
    Leads,
    LevellingSettings,
    MotionLimits,
    OrientationSettings,
    Reactions,
)
from robotwalk.swing_paths import SwingPath, swing_path
from robotwalk.types import Vec3


class Axis(Enum):
    """A joint's axis in the frame of the link before it, right-handed."""

    ROLL = Vec3(1.0, 0.0, 0.0)
    PITCH = Vec3(0.0, 1.0, 0.0)
    YAW = Vec3(0.0, 0.0, 1.0)


class Joint(NamedTuple):
    """A revolute joint and the link that it moves."""

    name: str
    axis: Axis
    link: Vec3  # to the next joint or the foot's centre, in the moved frame
    lower: float  # rad
    upper: float  # rad
    rest: float  # rad
    mass: float  # kg of the link
    radius: float  # m of the link's capsule


@dataclass(frozen=True, slots=True)
class Leg:
    """A serial chain on the body, and how far its foot may go."""

    name: str
    mount: Vec3  # in the base frame
    yaw: float  # of the mount's x axis in the base frame
    joints: tuple[Joint, ...]
    first: int  # index of its first joint among the robot's
    rest_foot: Vec3  # centre of the resting foot in the base frame, the body at standing height
    max_stride: float  # m
    lift: float  # m
    swing_path: SwingPath
    solver: Solver | None  # of inverse kinematics; None: a closed form where there is one, else ccd

    @property
    def span(self) -> slice:
        """Where its joints lie in the robot's joint order."""
        return slice(self.first, self.first + len(self.joints))

    def leads(self, way: float) -> bool:
        """Tell whether the foot rests within 60 degrees of a way, rad in the base frame: it comes there first."""
        x, y, _ = self.rest_foot
        return x * math.cos(way) + y * math.sin(way) > 0.5 * math.hypot(x, y)


@dataclass(frozen=True)
class RobotModel:
    """Everything that locomotion knows of a robot."""

    name: str
    legs: tuple[Leg, ...]
    body_box: Vec3  # full lengths
    body_mass: float
    foot_radius: float
    foot_mass: float
    heights: Heights
    motion: MotionLimits
    reactions: Reactions
    levelling: LevellingSettings | None = None
    contact: ContactSettings | None = None
    orientation: OrientationSettings | None = None
    leads: Leads = field(default_factory=Leads)
    holds_course: bool = True
    stance_reflex: bool = True
    tells_stability: bool = True
    safety: SafetyConfig = field(default_factory=SafetyConfig)

    @cached_property
    def joints(self) -> tuple[Joint, ...]:
        """All joints in the one order used everywhere."""
        return tuple(joint for leg in self.legs for joint in leg.joints)

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """The joints' names, in joint order."""
        return tuple(joint.name for joint in self.joints)

    @cached_property
    def mass(self) -> float:
        """The whole robot's mass, kg."""
        return self.body_mass + sum(j.mass for j in self.joints) + self.foot_mass * len(self.legs)

    def narrowed(self, ranges: Mapping[str, tuple[float, float]]) -> "RobotModel":
        """Return the same robot, with joints that keep to these ranges (rad) as well as to their limits."""

        def narrow(joint: Joint) -> Joint:
            low, high = ranges.get(joint.name, (joint.lower, joint.upper))
            return joint._replace(lower=max(low, joint.lower), upper=min(high, joint.upper))

        return replace(self, legs=tuple(
            replace(leg, joints=tuple(narrow(joint) for joint in leg.joints)) for leg in self.legs))

    def without(self, lost: Collection[str]) -> "RobotModel":
        """Return what is left without some legs, which the body then bears as a load.

        It does not feel the ground: what its loads should be with a leg hanging there nobody knows well enough.
        """
        kept = [index for index, leg in enumerate(self.legs) if leg.name not in lost]
        legs: list[Leg] = []
        first = 0
        for index in kept:
            legs.append(replace(self.legs[index], first=first))
            first += len(legs[-1].joints)
        weights = [self.reactions.weights[index] for index in kept]
        left = replace(
            self, legs=tuple(legs), contact=None, orientation=None,
            reactions=self.reactions._replace(weights=tuple(weight / sum(weights) for weight in weights)))
        return replace(left, body_mass=self.body_mass + self.mass - left.mass)

    @classmethod
    def from_config(cls, config: RobotConfig) -> "RobotModel":
        """Convert a validated file to SI units."""
        skeleton, motion = config.skeleton, config.locomotion
        heights = Heights.from_config(motion.height_mm)
        foot_radius = _metres(skeleton.foot.radius_mm)
        legs: list[Leg] = []
        first = 0
        for name, leg in skeleton.legs.items():
            legs.append(_leg(name, leg, motion, first, foot_radius - heights.stand))
            first += len(leg.joints)
        return cls(
            name=config.name,
            legs=tuple(legs),
            body_box=_vector(skeleton.body.box_mm),
            body_mass=skeleton.body.mass_g * 1e-3,
            foot_radius=foot_radius,
            foot_mass=skeleton.foot.mass_g * 1e-3,
            heights=heights,
            motion=MotionLimits.from_config(motion),
            reactions=Reactions.from_config(motion.reaction, skeleton.legs),
            levelling=LevellingSettings.from_config(motion.levelling) if motion.levelling else None,
            contact=ContactSettings.from_config(motion.contact) if motion.contact else None,
            orientation=OrientationSettings.from_config(motion.orientation) if motion.orientation else None,
            leads=Leads(motion.feed_forward.lag, motion.feed_forward.load),
            holds_course=motion.hold_course,
            stance_reflex=motion.stance_reflex,
            tells_stability=motion.stability,
            safety=config.safety,
        )


def _metres(millimetres: float) -> float:
    return millimetres * 1e-3


def _vector(millimetres: tuple[float, float, float]) -> Vec3:
    return Vec3(*(_metres(value) for value in millimetres))


def _leg(name: str, leg: LegConfig, motion: LocomotionConfig, first: int, foot_z: float) -> Leg:
    footfall = motion.feet[name]
    mount, yaw = _vector(leg.mount_mm), math.radians(leg.yaw_deg)
    out, side = (_metres(value) for value in footfall.rest_mm)
    c, s = math.cos(yaw), math.sin(yaw)
    joints = tuple(
        Joint(
            name=f"{name}_{joint}",
            axis=Axis[row.axis.upper()],
            link=_vector(row.link_mm),
            lower=math.radians(row.rest_deg + row.limits_deg[0]),
            upper=math.radians(row.rest_deg + row.limits_deg[1]),
            rest=math.radians(row.rest_deg),
            mass=row.mass_g * 1e-3,
            radius=_metres(row.radius_mm),
        )
        for joint, row in leg.joints.items()
    )
    return Leg(
        name=name,
        mount=mount,
        yaw=yaw,
        joints=joints,
        first=first,
        rest_foot=Vec3(mount.x + c * out - s * side, mount.y + s * out + c * side, foot_z),
        max_stride=_metres(footfall.max_stride_mm),
        lift=_metres(footfall.lift_mm),
        swing_path=swing_path(footfall.swing_path or motion.swing_path),
        solver=motion.solver,
    )

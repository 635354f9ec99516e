"""What passes between the stages: small, immutable, in SI units and radians.

Frames are REP-103 and REP-105: `odom` stands still, z up; `base` is the body's, x forward, y left, z up.
"""

import math
from typing import NamedTuple


class Vec3(NamedTuple):
    """A point or a vector, in metres unless its name says otherwise."""

    x: float
    y: float
    z: float


# The same, made or taken apart so often in a tick that names would cost too much.
Triple = tuple[float, float, float]


class Twist(NamedTuple):
    """A planar velocity of the body, in the base frame."""

    vx: float  # m/s
    vy: float  # m/s
    wz: float  # rad/s, counter-clockwise


class Pose(NamedTuple):
    """Position and attitude, as intrinsic yaw, pitch, roll."""

    x: float
    y: float
    z: float
    roll: float
    pitch: float
    yaw: float


class Tilt(NamedTuple):
    """How a body lies against gravity, as the roll and pitch of a Pose."""

    roll: float  # rad
    pitch: float  # rad


UP = Vec3(0.0, 0.0, 1.0)
LEVEL = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
STILL = Twist(0.0, 0.0, 0.0)


class Command(NamedTuple):
    """What the driver asks of a robot that stands."""

    twist: Twist = STILL
    heading: float | None = None  # rad, in odom; turns there and holds it, in place of twist.wz
    height: float | None = None  # m, base above the ground; None is the robot's own
    posture: Pose = LEVEL  # displacement of the body from its course, in the base frame
    gait: str | None = None  # None is the robot's default
    period: float | None = None  # s that a turn of the gait shall take; None is as slow as the speed allows


class JointState(NamedTuple):
    """All joints as last heard from, in the robot's joint order.

    A joint that did not answer when it was last asked keeps its last values; `valid` is then False and `age` grows.
    Where a bus takes several ticks to ask everybody, `age` grows in between, too. Effort is a share of the servo's
    largest output: a current, or a duty cycle as it would be at the servo's rated voltage.
    """

    position: tuple[float, ...]  # rad
    velocity: tuple[float, ...]  # rad/s
    effort: tuple[float, ...]
    valid: tuple[bool, ...]
    age: tuple[float, ...]  # s since the joint last answered


class ImuState(NamedTuple):
    """What an IMU last told of the base.

    An IMU that is silent keeps its last values: `age` grows, and before long `valid` is False.
    """

    roll: float  # rad, with pitch and yaw as in Pose
    pitch: float
    yaw: float  # rad, -pi to pi, from wherever the sensor has its zero
    angular_velocity: Vec3 | None  # rad/s, in the base frame; None: this IMU does not tell
    acceleration: Vec3 | None  # m/s^2, in the base frame, gravity felt as g upwards; None: this IMU does not tell
    age: float  # s since its last measurement was taken from the line
    valid: bool


class FootSwitch(NamedTuple):
    """What the switch under a foot last told."""

    closed: bool | None  # None: unknown, as it was not heard for too long, or there is none
    age: float  # s since it was last heard; infinite if it never was


class SensorStatistics(NamedTuple):
    """What a sensor that talks unasked said since its port was opened."""

    rx_bytes: int
    reports: int
    stray_bytes: int  # that belonged to no report: garbled, or begun before the port was opened
    max_age: float  # s, the longest that it was silent
    failure: str | None  # of its port, in words


class Measured(NamedTuple):
    """A value that is read now and then."""

    value: float
    heard: int  # ns, on the clock of the ticks


class ServoLimits(NamedTuple):
    """Where a servo's own protections act, as it is set up; None: it has no such protection."""

    hottest: float | None = None  # degC
    lowest_voltage: float | None = None  # V
    highest_voltage: float | None = None  # V
    largest_current: float | None = None  # A


class ServoCondition(NamedTuple):
    """What a servo last told of itself; None where it was never heard, or does not measure it."""

    voltage: Measured | None  # V
    temperature: Measured | None  # degC
    current: Measured | None  # A
    holds: bool | None  # whether its torque is on
    faults: tuple[str, ...]  # of its hardware, in words
    limits: ServoLimits = ServoLimits()


class DriveResponse(NamedTuple):
    """How a joint's position servo follows a goal near rest.

    goal = q + damping q' + inertia q'' + friction sgn q' + torque / stiffness, with the torque (N m) that the joint
    is to exert on what it moves. It tells of that by its effort:
    torque = effort_torque effort - effort_damping q' - stiffness (inertia q'' + friction sgn q').
    """

    damping: float  # s
    inertia: float  # s^2
    friction: float  # rad that the goal must be ahead for the joint to move at all
    max_speed: float  # rad/s without load
    stiffness: float = math.inf  # N m per rad that the goal is ahead
    effort_torque: float = 0.0  # N m at effort 1; 0: its effort tells nothing
    effort_damping: float = 0.0  # N m s


class Strength(NamedTuple):
    """What a joint's servo can give, by its data sheet at its rated voltage."""

    stall_torque: float  # N m
    free_speed: float  # rad/s without load


class BusStatistics(NamedTuple):
    """What one bus carried since it was opened."""

    tx_bytes: int
    rx_bytes: int
    transactions: int
    lost_replies: int  # joint samples asked for and not received
    bad_frames: int
    max_age: float  # s, the longest that any joint was out of date since torque came on
    watchdog_trips: int  # servos that had stopped, for they heard nothing for too long

"""Whether a robot's servos can give what a gait asks of its legs (PPS section 4).

The pseudo-physics says how each foot must accelerate the body, at true gravity: with little stance, much. Against
that stands what a leg at rest can give while every foot bears an equal share of the robot's mass. Where the feet do
not hold the body, it falls: freely if none stands, else about them, as far as rocking does not help. Half of the speed
that it gains so it must leave the ground with, and the legs must be as fast.

A servo is taken at half its stall torque and half its free speed, where a DC motor gives its greatest power; beyond,
nothing is left to move with. The mass is taken as a point, and the legs' own weight is left out.
"""

from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.chain import foot_position
from robotwalk.gait import Gait
from robotwalk.kinematics import resting_angles
from robotwalk.model import Leg, RobotModel
from robotwalk.pseudo_physics import GRAVITY, steady_effort
from robotwalk.support import beyond_edge, centre_of_mass
from robotwalk.types import Strength, Vec3

_SHARE = 0.5  # of stall torque and free speed
_NUDGE = 1e-4  # rad


class Plausibility(NamedTuple):
    """What a gait asks of the worst foot, and what its leg can give."""

    gait: str
    load: float  # asked / can give, the larger of the two below; over 1 the gait is implausible
    leg: str
    acceleration: float  # m/s^2, the largest that the foot must give its share of the mass
    possible_acceleration: float  # m/s^2
    take_off: float  # m/s upwards, for the longest fall
    possible_take_off: float  # m/s

    @property
    def plausible(self) -> bool:
        """Tell whether the servos can give it."""
        return self.load <= 1.0

    def complaint(self) -> str:
        """Say what the gait asks most of, against what the servos can give."""
        if self.take_off / self.possible_take_off >= self.load:
            most = (f"where its feet do not hold the body, {self.leg} would have to throw it up at "
                    f"{self.take_off:.2f} m/s, not {self.possible_take_off:.2f} m/s")
        else:
            most = (f"{self.leg} would have to push with {self.acceleration:.1f} m/s^2, "
                    f"not {self.possible_acceleration:.1f} m/s^2")
        return f"it asks for {self.load:.2f} times what the servos can give ({most})"


class Push(NamedTuple):
    """What a leg can do upwards at rest."""

    force: float  # N
    speed: float  # m/s


def plausibility(model: RobotModel, gait: Gait, strengths: Sequence[Strength]) -> Plausibility:
    """Judge a gait at its highest cadence, at which the falls are shortest; `strengths` in joint order."""
    angles = resting_angles(model, model.heights.stand)
    period = gait.fastest_period
    take_off = 0.5 * longest_fall(model, gait, centre_of_mass(model, angles)) * period
    share = model.mass / len(model.legs)
    judged = []
    for leg, sectors in zip(model.legs, gait.feet, strict=True):
        push = strongest_push(leg, angles[leg.span], strengths[leg.span])
        asked, possible = steady_effort(sectors, period).acceleration, push.force / share
        judged.append(Plausibility(
            gait.name, max(asked / possible, take_off / push.speed), leg.name, asked, possible, take_off, push.speed))
    return max(judged, key=lambda foot: foot.load)


def longest_fall(model: RobotModel, gait: Gait, centre: Vec3) -> float:
    """Return the most speed that the body gains by falling without a break, m/s per second of the period.

    `centre` is of the mass, in the base frame.
    """
    longest = fall = turns = 0.0
    for support in (*gait.supports, *gait.supports):  # twice: a fall may run past the top of the circle
        feet = [leg.rest_foot for leg, stands in zip(model.legs, support.standing, strict=True) if stands]
        held = gait.balance is not None and len(feet) >= 3
        rate = 0.0 if held else falling(feet, centre, (1.0 - gait.rocking), model.heights.stand + centre.z)
        fall, turns = (fall + rate * support.length, turns + support.length) if rate > 0.0 else (0.0, 0.0)
        if turns <= 1.0 + 1e-9:
            longest = max(longest, fall)
    return longest


def falling(feet: Sequence[Vec3], centre: Vec3, share: float, height: float) -> float:
    """Return how a mass accelerates downwards on these feet, m/s^2: freely without any, else tipping over them.

    Args:
        feet: that stand, seen from above.
        centre: of the mass.
        share: of its way outside the feet that counts.
        height: of the mass above the ground, m.
    """
    if not feet:
        return GRAVITY
    outside = share * max(beyond_edge(feet, centre), 0.0)
    return GRAVITY * outside * outside / (outside * outside + height * height)


def strongest_push(leg: Leg, angles: Sequence[float], strengths: Sequence[Strength]) -> Push:
    """Return what a leg's servos can do straight down from these angles (rad)."""
    force, speed = float("inf"), 0.0
    for index, strength in enumerate(strengths):
        turned = list(angles)
        turned[index] += _NUDGE
        # How far the foot rises as the joint turns: by virtual work also the torque that a force on it makes, m.
        lever = abs(foot_position(leg, turned).z - foot_position(leg, angles).z) / _NUDGE
        speed += lever * _SHARE * strength.free_speed
        if lever > _NUDGE:
            force = min(force, _SHARE * strength.stall_torque / lever)
    return Push(force, speed)

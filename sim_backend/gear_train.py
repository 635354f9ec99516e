"""What lies between the motors and the output shafts: friction, and gears with play between their teeth.

    friction   at most  Kv |w| + Kc + Kl L + exp(-|w / ws|^alpha) (Kcs + Kls L)  with L = |tm - te|
    play       the rotor may lead or trail its shaft by half the backlash

tm is the motor's torque, te the external one as of the step before (BAM's M4; M1 is Kv and Kc alone).

As long as a rotor's teeth press on its shaft's, both are one body: MuJoCo has the rotor's inertia and its friction at
the joint. Where the rotor would have to pull instead, they part. The shaft is then free: nothing but its bearing's
share of the friction acts on it. The rotor moves on its own, driven by its motor, with its inertia and the rest of the
friction, until it meets the teeth on either side, and there it shares its momentum with the shaft.

All encoders sit on the output shaft, as in the real servos: the firmware sees the shaft move within the play, and its
loop cannot feel where in it the rotor is. Back-EMF is the rotor's.

Teeth meet and part on the grid of the physics steps: the play comes out right to half a step's motion, and a rotor
that turns back may pull for one step. Not modelled: rebound and elasticity of the teeth, cogging, wear.
"""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from hal.register_map import Motor

Floats = npt.NDArray[np.float64]

_BEARING = 0.1  # share of the friction without load that is the output shaft's own; assumed
_ROTOR = 1.0 - _BEARING  # and the other side's
_LEAST_FRICTION = 1e-9  # N m; MuJoCo has a row of constraint for each joint with friction: this keeps their order


class GearTrain:
    """The gears of one robot's servos, in their order. All angles and torques are the output shafts'.

    Attributes:
        armature: what MuJoCo's joints are to have for the next step: inertia, kg m^2,
        viscous: friction that grows with speed, N m s,
        friction: and all other, N m.
        rotor_speed: rad/s.
    """

    def __init__(self, motors: Sequence[Motor], timestep: float, shaft: Floats) -> None:
        """Begin at rest, with the shafts' angles (rad) in the middle of their play."""
        def of(value: Callable[[Motor], float]) -> Floats:
            return np.array([value(motor) for motor in motors])

        self._timestep = timestep
        self._inertia = of(lambda motor: motor.armature_kgm2)
        self._per_step = self._inertia / timestep  # N m that change a rotor's speed by 1 rad/s within a step
        self._viscosity = of(lambda motor: motor.friction.viscous_nms)
        self._coulomb = of(lambda motor: motor.friction.coulomb_nm)
        self._load = of(lambda motor: motor.friction.load)
        self._stribeck = of(lambda motor: motor.friction.stribeck_nm)
        self._stribeck_load = of(lambda motor: motor.friction.stribeck_load)
        self._stribeck_speed = of(lambda motor: motor.friction.stribeck_rad_s)
        self._stribeck_exponent = of(lambda motor: motor.friction.stribeck_exponent)
        self._half_play = np.radians(of(lambda motor: motor.backlash_deg)) / 2.0
        self.follows_load = any(motor.friction.model == "M4" for motor in motors)
        self._free = self._half_play > 0.0
        self._touching = (~self._free).astype(float)
        self._lead = np.zeros(len(motors))  # of the rotor, rad
        self._shaft = shaft.copy()
        self._shaft_speed, self._passed, self._impulse = np.zeros((3, len(motors)))
        self.rotor_speed = np.zeros(len(motors))
        self._bearing = _BEARING * self._coulomb + _LEAST_FRICTION
        self._bearing_viscosity, self._rotor_viscosity = _BEARING * self._viscosity, _ROTOR * self._viscosity
        self.armature, self.viscous, self.friction = np.zeros((3, len(motors)))
        self._couple()
        np.copyto(self.friction, self._bearing)

    def follow(self, shaft: Floats, speed: Floats, friction: Floats) -> None:
        """Take in how a step has moved the shafts (rad, rad/s), and what torque friction had at the joints (N m)."""
        step, touching = self._timestep, self._touching
        pressure = (
            self._passed + _ROTOR * friction - self._rotor_viscosity * speed
            - self._per_step * (speed - self._shaft_speed))
        self._lead += (self.rotor_speed * step - (shaft - self._shaft)) * self._free
        closing = self.rotor_speed - speed
        met = self._free & (closing * self._lead >= 0.0) & (
            np.abs(self._lead + (0.5 * step) * closing) >= self._half_play)  # by the middle of the next step
        parted = pressure * self._lead * touching < 0.0
        np.minimum(self._lead, self._half_play, out=self._lead)
        np.maximum(self._lead, -self._half_play, out=self._lead)
        np.multiply(self._per_step, closing * met, out=self._impulse)
        np.copyto(self.rotor_speed, speed, where=~self._free)
        self._free = (self._free | parted) & ~met
        np.subtract(1.0, self._free, out=touching)
        self._couple()
        np.copyto(self._shaft, shaft)
        np.copyto(self._shaft_speed, speed)

    def _couple(self) -> None:
        """Have the joints feel the rotors that touch."""
        np.multiply(self._inertia, self._touching, out=self.armature)
        np.multiply(self._rotor_viscosity, self._touching, out=self.viscous)
        self.viscous += self._bearing_viscosity

    def drive(self, torque: Floats, external: Floats | None) -> Floats:
        """Let the motors act, N m, against external torques; return what arrives at the shafts, to be held for a step.

        `external` matters where `follows_load`. The array returned is reused.
        """
        rotors = self._dry_friction(torque, external) - self._bearing
        np.multiply(rotors, self._touching, out=self.friction)
        self.friction += self._bearing
        if self._free.any():
            self._turn_rotors(torque, rotors)
        np.multiply(torque, self._touching, out=self._passed)
        self._passed += self._impulse
        return self._passed

    def _dry_friction(self, torque: Floats, external: Floats | None) -> Floats:
        if external is None:
            return self._coulomb
        load = np.abs(torque - external * self._touching)
        slow = np.exp(-(np.abs(self.rotor_speed) / self._stribeck_speed) ** self._stribeck_exponent)
        friction: Floats = self._coulomb + self._load * load + slow * (self._stribeck + self._stribeck_load * load)
        return friction

    def _turn_rotors(self, torque: Floats, friction: Floats) -> None:
        """Speed the free rotors up, then brake them, to a standstill at most."""
        speed = self.rotor_speed + torque / self._per_step
        brake = (friction + self._rotor_viscosity * np.abs(self.rotor_speed)) / self._per_step
        braked = np.copysign(np.maximum(np.abs(speed) - brake, 0.0), speed)
        np.copyto(self.rotor_speed, braked, where=self._free)

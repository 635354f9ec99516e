"""What the registers of a Dynamixel AX mean for its motor, and what its potentiometer can tell.

With e = goal - position in steps, in shares of full duty, beyond the compliance margin:

    joint mode   duty = (|e| - margin) / slope + punch / 1023, towards the goal
    wheel mode   duty = moving speed / 1023

up to the torque limit. Assumed: the e-Manual draws the curve of joint mode and gives no figures. Where the margins
or the slopes of the two sides differ, the softer ones serve both here.

The potentiometer covers 300 of 360 degrees. What the position reads in the rest is the file's to say. A servo in
joint mode goes back from there to the nearer end.
"""

import math

from hal.register_map import AxFirmware, ServoModel
from sim_backend.ax_table import AxTable
from sim_backend.motion_profile import Profile, profile_by_speed
from sim_backend.servo_physics import Drive, Gains, Scales

_SLOPES = range(1, 8)  # exponents of 2
_TURN_DEG = 360.0


class AxMotion:
    """Translates registers into steps, seconds and duty, as they are at the time of the call."""

    def __init__(self, model: ServoModel, firmware: AxFirmware, table: AxTable) -> None:
        self._model, self._table = model, table
        self._blind_is_zero = firmware.dead_zone_reads == "zero"
        encoder = model.encoder
        self._turn = encoder.ticks * _TURN_DEG / encoder.span_deg  # steps, the dead zone's included
        self._margin = 0.5 * (self._turn - encoder.ticks)  # of the dead zone, to each end
        self._full = model.position_loop.pwm_full_scale
        self._speed_unit = model["moving_speed"].scale * self._turn / 60.0  # steps/s per count, from rpm

    def drive(self, on: bool) -> Drive:
        """Return what drives the motor."""
        table, cap = self._table, self._table["torque_limit"] / self._full
        if table.wheel_mode:
            return Drive(on, cap, duty=table["moving_speed"] / self._full)
        return Drive(on, cap, self._gains())

    def _gains(self) -> Gains:
        table = self._table
        margin = max(table["cw_compliance_margin"], table["ccw_compliance_margin"])
        slope = max(_representative(table["cw_compliance_slope"]), _representative(table["ccw_compliance_slope"]))
        return Gains(
            self._model.position_loop.duty_per_tick(slope), margin=margin, punch=table["punch"] / self._full)

    def scales(self) -> Scales:
        """Return what is reported; the position as if there were no dead zone."""
        model = self._model
        return Scales(
            1, model.encoder.centre, duty=self._full, load=model.cyclic.effort_full_scale,
            speed=1.0 / self._speed_unit, current=0.0, supply=1.0 / model["present_voltage"].scale, moving_above=0.0)

    def shown(self, count: int) -> int:
        """Return what the potentiometer tells of a position."""
        last = self._model.encoder.ticks - 1
        position = round(count - self._turns(count) * self._turn)
        if 0 <= position <= last:
            return position
        return 0 if self._blind_is_zero or position < 0 else last

    def goal(self, ticks: float) -> float:
        """Return where the goal position is, in the turn in which the shaft is, ticks."""
        centre = self._model.encoder.centre
        return self._table["goal_position"] - centre + self._turns(ticks + centre) * self._turn

    def profile(self, start: float, goal: float) -> Profile | None:
        """Return the profile at the moving speed, or None if it is as fast as can be."""
        speed = self._table["moving_speed"]
        return profile_by_speed(start, 0.0, goal, speed * self._speed_unit, 0.0) if speed else None

    def _turns(self, count: float) -> int:
        """Return how many turns lie below a count. A turn begins in the middle of the dead zone."""
        return math.floor((count + self._margin) / self._turn)


def _representative(slope: int) -> int:
    """Return what a slope counts as: its highest bit, within seven steps (e-Manual, Compliance Slope)."""
    return 1 << min(max(slope.bit_length() - 1, _SLOPES[0]), _SLOPES[-1])

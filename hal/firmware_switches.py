"""What no manual of a servo states, and the fake servo must decide: switches, which each file sets with its reasons."""

from typing import Annotated, ClassVar, Literal

from pydantic import Field

from hal.schema import Row


class DynamixelFirmware(Row):
    """Of the X series, and of the MX with its firmware 2.0."""

    kind: Literal["dynamixel-x"]
    version: Annotated[int, Field(ge=0, le=255)]
    time_base_hz: Annotated[float, Field(gt=0)]  # of integral and derivative terms
    velocity_p_divisor: Annotated[float, Field(gt=0)]  # PWM counts = gain / this x error in counts of velocity
    velocity_i_divisor: Annotated[float, Field(gt=0)]
    derivative_gain: bool  # whether the position D gain acts
    goal_follows_present: bool  # whether torque-on sets the goal to where the shaft is
    later_ids_answer: bool  # whether a sync read goes on behind a silent servo
    answers_at_new_setting: bool  # whether the answer to a new id or baud rate bears it already
    turnaround_us: Annotated[float, Field(ge=0)]  # before an answer, on top of the return delay
    watchdog_holds: bool  # whether a servo stopped by the bus watchdog holds its place; otherwise it lets go
    watchdog_forgets_offset: bool  # whether, stopped in extended position mode, it heads for its place less the offset
    shock_at_power_up: bool  # whether coming to power again sets the electrical shock error
    following_error_ticks: Annotated[int, Field(gt=0)]  # off the trajectory by more is a following error
    reboot_s: Annotated[float, Field(ge=0)]  # silent for this long after a reboot
    overload_duty: Annotated[float, Field(gt=0, le=1)]
    overload_s: Annotated[float, Field(gt=0)]
    temperature_c: float  # the fake has no heat model: every servo stays at this


class AxFirmware(Row):
    """Of the AX series."""

    later_ids_answer: ClassVar[bool] = False  # nothing reads many of them at once

    kind: Literal["dynamixel-ax"]
    version: Annotated[int, Field(ge=0, le=255)]
    goal_follows_present: bool  # whether the goal is where the shaft is as long as torque is off
    reboot: bool  # whether instruction 0x08 restarts the servo; otherwise it is not known
    answers_at_new_setting: bool  # whether the answer to a new id or baud rate bears it already
    turnaround_us: Annotated[float, Field(ge=0)]  # before an answer, on top of the return delay
    dead_zone_reads: Literal["nearest", "zero"]  # the position where the encoder has none: the nearest end, or 0
    reboot_s: Annotated[float, Field(ge=0)]  # silent for this long after power-up or a factory reset
    overload_duty: Annotated[float, Field(gt=0, le=1)]  # as a share of the torque limit
    overload_s: Annotated[float, Field(gt=0)]
    temperature_c: float


class FeetechFirmware(Row):
    """Of either of Feetech's series."""

    largest_duty: Annotated[float, Field(gt=0, le=1)]
    goal_slew_steps_s: Annotated[float, Field(gt=0)]  # how fast the inner goal may move
    integral_s: Annotated[float, Field(gt=0)]  # an I gain acts as P does on the error summed over this time
    derivative_s: Annotated[float, Field(ge=0)]  # a D gain acts as P does on the change within this time
    derivative_gain: bool  # whether the position D gain acts
    later_ids_answer: bool  # whether a sync read goes on behind a silent servo
    answers_at_new_setting: bool  # whether the answer to a new id or baud rate bears it already
    turnaround_us: Annotated[float, Field(ge=0)]  # before an answer, on top of the return delay
    eeprom_write_ms: Annotated[float, Field(ge=0)]  # before the answer to a write of the EEPROM that is not locked
    broadcast_ping: bool  # whether a ping to everybody is answered
    reboot_s: Annotated[float, Field(ge=0)]  # silent for this long after power-up
    torque_at_power_up: bool
    reboot: bool  # whether instruction 0x08 restarts the servo; otherwise it is not known
    recovery_keeps_id: bool  # whether the id survives instruction 0x06, which brings the factory's settings back
    overload_clears_on_new_goal: bool  # in the other direction; otherwise only torque off and on clears it
    torque_flag_in_status: bool  # whether bit 0x10 of the error byte means "torque is on"
    temperature_c: float


class StsFirmware(FeetechFirmware):
    """Of the STS and SMS series."""

    kind: Literal["feetech-sts"]
    velocity_divisor: Annotated[float, Field(gt=0)]  # velocity P gain / this = duty per step/s
    damping: bool  # whether torque enable 2 brakes the motor; otherwise it is as 0
    centre_outlives_lock: bool  # whether the offset that torque enable 128 chooses is kept though `lock` is 1
    calibrate: bool  # whether instruction 0x0B makes here the centre, as torque enable 128 does; otherwise unknown


class ScsFirmware(FeetechFirmware):
    """Of the SCS series."""

    kind: Literal["feetech-scs"]
    pwm_goal: Literal["goal_time", "goal_velocity"]  # the register that drives the motor when both limits are 0
    speed_0_stops: bool  # whether a goal velocity of 0 means not to move; otherwise as fast as it can

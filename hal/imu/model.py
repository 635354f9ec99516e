"""One file of `configs/imus`: how a kind of sensor talks, and how good it is."""

from typing import Annotated, Literal

from pydantic import Field

from hal.schema import Row

FramesName = Literal["uart-rvc", "witmotion"]
Error = Annotated[float, Field(ge=0, le=180)]
Baud = Annotated[int, Field(gt=0)]


class ImuErrors(Row):
    """How far off it may be, one standard deviation. A simulated one is so far off; nothing else relies on it."""

    tilt_bias_deg: Error  # that stays
    tilt_noise_deg: Error  # of each measurement
    gyro_bias_deg_s: Error = 0.0
    gyro_noise_deg_s: Error = 0.0
    acceleration_noise_mps2: Annotated[float, Field(ge=0, le=10)] = 0.0


class ImuModel(Row):
    """A kind of sensor."""

    schema_version: Annotated[Literal[1], Field(alias="schema")]
    name: str
    description: str
    frames: FramesName
    report_bytes: Annotated[int, Field(gt=0)]  # that a measurement takes, as it is delivered
    baud_rates: Annotated[tuple[Baud, ...], Field(min_length=1)]
    rate_hz: Annotated[float, Field(gt=0, le=1000)]  # as it is delivered
    max_rate_hz: Annotated[float, Field(gt=0, le=1000)]
    errors: ImuErrors


Angle = Annotated[float, Field(ge=-180, le=180)]


class ImuConfig(Row):
    """The IMU of a robot, in its file's `hardware` section."""

    kind: str
    port: str
    baud: Baud
    # Roll, pitch, yaw of the sensor in the base: about its x, after y, after z.
    mounting_deg: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    rate_hz: Annotated[float, Field(gt=0, le=1000)] | None = None  # that it was set to; None: as it is delivered
    stale_after_s: Annotated[float, Field(gt=0, le=5)] = 0.25  # then what it said last counts no more

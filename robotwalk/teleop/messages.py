"""What programs and `robotwalk teleop` say to each other: one JSON object a message, in SI units and radians."""

import json
from collections.abc import Mapping
from typing import Any, Literal, get_args

from pydantic import ValidationError

from robotwalk.config.document import Document
from robotwalk.config.schema import Section
from robotwalk.errors import ConfigError
from robotwalk.teleop.ask import Ask, Wish
from robotwalk.teleop.told import Told
from robotwalk.types import Command, Pose, ServoCondition, Twist

SCHEMA = 1

_Words = Literal["beat", "stand", "sit", "stop", "clear", "leave"]


class Posture(Section):
    """Displacement of the body from its course."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    roll: float = 0.0
    pitch: float = 0.0
    yaw: float = 0.0


class Drive(Section):
    """What the robot shall do, until another word comes, or half a second has passed without one."""

    type: Literal["drive"]
    vx: float = 0.0
    vy: float = 0.0
    wz: float = 0.0
    heading: float | None = None
    height: float | None = None
    posture: Posture = Posture()
    gait: str | None = None
    period: float | None = None

    def ask(self, driver: str) -> Ask:
        """Return it as that driver's."""
        return Ask(driver, Command(
            Twist(self.vx, self.vy, self.wz), self.heading, self.height, Pose(**self.posture.model_dump()), self.gait,
            self.period))


class Word(Section):
    """All else; `beat` only shows that the driver is there."""

    type: _Words

    def ask(self, driver: str) -> Ask:
        """Return it as that driver's."""
        return Ask(driver, wish=None if self.type == "beat" else Wish(self.type))


def read(text: str | bytes, driver: str) -> Ask:
    """Return what a message of that driver asks for.

    Raises:
        ConfigError: it is none; says where and why.
    """
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ConfigError(f"message: not valid JSON: {error}") from None
    kind = content.get("type") if isinstance(content, dict) else None
    if not isinstance(kind, str) or kind not in _MODELS:
        raise ConfigError(f"message: type: expected one of {', '.join(_MODELS)} (got {json.dumps(kind)[:60]})")
    model = _MODELS[kind]
    try:
        message = model.model_validate(content)
    except ValidationError:
        words = text if isinstance(text, str) else text.decode(errors="replace")
        Document.parse(words, "message").validate(model)  # says it in our way, with the place
        raise ConfigError("message: not understood") from None
    return message.ask(driver)


_MODELS: Mapping[str, type["Drive | Word"]] = {"drive": Drive, **dict.fromkeys(get_args(_Words), Word)}


def error(text: str) -> str:
    """Return the message that tells of something not done."""
    return _written("error", {"error": text})


def hello(robot: str, gaits: tuple[str, ...], driver: str) -> str:
    """Return the first message to a client."""
    return _written("hello", {"robot": robot, "gaits": list(gaits), "you": driver})


def telemetry(told: Told) -> str:
    """Return what is known of the robot, as a message."""
    return _written("telemetry", fields(told))


def fields(told: Told) -> dict[str, Any]:
    """Return what is known of the robot, as JSON has it."""
    return {
        "state": told.state, "note": told.note, "driver": told.driver,
        "pose": told.pose._asdict(), "twist": told.twist._asdict(),
        "servos": {joint: _condition(condition) for joint, condition in told.conditions.items()},
        "bus": {
            name: {"lost_replies": bus.lost_replies, "bad_frames": bus.bad_frames, "transactions": bus.transactions}
            for name, bus in told.buses.items()},
        "timing": {
            "rate_hz": told.rate_hz, "ticks": told.ticks, "missed_deadlines": told.missed,
            "wake_us": told.wake._asdict(), "bus_us": told.exchange._asdict(), "tick_us": told.compute._asdict()},
    }


def _condition(condition: ServoCondition) -> dict[str, float | None]:
    return {
        "voltage_v": condition.voltage.value if condition.voltage else None,
        "temperature_c": condition.temperature.value if condition.temperature else None,
        "current_a": condition.current.value if condition.current else None,
    }


def _written(kind: str, content: Mapping[str, Any]) -> str:
    return json.dumps({"schema": SCHEMA, "type": kind, **content}, allow_nan=False)

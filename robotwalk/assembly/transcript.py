"""Traffic in words: of a log, whose robot's files tell every servo's model, or of a line that is listened to."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from hal.maintenance.transcript import Said, Transcriber
from hal.register_map import ServoModel
from hal.serial_transport import open_plainly
from robotwalk.assembly.blueprint import Files, build, load, load_servo
from robotwalk.clock import WallClock
from robotwalk.errors import UsageError
from robotwalk.log import Log

_NS = 1_000_000_000
_NAP = 100_000_000  # ns after which a silent line is asked whether it is time to end


class Line(NamedTuple):
    """Something that was said, where and when."""

    seconds: float  # since the first byte
    bus: str
    said: Said


def of_log(path: Path) -> Iterator[Line]:
    """Return all that was said in a log's run.

    Raises:
        UsageError: it is no log, or of another version.
        ConfigError: this version does not take the files that are in it.
    """
    with Log(path) as log:
        blueprint = build(Files.parse(log.files))
        transcribers = {
            bus: Transcriber(wired[0].model.protocol, {servo.id: servo.model for servo in wired})
            for bus, wired in blueprint.wiring.items()}
        began: int | None = None
        time = 0
        for traffic in log.traffic():
            if traffic.bus not in transcribers:
                continue  # the IMU's line, on which nobody asks and no servo answers
            time = traffic.time
            began = time if began is None else began
            for said in transcribers[traffic.bus].take(traffic.data, traffic.sent):
                yield Line((time - began) / _NS, traffic.bus, said)
        for bus, transcriber in transcribers.items():
            for said in transcriber.end():
                yield Line((time - (began or 0)) / _NS, bus, said)


def of_line(
    url: str, *, baud: int, protocol: str | None, robot: str | None, bus: str | None, servo: str | None,
    seconds: float | None,
) -> Iterator[Line]:
    """Listen to a line and return what others say on it. Nothing is sent.

    Models come from a robot's bus, or all servos are of one model.

    Raises:
        UsageError: no such robot, bus or servo, or nothing tells the protocol.
        BusError: the port does not open, or is gone.
    """
    models, spoken = _models(robot, bus, servo)
    if protocol or spoken:
        transcriber = Transcriber(str(protocol or spoken), models)
    else:
        raise UsageError("say what is spoken there: --protocol, --servo MODEL or --robot ROBOT")
    clock = WallClock()
    port = open_plainly(url, baud)
    try:
        opened, first = clock.now(), math.inf
        ends = math.inf if seconds is None else opened + seconds * _NS
        while clock.now() < ends:
            clock.wait((port,), min(clock.now() + _NAP, round(ends) if ends < math.inf else clock.now() + _NAP))
            data, now = port.read(), clock.now()
            if data:
                first = min(first, now)
                for said in transcriber.take(data):
                    yield Line((now - first) / _NS, url, said)
        for said in transcriber.end():
            yield Line((clock.now() - min(first, clock.now())) / _NS, url, said)
    finally:
        port.close()


class _Everyone(dict[int, ServoModel]):
    """Any id is a servo of one model."""

    def __init__(self, model: ServoModel) -> None:
        super().__init__(dict.fromkeys(range(254), model))


def _models(robot: str | None, bus: str | None, servo: str | None) -> tuple[dict[int, ServoModel], str | None]:
    if servo is not None:
        model = load_servo(servo)
        return _Everyone(model), model.protocol
    if robot is None:
        return {}, None
    blueprint = load(robot)
    if bus is None and len(blueprint.wiring) > 1:
        raise UsageError(f"{robot} has several buses: say --bus {' or --bus '.join(blueprint.wiring)}")
    if bus is not None and bus not in blueprint.wiring:
        raise UsageError(f"{robot} has no bus {bus!r}; it has {', '.join(blueprint.wiring)}")
    wired = blueprint.wiring[bus or next(iter(blueprint.wiring))]
    return {each.id: each.model for each in wired}, wired[0].model.protocol

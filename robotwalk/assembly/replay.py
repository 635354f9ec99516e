"""A recorded run again: the robot of the log, its loop and its bus, on the time and the bytes of then."""

from pathlib import Path
from typing import NamedTuple

from robotwalk.assembly.blueprint import Files, build
from robotwalk.assembly.session import bus_of, foot_switches_of, imu_of, loop_of
from robotwalk.errors import UsageError
from robotwalk.log import Log
from robotwalk.loop import Loop
from robotwalk.playback import Difference, Playback
from robotwalk.tape import Call, Concluded, Failed, Now, Received, Sent, Step, Wait


class Replay(NamedTuple):
    """What came of it."""

    robot: str
    ticks: int
    sent_bytes: int
    received_bytes: int
    difference: Difference | None
    damage: str | None  # how the log ends, if other than it should


def replay(path: Path) -> Replay:
    """Run the loop of a log again, up to the first difference.

    Raises:
        UsageError: it is no log, or of another version.
        ConfigError: this version does not take the files that are in it.
    """
    with Log(path) as log:
        if "black_box" in log.about:
            raise UsageError(
                f"{path} is a black box ({log.about['black_box']}): it has no bytes to replay; PlotJuggler and "
                "Foxglove show what is in it")
        blueprint = build(Files.parse(log.files))
        if "hung" in log.about:
            blueprint = blueprint.hang()
        rate_hz = _rate(log, path)
        playback = Playback(log.steps())

        def make() -> Loop:
            clock = playback.clock()
            ports = {name: playback.port(name) for name in blueprint.lines}
            bus, imu = bus_of(blueprint, clock, ports), imu_of(blueprint, clock, ports)
            switches = foot_switches_of(blueprint, clock, ports)
            return loop_of(blueprint, clock, bus, imu, switches, rate_hz, playback.conclude)

        playback.run(make)
        difference = playback.difference
        if difference is not None and difference.recorded is None and log.damage is not None:
            difference = None  # the log is at its end, not the run
        return Replay(
            blueprint.model.name, playback.ticks, playback.sent_bytes, playback.received_bytes, difference, log.damage)


def _rate(log: Log, path: Path) -> int:
    try:
        return int(log.about["rate_hz"])
    except (KeyError, ValueError):
        raise UsageError(f"{path} does not tell its rate") from None


def in_words(step: Step | None) -> str:
    """Return what a step is."""
    match step:
        case None:
            return "nothing more"
        case Call(name, argument):
            return f"the loop is told to {name}" + ("" if argument is None else f": {argument}")
        case Now(time):
            return f"the clock is read ({time} ns)"
        case Wait(deadline):
            return f"it waits until {deadline} ns"
        case Sent(bus, _, data):
            return f"it sends on {bus}: {data.hex(' ')}"
        case Received(bus, _, data):
            return f"it reads {bus}: {data.hex(' ') or 'nothing has come'}"
        case Failed(bus, reason):
            return f"{bus} fails: {reason}"
        case Concluded(joints):
            return f"it finds the joints as {joints}"

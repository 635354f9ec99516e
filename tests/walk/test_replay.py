"""A recorded run, replayed: the same bytes again, whatever has happened in it."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from mcap.records import Attachment, Channel, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap.writer import Writer

from hal.register_map import ServoModel
from robotwalk import assembly
from robotwalk.assembly.replay import replay
from robotwalk.config import library
from robotwalk.config.document import Document
from robotwalk.errors import BusError, SafetyStop, UsageError
from robotwalk.loop import Tick
from robotwalk.supervisor import State
from robotwalk.tape import Concluded, Sent
from sim_backend.device import Reply


class Tampered:
    """What is on a bus, with someone at the wire on its way back."""

    def __init__(self, device: Any, tamper: Callable[[bytes, int], bytes]) -> None:
        self.device, self.tamper = device, tamper

    def receive(self, data: bytes, now: int, baud: int) -> list[Reply]:
        replies = self.device.receive(data, now, baud)
        return [Reply(reply.delay_ns, self.tamper(reply.data, now)) for reply in replies]


def tampered(simulation: assembly.Simulation, tamper: Callable[[bytes, int], bytes]) -> None:
    port = simulation.world.ports["legs"]
    port.device = Tampered(port.device, tamper)  # type: ignore[assignment]


def messages(path: Path, topic: str) -> list[dict[str, Any]]:
    """Return all messages of a topic."""
    with path.open("rb") as file:
        return [json.loads(message.data) for _, _, message in make_reader(file).iter_messages(topics=topic)]


def record(path: Path, use: Callable[[assembly.Simulation], None], robot: str = "hexapod") -> assembly.Simulation:
    """Record a robot while it is used."""
    simulation = assembly.simulate(robot, log=path)
    with simulation.robot:
        use(simulation)
    return simulation


def short_walk(simulation: assembly.Simulation) -> None:
    simulation.robot.stand()
    simulation.robot.walk(vx=0.05, wz=0.1, seconds=0.6, height=simulation.robot.model.heights.stand + 0.005)
    simulation.robot.walk(vy=0.03, heading=0.2, seconds=0.3)


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the log of a short walk."""
    path = tmp_path_factory.mktemp("log") / "walk.mcap"
    record(path, short_walk)
    return path


def altered(path: Path, topic: str, number: int, change: Callable[[dict[str, Any]], None]) -> Path:
    """Write a log once more, with one message of a topic changed."""
    copy = path.with_name("altered.mcap")
    channels: dict[int, tuple[str, int]] = {}
    with path.open("rb") as source, copy.open("wb") as target:
        writer = Writer(target)
        writer.start()
        schema = writer.register_schema("object", "jsonschema", b"{}")
        for record in StreamReader(source).records:
            match record:
                case Metadata():
                    writer.add_metadata(record.name, record.metadata)
                case Attachment():
                    writer.add_attachment(0, 0, record.name, record.media_type, record.data)
                case Channel() if record.id not in channels:
                    channels[record.id] = record.topic, writer.register_channel(record.topic, "json", schema)
                case Message():
                    name, channel = channels[record.channel_id]
                    fields = json.loads(record.data)
                    if name == topic:
                        if number == 0:
                            change(fields)
                        number -= 1
                    writer.add_message(channel, record.log_time, json.dumps(fields).encode(), record.publish_time)
        writer.finish()
    assert number < 0
    return copy


def flip(fields: dict[str, Any]) -> None:
    """Flip a bit of the last byte."""
    data = bytearray.fromhex(fields["bytes"])
    data[-1] ^= 1
    fields["bytes"] = data.hex(" ")


def test_a_walk_on_two_buses_replays_to_the_same_bytes(tmp_path: Path) -> None:
    log = tmp_path / "walk.mcap"
    ticks: list[Tick] = []

    def watched(simulation: assembly.Simulation) -> None:
        simulation.robot.observers.append(ticks.append)
        short_walk(simulation)

    statistics = record(log, watched, "octopod").bus.statistics()
    again = replay(log)
    assert (again.difference, again.damage) == (None, None)
    assert again.ticks == len(ticks)
    assert len(statistics) == 2
    assert again.sent_bytes == sum(bus.tx_bytes for bus in statistics.values())
    assert again.received_bytes == sum(bus.rx_bytes for bus in statistics.values())


def nth_long(walk: Path, topic: str, number: int) -> int:
    """Return which message of a topic is the so many-th that carries goals or all joints' states."""
    return [i for i, message in enumerate(messages(walk, topic)) if len(message["bytes"]) > 300][number]


def test_a_byte_that_was_sent_otherwise_is_found(walk: Path) -> None:
    number = nth_long(walk, "/bus/legs/tx", 100)
    difference = replay(altered(walk, "/bus/legs/tx", number, flip)).difference
    assert difference is not None
    assert isinstance(difference.recorded, Sent)
    assert isinstance(difference.replayed, Sent)
    changed = [a ^ b for a, b in zip(difference.recorded.data, difference.replayed.data, strict=True)]
    assert changed == [0] * (len(changed) - 1) + [1]
    with walk.open("rb") as file:
        sent = [message for _, _, message in make_reader(file).iter_messages(topics="/bus/legs/tx")]
    assert difference.time <= sent[number].log_time < difference.time + 10_000_000


def test_a_byte_that_was_received_otherwise_is_found(walk: Path) -> None:
    """The bit is in the CRC of the last servo's answer, which counts as lost then."""
    difference = replay(altered(walk, "/bus/legs/rx", nth_long(walk, "/bus/legs/rx", 100), flip)).difference
    assert difference is not None
    assert isinstance(difference.recorded, Concluded)
    assert isinstance(difference.replayed, Concluded)
    assert difference.recorded.joints.valid == (True,) * 18
    assert difference.replayed.joints.valid == (True,) * 17 + (False,)


def test_another_time_is_found(walk: Path) -> None:
    def later(fields: dict[str, Any]) -> None:
        fields["steps"] = [["now", step[1] + 10**9] if step[0] == "now" else step for step in fields["steps"]]

    assert replay(altered(walk, "/tape", 200, later)).difference is not None


def test_a_walk_of_lost_and_garbled_replies_that_ends_in_a_safety_stop_replays(tmp_path: Path) -> None:
    log, count = tmp_path / "faulty.mcap", 0

    def spoil(data: bytes, now: int) -> bytes:
        nonlocal count
        count += 1
        if now > 4_500_000_000 or (now > 2_000_000_000 and count % 20 == 0):
            return data[:-14]
        return bytes((*data[:40], data[40] ^ 4, *data[41:])) if now > 2_000_000_000 and count % 30 == 0 else data

    def use(simulation: assembly.Simulation) -> None:
        tampered(simulation, spoil)
        simulation.robot.stand()
        with pytest.raises(SafetyStop):
            simulation.robot.walk(vx=0.1, seconds=20.0)

    statistics = record(log, use).bus.statistics()["legs"]
    assert statistics.bad_frames > 3
    assert statistics.lost_replies > 100
    again = replay(log)
    assert (again.difference, again.damage) == (None, None)


def test_a_robot_that_was_frozen_replays(tmp_path: Path) -> None:
    log = tmp_path / "frozen.mcap"

    def impatient(tick: Tick) -> None:
        if tick.state is State.SIT:
            raise KeyboardInterrupt

    def use(simulation: assembly.Simulation) -> None:
        simulation.robot.observers.append(impatient)
        simulation.robot.stand()
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        record(log, use)
    again = replay(log)
    assert again.difference is None
    events = messages(log, "/events")
    assert [event["text"] for event in events if event["kind"] in ("interrupt", "freeze")] == [
        "interrupted", "frozen in place; torque stays on"]


def test_a_robot_that_does_not_arm_replays(tmp_path: Path) -> None:
    log = tmp_path / "dead.mcap"

    def use(simulation: assembly.Simulation) -> None:
        tampered(simulation, lambda data, now: b"")
        with pytest.raises(BusError):
            simulation.robot.stand()

    sent = record(log, use).bus.statistics()["legs"].tx_bytes
    again = replay(log)
    assert (again.ticks, again.difference) == (0, None)
    assert again.sent_bytes == sent > 0


def test_a_log_that_breaks_off_is_replayed_as_far_as_it_goes(walk: Path, tmp_path: Path) -> None:
    whole, cut = replay(walk), tmp_path / "cut.mcap"
    data = walk.read_bytes()
    cut.write_bytes(data[: len(data) * 2 // 3])
    again = replay(cut)
    assert again.damage == "it breaks off"
    assert again.difference is None
    assert 0.2 * whole.ticks < again.ticks < whole.ticks


def test_the_files_of_then_count_not_those_of_now(tmp_path: Path) -> None:
    robot, log = tmp_path / "mine.yaml", tmp_path / "walk.mcap"
    text = assembly.load("hexapod").files.robot.text
    robot.write_text(text.replace("lift_mm: 30", "lift_mm: 20"))
    record(log, lambda simulation: simulation.robot.stand(), str(robot))
    robot.write_text("ruined")
    assert replay(log).difference is None


def test_what_is_no_log(tmp_path: Path) -> None:
    path = tmp_path / "x.mcap"
    with pytest.raises(UsageError, match=r"cannot read the log .*x.mcap: No such file"):
        replay(path)
    for data in (b"", b"nonsense" * 100, b"\x89MCAP0\r\n"):
        path.write_bytes(data)
        with pytest.raises(UsageError, match=r"x.mcap is no log of robotwalk: it (breaks off|is damaged)"):
            replay(path)


@pytest.mark.parametrize("name", library.names("servos"))
def test_a_servos_text_in_a_log_stands_alone(name: str) -> None:
    document = library.open_document("servos", name)
    assert Document.parse(document.whole_text, name).validate(ServoModel) == document.validate(ServoModel)

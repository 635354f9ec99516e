"""Protocol 1.0 as the MX series knows it, reboot and bulk read included: by X430 and MX servos told to speak it."""

from collections.abc import Mapping

import pytest
from dynamixel_sdk import GroupBulkRead

from hal import checksum_frames
from hal.protocols import protocol_named

from .tour_bench import BAUD, TourBench
from .tour_clients import DONE, Answer, Client, DynamixelSdk1, Ours

ANGLE_LIMIT, RANGE, CHECKSUM, INSTRUCTION = 0x02, 0x08, 0x10, 0x40
MODELS = ("xl430-w250", "xm430-w350", "mx-28")
ALL = {0x01, 0x02, 0x03, 0x04, 0x05, 0x06, 0x08, 0x83, 0x92}
AWAY = 0.31  # s, silent after a restart


class Sdk(DynamixelSdk1):
    def bulk_read(self, ranges: Mapping[int, tuple[int, int]]) -> list[bytes]:
        """Its group reader cannot: since 3.8.2 it hands its handler an argument too many."""
        group = GroupBulkRead(self.port, self.handler)
        for servo_id, each in ranges.items():
            assert group.addParam(servo_id, *each)
        with pytest.raises(TypeError):
            group.txPacket()
        items = [byte for servo_id, (address, length) in ranges.items() for byte in (length, servo_id, address)]
        assert self.handler.bulkReadTx(self.port, items, len(items)) == 0
        return [bytes(self.handler.readRx(self.port, servo_id, each[1])[0]) for servo_id, each in ranges.items()]


class OursFirst(Ours):
    def __init__(self, bench: TourBench) -> None:
        super().__init__(bench)
        self.protocol, self._frame = protocol_named("dynamixel-1.0"), checksum_frames.frame

    def bulk_read(self, ranges: Mapping[int, tuple[int, int]]) -> list[bytes]:  # type: ignore[override]
        request, reply = self.protocol.bulk_read([(servo_id, *each) for servo_id, each in ranges.items()])
        self.bench.port.write(request)
        self.bench.clock.wait((), self.bench.clock.now() + 5_000_000)
        reply.feed(self.bench.port.read())
        return [status.data for status in reply.results.values()]


@pytest.mark.parametrize("client", [Sdk, OursFirst])
@pytest.mark.parametrize("name", MODELS)
def test_every_instruction_and_every_error(name: str, client: type[Client]) -> None:
    bench = TourBench(name, 1, 2, frames="dynamixel-1.0", protocol_type=1)
    bus = client(bench)

    def value(address: int, length: int) -> int:
        answer = bus.read(1, address, length)
        assert answer is not None
        return int.from_bytes(answer.data, "little")

    assert bus.ping(1)
    assert not bus.ping(3)
    assert value(0, 2) == bench.model.model_number
    assert bus.reg_write(1, 65, b"\1") == DONE
    assert (value(65, 1), value(69, 1)) == (0, 1)
    assert bus.action(1) in {DONE, None}
    assert value(65, 1) == 1
    bus.sync_write(84, {1: b"\1\0", 2: b"\2\0"})
    assert bus.bulk_read({2: (84, 2), 1: (132, 2)}) == [b"\2\0", b"\0\x08"]  # type: ignore[attr-defined]

    assert bus.write(1, 116, b"\0\x20\0\0") == Answer(ANGLE_LIMIT)
    assert bus.write(1, 146, b"\0") == bus.write(1, 11, b"\2") == Answer(RANGE)
    assert bus.instruct(1, 0x7F) == Answer(INSTRUCTION)
    assert bus.instruct(1, 0x10) == Answer(INSTRUCTION), "of Protocol 2.0"
    bench.witness.garble = True
    assert bus.write(1, 65, b"\0") == Answer(CHECKSUM)
    bench.physics.temperature_c[0] = 101.0
    bench.pass_time(0.01)
    bench.physics.temperature_c[0] = 30.0
    assert bus.read(1, 132, 2) == Answer(alert=True, data=b"\0\x08")
    assert bus.instruct(1, 0x08) is not None
    assert not bus.ping(1)
    bench.pass_time(AWAY)
    assert bus.read(1, 70, 1) == Answer(data=b"\0")
    bench.physics.supply_v[0] = 20.0
    bench.pass_time(0.01)
    assert bus.read(1, 70, 1) == Answer(alert=True, data=b"\1")
    bench.physics.supply_v[0] = 12.0
    bus.instruct(1, 0x08)
    bench.pass_time(AWAY)
    assert bus.write(1, 64, b"\1") == bus.write(1, 116, b"\xac\x0d\0\0") == DONE
    bench.pass_time(2.2)
    assert bus.read(1, 64, 1) == Answer(alert=True, data=b"\0"), "overload"
    assert bus.instruct(1, 0x06) is not None
    bench.pass_time(AWAY)
    assert bench.servos[0].table["protocol_type"] == 2, "back to what the factory has set"
    assert bench.witness.instructions == ALL
    assert bench.witness.errors == {1 << bit for bit in range(7)}


def test_servos_of_either_protocol_share_a_wire() -> None:
    bench = TourBench("mx-28", 1, 2)
    second, first = Ours(bench), OursFirst(bench)
    assert second.write(2, 13, b"\1") == DONE
    assert [second.ping(1), second.ping(2), first.ping(1), first.ping(2)] == [True, False, False, True]
    assert first.write(2, 13, b"\2") == DONE
    assert [second.ping(2), first.ping(2)] == [True, False]
    assert bench.port.baud == BAUD

"""Every instruction and every error of Protocol 2.0, on every model that has it, by ROBOTIS's SDK and by us."""

from collections.abc import Iterator

import pytest

from .reference_list import ALERT, ERRORS, HARDWARE_ERRORS, INSTRUCTIONS, MX, X_SERIES
from .tour_bench import BAUD, TourBench
from .tour_clients import DONE, Answer, DynamixelClient, DynamixelSdk2, Ours

CLEAR, STORE, RESTORE = b"\x01DXL\x22", b"\x01CTRL", b"\x02CTRL"
TURN = 4096
BROADCAST = 0xFE
AWAY = 0.31  # s, silent after a restart

ALL_MODELS = pytest.mark.parametrize("name", X_SERIES + MX)
CLIENTS = pytest.mark.parametrize("client", [DynamixelSdk2, Ours])


def word(value: int) -> bytes:
    return value.to_bytes(4, "little", signed=True)


class Tour:
    """One client, two servos."""

    def __init__(self, name: str, client: type[DynamixelClient]) -> None:
        self.bench = TourBench(name, 1, 2, switches={"shock_at_power_up": True})
        self.client = client(self.bench)
        self.fast = 0x8A in INSTRUCTIONS[name]

    def value(self, address: int, length: int, servo_id: int = 1) -> int:
        answer = self.client.read(servo_id, address, length)
        assert answer is not None
        assert answer.error == 0
        return int.from_bytes(answer.data, "little", signed=length == 4)

    def set(self, address: int, data: bytes) -> None:
        assert self.client.write(1, address, data) == DONE

    def refused(self, address: int, data: bytes) -> int:
        answer = self.client.write(1, address, data)
        assert answer is not None
        return answer.error

    def restart(self) -> None:
        answer = self.client.instruct(1, 0x08)
        assert answer is not None
        assert answer.error == 0
        assert not self.client.ping(1), "it is away"
        self.bench.pass_time(AWAY)
        assert self.client.ping(1)


def read_and_write(tour: Tour) -> None:
    client = tour.client
    assert client.broadcast_ping() == {1, 2}
    assert client.ping(1)
    assert not client.ping(3)
    assert tour.value(0, 2) == tour.bench.model.model_number
    assert tour.value(132, 4) == 2048
    tour.set(65, b"\1")
    assert tour.value(65, 1) == 1
    assert client.reg_write(1, 65, b"\0") == DONE
    assert (tour.value(65, 1), tour.value(69, 1)) == (1, 1)
    assert client.action(1) in {DONE, None}
    assert (tour.value(65, 1), tour.value(69, 1)) == (0, 0)


def groups(tour: Tour) -> None:
    client = tour.client
    tour.bench.turned = 100
    tour.bench.pass_time(0.01)
    client.sync_write(65, {1: b"\1", 2: b"\1"})
    assert client.sync_read(65, 1, (2, 1)) == [1, 1]
    assert client.sync_read(132, 4, (1, 2)) == [2148, 2148]
    client.bulk_write({1: (65, b"\0"), 2: (84, b"\x20\3")})
    assert client.bulk_read({1: (65, 1), 2: (84, 2)}, fast=False) == [0, 800]
    fast = client.fast_sync_read(132, 4, (2, 1)), client.bulk_read({1: (65, 1), 2: (84, 2)}, fast=True)
    assert fast == (([2148, 2148], [0, 800]) if tour.fast else ([None, None], [None, None]))
    tour.bench.turned = 0


def refusals(tour: Tour) -> None:
    client, witness = tour.client, tour.bench.witness
    assert tour.refused(146, b"\1") == 7, "read-only"
    assert tour.refused(11, b"\2") == 4, "no such mode"
    assert tour.refused(116, b"\0\x08") == 5, "half a register"
    assert tour.refused(116, word(5000)) == 6, "beyond the limits"
    assert tour.refused(100, (900).to_bytes(2, "little")) == 4
    tour.set(36, b"\x64\0")
    assert tour.refused(100, b"\x65\0") == 6, "beyond the PWM limit"
    tour.set(36, b"\x75\3")
    assert client.read(1, 700, 1) == Answer(7)
    assert client.instruct(1, 0x7F) == Answer(2)
    assert client.action(1) in {Answer(2), None}, "nothing is registered"
    witness.garble = True
    assert client.write(1, 65, b"\1") == Answer(3)
    tour.set(64, b"\1")
    assert tour.refused(9, b"\0") == 7, "the EEPROM is locked while torque is on"
    tour.set(64, b"\0")


def turns(tour: Tour) -> None:
    tour.set(11, b"\4")
    tour.bench.turned = TURN + 50
    tour.bench.pass_time(0.01)
    assert tour.value(132, 4) == TURN + 2098
    assert tour.client.instruct(1, 0x10, CLEAR) == DONE
    assert tour.value(132, 4) == 2098
    tour.set(64, b"\1")
    tour.set(112, word(1))
    tour.set(116, word(3 * TURN))
    assert tour.client.instruct(1, 0x10, CLEAR) == Answer(1), "it moves"
    tour.set(64, b"\0")
    tour.set(11, b"\3")
    tour.bench.turned = 0
    tour.bench.pass_time(0.01)


def backup(tour: Tour) -> None:
    client = tour.client
    if 0x20 not in INSTRUCTIONS[tour.bench.model.name]:
        assert client.instruct(1, 0x20, STORE) == Answer(2)
        return
    tour.set(84, b"\x39\2")
    assert client.instruct(1, 0x20, STORE) == DONE
    tour.set(84, b"\1\0")
    tour.set(64, b"\1")
    assert client.instruct(1, 0x20, RESTORE) == Answer(1)
    tour.set(64, b"\0")
    assert client.instruct(1, 0x20, RESTORE) == DONE
    tour.bench.pass_time(AWAY)
    assert (tour.value(84, 2), tour.value(147, 1)) == (0x239, 1)


def watchdog(tour: Tour) -> None:
    tour.set(64, b"\1")
    tour.set(98, b"\1")
    tour.bench.pass_time(0.05)
    assert tour.value(98, 1) == 0xFF
    for address, data in ((116, word(2048)), (104, word(0)), (100, b"\0\0")):
        assert tour.refused(address, data) == 4
    if "goal_current" in tour.bench.model.by_name:
        assert tour.refused(102, b"\0\0") == 4
    tour.set(98, b"\0")
    tour.set(116, word(2048))
    tour.set(64, b"\0")


def hardware_errors(tour: Tour) -> Iterator[int]:
    """Yield the bits of register 70 that were seen, each with the alert bit in the answer, and gone after a restart."""
    bench, client, servo = tour.bench, tour.client, tour.bench.servos[0]

    def seen() -> int:
        answer = client.read(1, 70, 1)
        assert answer is not None
        assert (answer.error, answer.alert) == (0, True)
        return answer.data[0]

    tour.set(63, b"\x3d")
    before = bench.physics.supply_v[0]
    bench.physics.supply_v[0] = 20.0
    bench.pass_time(0.01)
    bench.physics.supply_v[0] = before
    yield seen()
    assert client.write(1, 64, b"\1") == Answer(0, True), "taken without effect"
    assert client.read(1, 64, 1) == Answer(0, True, b"\0")
    tour.restart()
    bench.physics.temperature_c[0] = 101.0
    bench.pass_time(0.01)
    bench.physics.temperature_c[0] = 30.0
    yield seen()
    tour.restart()
    servo.encoder_fails = True
    bench.pass_time(0.01)
    servo.encoder_fails = False
    yield seen()
    tour.restart()
    servo.lose_power(bench.clock.now(), 0.1)
    bench.pass_time(0.1 + AWAY)
    yield seen()
    tour.restart()
    tour.set(64, b"\1")
    tour.set(116, word(3500))
    bench.pass_time(2.2)
    yield seen()
    tour.restart()
    assert client.read(1, 70, 1) == Answer(data=b"\0")


def who_answers(tour: Tour) -> None:
    client, bench = tour.client, tour.bench
    tour.set(12, b"\x09")
    assert client.write(9, 65, b"\1") is None, "a secondary id is obeyed in silence"
    assert tour.value(65, 1) == 1
    tour.set(68, b"\1")
    assert client.write(1, 65, b"\0") is None
    assert tour.value(65, 1) == 0
    client.write(1, 68, b"\0")
    assert client.read(1, 65, 1) is None
    assert client.ping(1), "a ping is always answered"
    client.write(1, 68, b"\2")
    tour.set(7, b"\2")
    assert client.read(2, 0, 2) is None, "two servos at one id garble each other"
    bench.servos[0].answer_to(1)
    tour.set(8, b"\2")
    assert not client.ping(1)
    bench.port.baud = 115_200
    tour.set(8, b"\3")
    bench.port.baud = BAUD


def factory_reset(tour: Tour) -> None:
    client, bench = tour.client, tour.bench
    tour.set(84, b"\1\0")
    assert client.instruct(1, 0x06, b"\x02") == DONE
    bench.pass_time(AWAY)
    assert tour.value(84, 2) == bench.model["position_p_gain"].default
    assert client.instruct(1, 0x06, b"\x77") == Answer(4)
    tour.set(7, b"\5")
    assert client.instruct(5, 0x06, b"\x01") == DONE
    bench.pass_time(AWAY)
    bench.port.baud = 57600
    assert client.ping(5), "the id is kept, the baud rate is not"
    assert client.instruct(5, 0x06, b"\xff") == DONE
    bench.pass_time(AWAY)
    assert client.ping(1)


@CLIENTS
@ALL_MODELS
def test_every_instruction_and_every_error(name: str, client: type[DynamixelClient]) -> None:
    tour = Tour(name, client)
    for part in (read_and_write, groups, refusals, turns, backup, watchdog):
        part(tour)
    assert set(hardware_errors(tour)) == HARDWARE_ERRORS
    who_answers(tour)
    factory_reset(tour)
    witness = tour.bench.witness
    assert witness.instructions == INSTRUCTIONS[name]
    assert witness.errors >= ERRORS[name]
    assert witness.errors <= set(range(1, 8)) | {ALERT}

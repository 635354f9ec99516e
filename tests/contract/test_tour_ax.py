"""Every instruction and every error of Protocol 1.0 that an AX-12A has, by ROBOTIS's SDK and by us."""

import pytest

from .reference_list import AX, ERRORS, INSTRUCTIONS, UNCERTAIN
from .tour_bench import BAUD, TourBench
from .tour_clients import DONE, Answer, Client, DynamixelSdk1, Ours

ANGLE_LIMIT, RANGE, CHECKSUM, INSTRUCTION = 0x02, 0x08, 0x10, 0x40
AWAY = 0.31  # s, silent after a restart

pytestmark = [pytest.mark.parametrize("name", AX), pytest.mark.parametrize("client", [DynamixelSdk1, Ours])]


class Tour:
    def __init__(self, name: str, client: type[Client], **switches: object) -> None:
        self.bench = TourBench(name, 1, 2, switches=switches)
        self.client = client(self.bench)

    def value(self, address: int, length: int) -> int:
        answer = self.client.read(1, address, length)
        assert answer is not None
        assert answer.error == 0
        return int.from_bytes(answer.data, "little")

    def set(self, address: int, data: bytes) -> None:
        assert self.client.write(1, address, data) == DONE


def read_and_write(tour: Tour) -> None:
    client = tour.client
    assert client.ping(1)
    assert not client.ping(3)
    assert (tour.value(0, 2), tour.value(36, 2)) == (12, 512)
    tour.set(25, b"\1")
    assert client.reg_write(1, 25, b"\0") == DONE
    assert (tour.value(25, 1), tour.value(44, 1)) == (1, 1)
    assert client.action(1) in {DONE, None}
    assert (tour.value(25, 1), tour.value(44, 1)) == (0, 0)
    client.sync_write(25, {1: b"\1", 2: b"\1"})
    assert [servo.table["led"] for servo in tour.bench.servos] == [1, 1]


def refusals(tour: Tour) -> None:
    client = tour.client
    tour.set(6, b"\x64\0")
    assert client.write(1, 30, b"\x63\0") == Answer(ANGLE_LIMIT)
    tour.set(6, b"\0\0")
    assert client.write(1, 36, b"\0\0") == Answer(RANGE), "read-only"
    assert client.write(1, 30, b"\0\4") == Answer(RANGE), "beyond 1023"
    assert client.instruct(1, 0x7F) == Answer(INSTRUCTION)
    assert client.action(1) in {Answer(INSTRUCTION), None}, "nothing is registered"
    assert client.instruct(1, 0x08) == Answer(INSTRUCTION), "reboot came with the MX"
    tour.bench.witness.garble = True
    assert client.write(1, 25, b"\1") == Answer(CHECKSUM)
    tour.set(47, b"\1")
    assert client.write(1, 5, b"\0") == Answer(RANGE), "the EEPROM is locked"
    tour.bench.servos[0].lose_power(tour.bench.clock.now(), 0.1)
    tour.bench.pass_time(0.1 + AWAY)
    tour.set(5, b"\0")


def conditions(tour: Tour) -> None:
    """Each comes with data as long as it lasts; in the shutdown mask, it takes the torque away."""
    bench, client = tour.bench, tour.client
    for values, bad, lets_go in ((bench.physics.supply_v, 20.0, 0), (bench.physics.temperature_c, 90.0, 1)):
        before = values[0]
        values[0] = bad
        bench.pass_time(0.01)
        assert client.read(1, 36, 2) == Answer(alert=True, data=b"\0\2")
        values[0] = before
        bench.pass_time(0.01)
        assert client.ping(1)
        assert tour.value(34, 2) == (0 if lets_go else 1023)
        tour.set(34, b"\xff\3")
    tour.set(24, b"\1")
    tour.set(30, b"\x84\3")
    bench.pass_time(2.2)
    assert client.read(1, 34, 2) == Answer(alert=True, data=b"\0\0")
    assert client.write(1, 34, b"\xff\3") == Answer(alert=True), "which ends the overload"
    tour.set(24, b"\0")


def who_answers(tour: Tour) -> None:
    client, bench = tour.client, tour.bench
    tour.set(16, b"\1")
    assert client.write(1, 25, b"\0") is None
    assert tour.value(25, 1) == 0
    client.write(1, 16, b"\0")
    assert client.read(1, 25, 1) is None
    assert client.ping(1)
    client.write(1, 16, b"\2")
    tour.set(3, b"\2")
    assert client.read(2, 0, 2) is None, "two servos at one id garble each other"
    bench.servos[0].answer_to(1)
    tour.set(4, b"\x10")
    assert not client.ping(1)
    bench.port.baud = 115_200
    tour.set(4, b"\1")
    bench.port.baud = BAUD


def factory_reset(tour: Tour) -> None:
    tour.set(3, b"\5")
    assert tour.client.instruct(5, 0x06) == DONE
    tour.bench.pass_time(AWAY)
    assert tour.client.ping(1)


def test_every_instruction_and_every_error(name: str, client: type[Client]) -> None:
    tour = Tour(name, client)
    for part in (read_and_write, refusals, conditions, who_answers, factory_reset):
        part(tour)
    assert tour.bench.witness.instructions == INSTRUCTIONS[name]
    assert tour.bench.witness.errors == ERRORS[name]


def test_what_a_switch_adds(name: str, client: type[Client]) -> None:
    tour = Tour(name, client, reboot=True)
    tour.set(25, b"\1")
    assert tour.client.instruct(1, 0x08) == DONE
    assert not tour.client.ping(1)
    tour.bench.pass_time(AWAY)
    assert tour.value(25, 1) == 0
    assert tour.bench.witness.instructions >= UNCERTAIN[name]

"""Every instruction and every error of Feetech's protocol, on every model that has it, by its SDK and by us."""

import pytest

from .reference_list import ERRORS, INSTRUCTIONS, SCS, STS, UNCERTAIN
from .tour_bench import BAUD, TourBench
from .tour_clients import DONE, Answer, Client, FeetechSdk, Ours

AWAY = 0.31  # s, silent after a restart
TURN = 4096
# Settings, how long the motor is held then, the bit of the status: 2 s of overload, before 2.54 s of over-current;
# 0.1 s of more than 32.5 mA.
OVERLOADED = {}, 2.3, 0x20
STS_OVERLOADED = {38: b"\xfe"}, 2.3, 0x20
OVER_CURRENT = {28: b"\5\0", 38: b"\x0a"}, 0.2, 0x08

ALL_MODELS = pytest.mark.parametrize("name", STS + SCS)
CLIENTS = pytest.mark.parametrize("client", [FeetechSdk, Ours])


class Tour:
    def __init__(self, name: str, client: type[Client], **switches: object) -> None:
        self.bench = TourBench(name, 1, 2, switches=switches)
        self.client = client(self.bench)
        self.sts = name in STS
        self.lock = 55 if self.sts else 48

    def value(self, address: int, length: int) -> int:
        answer = self.client.read(1, address, length)
        assert answer is not None
        return int.from_bytes(answer.data, "little" if self.sts else "big")

    def set(self, address: int, data: bytes) -> None:
        assert self.client.write(1, address, data) == DONE

    def word(self, value: int) -> bytes:
        return value.to_bytes(2, "little" if self.sts else "big")


def read_and_write(tour: Tour) -> None:
    client, bench = tour.client, tour.bench
    assert client.ping(1)
    assert not client.ping(3)
    assert (tour.value(3, 2), tour.value(56, 2)) == (bench.model.model_number, bench.model.encoder.centre)
    tour.set(42, tour.word(700))
    assert tour.value(42, 2) == 700
    assert client.reg_write(1, 42, tour.word(500)) == DONE
    assert (tour.value(42, 2), tour.value(64, 1)) == (700, 1)
    assert client.action(1) in {DONE, None}
    assert (tour.value(42, 2), tour.value(64, 1)) == (500, 0)
    client.sync_write(42, {1: tour.word(600), 2: tour.word(601)})
    assert [servo.table["goal_position"] for servo in bench.servos] == [600, 601]
    assert client.sync_read(42, 2, (2, 1)) == ([601, 600] if tour.sts else [None, None])
    tour.set(42, tour.word(bench.model.encoder.centre))


def not_understood(tour: Tour) -> None:
    """There is no error for it: silence, or an answer that says nothing."""
    client = tour.client
    assert client.instruct(1, 0x7F) is None
    assert client.instruct(1, 0x08) is None
    assert client.instruct(1, 0x0B) is None
    tour.bench.witness.garble = True
    assert client.write(1, 42, tour.word(1)) is None
    tour.set(56, tour.word(1))
    assert tour.value(56, 2) == tour.bench.model.encoder.centre, "read-only"
    tour.set(13, b"\xff")
    assert tour.value(13, 1) == tour.bench.model["max_temperature_limit"].default, "out of range"


def the_lock(tour: Tour) -> None:
    bench = tour.bench
    p = bench.model["position_p_gain"].default
    for locked, kept in ((1, p), (0, 99)):
        tour.set(tour.lock, bytes((locked,)))
        tour.set(21, b"\x63")
        assert tour.value(21, 1) == 99
        bench.servos[0].lose_power(bench.clock.now(), 0.1)
        bench.pass_time(0.1 + AWAY)
        assert tour.value(21, 1) == kept


def turns(tour: Tour) -> None:
    client, bench = tour.client, tour.bench
    if not tour.sts:
        assert client.instruct(1, 0x0A) == DONE, "without effect: a potentiometer knows no turns"
        return
    tour.set(18, b"\x1c")  # multi-turn feedback
    for address in (9, 11):
        tour.set(address, tour.word(0))
    bench.turned = TURN + 50
    bench.pass_time(0.01)
    assert tour.value(56, 2) == TURN + 2098
    assert client.instruct(1, 0x0A) == DONE
    assert tour.value(56, 2) == 2098
    tour.set(18, b"\x0c")
    tour.set(11, tour.word(TURN - 1))
    tour.set(40, b"\x80")
    assert (tour.value(56, 2), tour.value(31, 2)) == (2048, 50), "here is the centre"
    tour.set(31, tour.word(0))
    bench.turned = 0


def conditions(tour: Tour) -> None:
    """Each comes with every answer, data included, as long as it lasts."""
    bench, client = tour.bench, tour.client
    bench.pass_time(0.01)
    here = Answer(alert=True, data=tour.word(bench.model.encoder.centre))
    for values, bad in ((bench.physics.supply_v, 30.0), (bench.physics.temperature_c, 100.0)):
        before = values[0]
        values[0] = bad
        bench.pass_time(0.01)
        assert client.read(1, 56, 2) == here
        values[0] = before
        bench.pass_time(0.01)
        assert client.read(1, 65, 1) == Answer(data=b"\0"), "it passes by itself"
    if tour.sts:
        bench.servos[0].encoder_fails = True
        bench.pass_time(0.01)
        assert client.read(1, 65, 1) == Answer(alert=True, data=b"\x02")
        bench.servos[0].encoder_fails = False
        bench.pass_time(0.01)
    for setting, seconds, bit in (STS_OVERLOADED, OVER_CURRENT) if tour.sts else (OVERLOADED,):
        for address, data in setting.items():
            tour.set(address, data)
        tour.set(40, b"\1")
        tour.set(42, tour.word(bench.model.encoder.centre + 400))
        bench.pass_time(seconds)
        assert client.read(1, 65, 1) == Answer(alert=True, data=bytes((bit,)))
        assert client.write(1, 40, b"\0") is not None
        bench.pass_time(0.01)
        assert client.read(1, 65, 1) == Answer(data=b"\0"), "torque off clears it"


def who_answers(tour: Tour) -> None:
    client, bench = tour.client, tour.bench
    tour.set(8, b"\0")
    assert client.write(1, 42, tour.word(300)) is None
    assert tour.value(42, 2) == 300
    assert client.ping(1)
    client.write(1, 8, b"\1")
    tour.set(5, b"\2")
    assert client.read(2, 3, 2) is None, "two servos at one id garble each other"
    bench.servos[0].answer_to(1)
    tour.set(6, b"\4")
    assert not client.ping(1)
    bench.port.baud = 115_200
    tour.set(6, b"\0")
    bench.port.baud = BAUD


def recovery(tour: Tour) -> None:
    tour.set(21, b"\x63")
    assert tour.client.instruct(1, 0x06) == DONE
    assert not tour.client.ping(1)
    tour.bench.pass_time(AWAY)
    assert tour.value(21, 1) == tour.bench.model["position_p_gain"].default


@CLIENTS
@ALL_MODELS
def test_every_instruction_and_every_error(name: str, client: type[Client]) -> None:
    tour = Tour(name, client)
    for part in (read_and_write, not_understood, the_lock, turns, conditions, who_answers, recovery):
        part(tour)
    assert tour.bench.witness.instructions == INSTRUCTIONS[name]
    assert tour.bench.witness.errors == ERRORS[name]


@CLIENTS
@ALL_MODELS
def test_what_switches_add(name: str, client: type[Client]) -> None:
    switches = {"calibrate": True, "damping": True} if name in STS else {}
    tour = Tour(name, client, reboot=True, torque_flag_in_status=True, eeprom_write_ms=25, **switches)
    tour.set(tour.lock, b"\0")
    before = tour.bench.clock.now()
    tour.set(21, b"\x63")
    assert tour.bench.clock.now() - before > 25_000_000, "the EEPROM takes its time"
    tour.set(40, b"\1")
    assert tour.value(65, 1) == 0x10, "torque is on"
    if name in STS:
        tour.bench.turned = 30
        tour.bench.pass_time(0.01)
        assert tour.client.instruct(1, 0x0B) == DONE
        assert (tour.value(56, 2), tour.value(31, 2)) == (2048, 30)
    assert tour.client.instruct(1, 0x08) == DONE
    assert not tour.client.ping(1)
    tour.bench.pass_time(AWAY)
    assert tour.value(40, 1) == 0
    assert tour.bench.witness.instructions >= UNCERTAIN[name]
    assert 0x10 in tour.bench.witness.errors

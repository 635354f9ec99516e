"""Who is found on a line, how long it takes, and what is told of lines where something is wrong."""

import pytest

from hal.maintenance.bench import Bench
from hal.maintenance.identity import Identity
from hal.maintenance.scan import Clash, Finding, Noise, Progress
from sim_backend.adapter import LatencyTimer
from sim_backend.device import Reply

from .rig import BAUD_57600, MODELS, MS, STS3215, XL430, Chatter, S, TickingClock, rig

BRANDS = pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])


def findings(bench: Bench) -> list[Finding]:
    return [finding for finding in bench.scan() if not isinstance(finding, Progress)]


def test_a_dynamixel_tells_who_it_is() -> None:
    assert findings(rig("xl430-w250", 7).bench) == [
        Identity(7, "dynamixel-2.0", 1_000_000, False, 1060, XL430, "45", 11.1, 30.0)]


def test_a_feetech_servo_tells_who_it_is() -> None:
    assert findings(rig("sts3215", 7).bench) == [
        Identity(7, "feetech-sts", 1_000_000, False, 777, STS3215, "3.7", 7.4, 30.0)]


@BRANDS
def test_every_id_is_found_from_the_first_to_the_last(name: str) -> None:
    found = findings(rig(name, 252, 0, 1, 100).bench)
    assert [identity.id for identity in found] == [0, 1, 100, 252]


@BRANDS
@pytest.mark.parametrize("delay", [0, 254])
def test_a_whole_robot_is_found_whatever_its_return_delay(name: str, delay: int) -> None:
    found = findings(rig(name, *range(1, 25), return_delay_time=delay).bench)
    assert [identity.id for identity in found] == list(range(1, 25))


@BRANDS
def test_a_servo_is_found_at_its_baud_rate_and_not_at_another(name: str) -> None:
    built = rig(name, 1, baud_rate=BAUD_57600[name])
    assert findings(built.bench) == []
    built.bench.tune(57600)
    assert [(identity.id, identity.baud) for identity in findings(built.bench)] == [(1, 57600)]


def test_at_a_low_baud_rate_dynamixels_outlast_their_slots_and_are_all_found() -> None:
    built = rig("xl430-w250", *range(240, 253), baud_rate=0)
    built.bench.tune(9600)
    assert [identity.id for identity in findings(built.bench)] == list(range(240, 253))


@BRANDS
def test_behind_an_adapter_that_holds_replies_back_all_are_found_too(name: str) -> None:
    built = rig(name, 1, 2, 3, 17, 252, adapter=LatencyTimer(16 * MS))
    assert [identity.id for identity in findings(built.bench)] == [1, 2, 3, 17, 252]


def test_an_empty_line_takes_the_slots_of_one_protocol_and_2_ms_a_ping_of_the_other() -> None:
    built = rig("xl430-w250", 1, baud_rate=BAUD_57600["xl430-w250"])
    findings(built.bench)
    assert 253 * 3 * MS < built.clock.now() < 1.4 * S
    built.bench.tune(4_500_000)  # no Feetech servo has it
    before = built.clock.now()
    findings(built.bench)
    assert built.clock.now() - before < 0.8 * S


def test_all_baud_rates_of_all_models_are_known_the_common_ones_first() -> None:
    assert Bench(Chatter(b""), TickingClock(), MODELS).bauds() == [
        1_000_000, 57600, 4_500_000, 4_000_000, 3_000_000, 2_000_000, 500_000, 250_000, 128_000, 115_200, 76_800,
        38_400, 9600]


@BRANDS
def test_two_servos_with_one_id_that_answer_one_after_the_other(name: str) -> None:
    built = rig(name, 4, 5, 6)

    def twice(sent: bytes, replies: list[Reply]) -> list[Reply]:
        return [copy for reply in replies for copy in [reply] * (1 + (reply.data[4 if name[0] == "x" else 2] == 5))]

    built.device.tamper = twice
    found = findings(built.bench)
    assert [(type(finding), finding.id) for finding in found] == [(Identity, 4), (Clash, 5), (Identity, 6)]
    assert "two servos have that id" in str(found[1])


@BRANDS
@pytest.mark.parametrize("latency_ms", [0, 16])
def test_two_servos_with_one_id_whose_answers_collide(name: str, latency_ms: int) -> None:
    built = rig(name, 4, 5, 6, adapter=LatencyTimer(latency_ms * MS))

    def collide(sent: bytes, replies: list[Reply]) -> list[Reply]:
        at = 4 if name[0] == "x" else 2
        return [
            Reply(reply.delay_ns, reply.data[:-3] + b"\x13\x37\x00") if reply.data[at] == 5 else reply
            for reply in replies]

    built.device.tamper = collide
    found = findings(built.bench)
    assert [(type(finding), finding.id) for finding in found] == [(Identity, 4), (Clash, 5), (Identity, 6)]


@BRANDS
def test_one_garbled_answer_costs_nobody_his_place(name: str) -> None:
    built = rig(name, 4, 5, 6)
    garbled = []

    def once(sent: bytes, replies: list[Reply]) -> list[Reply]:
        if len(replies) and not garbled:
            garbled.append(sent)
            return [Reply(replies[0].delay_ns, replies[0].data[:-1] + b"\x00"), *replies[1:]]
        return replies

    built.device.tamper = once
    assert [(type(finding), finding.id) for finding in findings(built.bench)] == [
        (Identity, 4), (Identity, 5), (Identity, 6)]


def test_bytes_that_nobody_asked_for_are_told() -> None:
    bench = Bench(Chatter(b"\x55\xaa\x55"), TickingClock(), MODELS)
    assert set(findings(bench)) == {Noise(1_000_000)}


@BRANDS
def test_a_model_that_no_file_describes_is_shown_by_its_number(name: str) -> None:
    built = rig(name, 9)
    built.servos[0].table["model_number"] = 4242
    [identity] = findings(built.bench)
    assert isinstance(identity, Identity)
    assert (identity.id, identity.model, identity.firmware) == (9, None, None)
    assert identity.name == "unknown (model number 4242)"


def test_a_dynamixel_that_answers_pings_only_is_found() -> None:
    built = rig("xl430-w250", 9)
    built.servos[0].write(68, b"\x00")  # status return level
    [identity] = findings(built.bench)
    assert isinstance(identity, Identity)
    assert identity.name == "does not answer reads"

"""A servo is given another id or baud rate: two never share a place, and none gets lost."""

import pytest

from hal.maintenance.address import set_baud, set_id
from robotwalk.errors import BusError, ServoError, UsageError
from sim_backend.device import Reply

from .rig import BAUD_57600, MEGABAUD, Rig, rig

BRANDS = pytest.mark.parametrize("name", ["xl430-w250", "sts3215"])
ID = {"xl430-w250": 7, "sts3215": 5}  # addresses
BAUD = {"xl430-w250": 8, "sts3215": 6}
LOCK = 55


def lose_writes(built: Rig, address: int) -> None:
    """Let writes to an address get lost on their way to the servos."""
    whole = built.device.device.receive

    def receive(sent: bytes, now: int, baud: int) -> list[Reply]:
        to_dynamixel = sent.startswith(b"\xff\xff\xfd") and sent[7:9] == bytes((3, address))
        lost = to_dynamixel or (sent[:3] != b"\xff\xff\xfd" and sent[4:6] == bytes((3, address)))
        return [] if lost else whole(sent, now, baud)

    built.device.device.receive = receive


@BRANDS
def test_a_new_id_is_written_once_and_read_back_there(name: str) -> None:
    built = rig(name, 3, 4)
    servo = built.bench.servo(3)
    change = set_id(servo, 9)
    assert (change.before, change.after, servo.id) == (3, 9, 9)
    assert [fake.id for fake in built.servos] == [9, 4]
    assert built.writes_to(ID[name]) == [b"\x09"]
    with pytest.raises(BusError, match="no servo answers as id 3"):
        built.bench.servo(3)
    built.servos[0].reboot(built.clock.now())
    assert built.servos[0].table["id"] == 9, "it outlives power"


@BRANDS
def test_a_new_baud_rate_is_followed_and_read_back_there(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    change = set_baud(servo, 57_600)
    assert (change.before, change.after) == (MEGABAUD[name], BAUD_57600[name])
    assert built.port.baud == 57_600
    assert built.writes_to(BAUD[name]) == [bytes((BAUD_57600[name],))]
    assert built.bench.servo(3).read("baud_rate") == BAUD_57600[name]
    built.bench.tune(1_000_000)
    with pytest.raises(BusError, match="no servo answers as id 3 at 1000000 baud"):
        built.bench.servo(3)


def test_feetechs_lock_is_open_for_the_change_and_shut_at_the_new_place() -> None:
    built = rig("sts3215", 3)
    set_id(built.bench.servo(3), 9)
    set_baud(built.bench.servo(9), 57_600)
    assert built.writes_to(LOCK) == [b"\x00", b"\x01"] * 2
    assert built.servos[0].table["lock"] == 1


@BRANDS
def test_what_it_has_already_is_not_written(name: str) -> None:
    built = rig(name, 3)
    assert not set_id(built.bench.servo(3), 3).changed
    assert not set_baud(built.bench.servo(3), 1_000_000).changed
    assert built.writes_to(ID[name]) == built.writes_to(BAUD[name]) == []


@BRANDS
def test_an_id_that_is_taken_is_refused(name: str) -> None:
    built = rig(name, 3, 9)
    with pytest.raises(ServoError, match=r"^id 9 is taken: another servo on this line answers to it$"):
        set_id(built.bench.servo(3), 9)
    assert built.writes_to(ID[name]) == []


@BRANDS
def test_an_id_is_taken_though_one_answer_of_its_owner_gets_lost(name: str) -> None:
    built = rig(name, 3, 9)
    servo = built.bench.servo(3)
    lost: list[bytes] = []

    def lose_one(sent: bytes, replies: list[Reply]) -> list[Reply]:
        if not lost and 9 in (sent[2], sent[4]) and 1 in (sent[4], sent[7] if len(sent) > 7 else 0):
            lost.append(sent)
            return []
        return replies

    built.device.tamper = lose_one
    with pytest.raises(ServoError, match=r"^id 9 is taken"):
        set_id(servo, 9)
    assert lost


@BRANDS
def test_a_baud_rate_at_which_the_id_is_taken_is_refused(name: str) -> None:
    built = rig(name, 3, 3)
    built.servos[1].table["baud_rate"] = BAUD_57600[name]
    built.servos[1]._configure_line()
    with pytest.raises(ServoError, match=r"^id 3 at 57600 baud is taken"):
        set_baud(built.bench.servo(3), 57_600)
    assert built.port.baud == 1_000_000
    assert built.writes_to(BAUD[name]) == []


@BRANDS
def test_two_servos_with_the_old_id_are_told_apart_by_what_they_measure(name: str) -> None:
    """Their pings are alike to the bit; where the shafts are is not."""
    built = rig(name, 3)
    servo = built.bench.servo(3)

    def collide(sent: bytes, replies: list[Reply]) -> list[Reply]:
        long = [reply for reply in replies if len(reply.data) > 16 or (len(reply.data) > 9 and name == "sts3215")]
        return [reply._replace(data=reply.data[:-1] + bytes((reply.data[-1] & 0x55,))) for reply in long] or replies

    built.device.tamper = collide
    with pytest.raises(BusError, match=r"id 3 at 1000000 baud is garbled: two servos with one id"):
        set_id(servo, 9)
    assert built.writes_to(ID[name]) == []


@BRANDS
@pytest.mark.parametrize("change", [lambda servo: set_id(servo, 9), lambda servo: set_baud(servo, 57_600)])
def test_torque_must_be_off_and_is_not_switched_off(name: str, change: object) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    servo.write("torque_enable", 1)
    with pytest.raises(ServoError, match=r"torque on: switch it off first, with `robotwalk servo torque-off 3`"):
        change(servo)
    assert built.servos[0].table["torque_enable"] == 1
    assert (built.servos[0].table["id"], built.servos[0].table["baud_rate"]) == (3, MEGABAUD[name])


@BRANDS
def test_what_the_model_does_not_have_never_reaches_the_line(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    built.device.heard.clear()
    with pytest.raises(UsageError, match=r"^id should be 0 to 25"):
        set_id(servo, 255)
    with pytest.raises(UsageError, match=f"^{name} does not have 1234 baud; it has "):
        set_baud(servo, 1234)
    assert built.device.heard == []


@BRANDS
def test_a_change_that_gets_lost_leaves_the_servo_where_it_was_and_locked(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    lose_writes(built, ID[name])
    with pytest.raises(ServoError, match="did not take id = 9: it reads back as 3"):
        set_id(servo, 9)
    assert servo.id == 3
    lose_writes(built, BAUD[name])
    with pytest.raises(ServoError, match="did not take baud_rate = "):
        set_baud(servo, 57_600)
    assert built.port.baud == 1_000_000
    if name == "sts3215":
        assert built.servos[0].table["lock"] == 1
    assert servo.read("id") == 3, "and it can be spoken to"


@BRANDS
def test_a_servo_that_is_slow_to_answer_at_its_new_place_is_found_there(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    deaf: list[bytes] = []

    def sleepy(sent: bytes, replies: list[Reply]) -> list[Reply]:
        moved = built.servos[0].id == 9
        if moved and len(deaf) < 4:
            deaf.append(sent)
            return []
        return replies

    built.device.tamper = sleepy
    assert set_id(servo, 9).after == 9
    assert len(deaf) == 4
    assert servo.id == 9


@BRANDS
def test_a_servo_that_is_gone_is_told_where_it_was_looked_for(name: str) -> None:
    built = rig(name, 3)
    servo = built.bench.servo(3)
    built.device.tamper = lambda sent, replies: [] if built.servos[0].id == 9 else replies
    with pytest.raises(BusError, match=(
            "answers neither as id 9 at 1000000 baud nor as id 3 at 1000000 baud any more; `robotwalk servo scan`")):
        set_id(servo, 9)
    assert servo.id == 3


@BRANDS
def test_the_status_may_come_from_the_new_id(name: str) -> None:
    """Whether a servo answers a new id as the old one or as the new one is not documented."""
    built = rig(name, 3)
    servo = built.bench.servo(3)
    fake = built.servos[0]

    def renamed(sent: bytes, replies: list[Reply]) -> list[Reply]:
        if fake.id == 9 and sent[4 if name == "xl430-w250" else 2] == 3:
            new = {"xl430-w250": bytes.fromhex("FF FF FD 00 09 04 00 55 00 62 8F"),
                   "sts3215": bytes.fromhex("FF FF 09 02 00 F4")}[name]
            return [Reply(0, new)]
        return replies

    built.device.tamper = renamed
    assert set_id(servo, 9).after == 9

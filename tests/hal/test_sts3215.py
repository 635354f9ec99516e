"""The bundled STS3215: its table against Feetech's, what its bus costs, and how a bus of them is started."""

import math
from collections.abc import Sequence
from typing import Any

import pytest

from hal import bus_plan, feetech_protocol
from hal.calibration import Calibration
from hal.goal_writer import GoalWriter
from hal.protocols import protocol_of
from hal.register_map import ServoModel
from hal.servo_bus import SerialServoBus
from hal.servo_line import ServoLine
from hal.wired import Wired
from robotwalk.assembly import load_servo
from robotwalk.errors import BusError
from robotwalk.ports import BytePort

STS = load_servo("sts3215")
STEP = 2.0 * math.pi / 4096  # rad
PERIOD = 10_000_000  # ns


class TestTable:
    @pytest.mark.parametrize(
        ("name", "address", "size", "sign_bit", "unit", "scale"),
        [
            ("big_endian", 2, 1, None, "", 1),
            ("model_number", 3, 2, None, "", 1),
            ("id", 5, 1, None, "", 1),
            ("baud_rate", 6, 1, None, "", 1),
            ("return_delay_time", 7, 1, None, "us", 2),
            ("min_position_limit", 9, 2, None, "step", 1),
            ("max_position_limit", 11, 2, None, "step", 1),
            ("max_torque_limit", 16, 2, None, "%", 0.1),
            ("phase", 18, 1, None, "", 1),
            ("position_p_gain", 21, 1, None, "", 1),
            ("position_d_gain", 22, 1, None, "", 1),
            ("position_i_gain", 23, 1, None, "", 1),
            ("protection_current", 28, 2, None, "mA", 6.5),
            ("position_offset", 31, 2, 11, "step", 1),
            ("operating_mode", 33, 1, None, "", 1),
            ("torque_enable", 40, 1, None, "", 1),
            ("acceleration", 41, 1, None, "step/s^2", 100),
            ("goal_position", 42, 2, 15, "step", 1),
            ("goal_pwm", 44, 2, 10, "%", 0.1),
            ("goal_velocity", 46, 2, 15, "rev/s", 1 / 4096),
            ("torque_limit", 48, 2, None, "%", 0.1),
            ("lock", 55, 1, None, "", 1),
            ("present_position", 56, 2, 15, "step", 1),
            ("present_velocity", 58, 2, 15, "rev/s", 1 / 4096),
            ("present_load", 60, 2, 10, "%", 0.1),
            ("present_input_voltage", 62, 1, None, "V", 0.1),
            ("present_temperature", 63, 1, None, "degC", 1),
            ("hardware_error_status", 65, 1, None, "", 1),
            ("moving", 66, 1, None, "", 1),
            ("present_current", 69, 2, 15, "mA", 6.5),
        ],
    )
    def test_row(self, name: str, address: int, size: int, sign_bit: int | None, unit: str, scale: float) -> None:
        row = STS[name]
        assert (row.address, row.size, row.sign_bit, row.unit, row.scale) == (address, size, sign_bit, unit, scale)
        assert not row.signed, "nothing here is in two's complement"

    def test_baud_rates_by_register_value(self) -> None:
        """From index 5 on, some lists lack 76800 and are off by one."""
        rates = 1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400
        assert STS.baud_by_value == dict(enumerate(rates))

    def test_identity(self) -> None:
        assert STS.model_number == STS["model_number"].default == 777
        assert STS.fast_sync_read_firmware is None
        assert protocol_of(STS) is feetech_protocol
        assert STS.encoder.radians_per_tick == pytest.approx(0.0015339808)

    def test_a_turn_a_second_is_4096_counts_of_velocity(self) -> None:
        assert 4096 * STS["present_velocity"].si_scale == pytest.approx(6.2831853)

    def test_no_default_lies_outside_its_range(self) -> None:
        for row in STS.registers:
            if row.range is not None and row.default is not None:
                assert row.range[0] <= row.default <= row.range[1], row.name


def reading_8_bytes() -> ServoModel:
    """Return the model with a cyclic read from position to temperature, as in the published table of times."""
    content: dict[str, Any] = STS.model_dump(by_alias=True)
    content["cyclic"]["effort"] = "present_temperature"
    model = ServoModel.model_validate(content)
    assert (model.feedback.address, model.feedback.size) == (56, 8)
    return model


class TestWireTime:
    """Bytes x 10 bits / baud: a sync write has 8 + 3 N bytes, a sync read (8 + N) + 14 N."""

    @pytest.mark.parametrize(
        ("servos", "baud", "write_ms", "read_ms"),
        [
            (12, 1_000_000, 0.44, 1.88),
            (18, 1_000_000, 0.62, 2.78),
            (24, 1_000_000, 0.80, 3.68),
            (12, 500_000, 0.88, 3.76),
            (18, 500_000, 1.24, 5.56),
            (24, 500_000, 1.60, 7.36),
        ],
    )
    def test_worked_table(self, servos: int, baud: int, write_ms: float, read_ms: float) -> None:
        plan = bus_plan.cycle(feetech_protocol, wire(reading_8_bytes(), servos), fast=True)
        assert 1e3 * plan.seconds(baud, 100) == pytest.approx(write_ms + read_ms)

    def test_the_plan_of_eighteen(self) -> None:
        plan = bus_plan.cycle(feetech_protocol, wire(STS, 18), fast=True)
        assert plan.always == bus_plan.Exchange(tx_bytes=62 + 26, rx_bytes=216, return_delays=18)

    def test_every_servo_pays_its_return_delay(self) -> None:
        plan = bus_plan.cycle(feetech_protocol, wire(STS, 18), fast=True)
        more = plan.seconds(1_000_000, 100, return_delay=0.5e-3) - plan.seconds(1_000_000, 100)
        assert more == pytest.approx(18 * 0.5e-3)


class Clock:
    """Jumps to the deadline unless somebody has bytes to read."""

    def __init__(self) -> None:
        self.time = 0

    def now(self) -> int:
        return self.time

    def wait(self, ports: Sequence[BytePort], deadline: int) -> None:
        if not any(port.waiting() for port in ports):
            self.time = max(self.time, deadline)


class Servos:
    """A port with servos of bare memory behind it, which answer at once. It keeps what they heard."""

    def __init__(self, *ids: int) -> None:
        self.memory = {servo_id: bytearray(128) for servo_id in ids}
        for memory in self.memory.values():
            memory[3:5] = b"\x09\x03"  # model 777
            memory[8:13] = b"\x01\x00\x00\xff\x0f"  # answers everything; 0 to 4095
            memory[19] = 44
        self.errors = dict.fromkeys(ids, 0)
        self.heard: list[bytes] = []
        self.answers = b""

    def place(self, servo_id: int, position: bytes, velocity: bytes = b"\0\0", load: bytes = b"\0\0") -> None:
        self.memory[servo_id][56:62] = position + velocity + load

    def fileno(self) -> int:
        return -1

    def waiting(self) -> int:
        return len(self.answers)

    def read(self) -> bytes:
        data, self.answers = self.answers, b""
        return data

    def close(self) -> None:
        pass

    def write(self, data: bytes) -> None:
        while data:
            size = 4 + data[3]
            frame, data = data[:size], data[size:]
            self.heard.append(frame)
            self.obey(frame[2], frame[4], frame[5:-1])

    def obey(self, servo_id: int, instruction: int, parameters: bytes) -> None:
        match instruction:
            case 0x01:
                self.answer(servo_id)
            case 0x02:
                self.answer(servo_id, *parameters)
            case 0x03:
                for each in self.memory if servo_id == 254 else [servo_id]:
                    self.store(each, parameters[0], parameters[1:])
                self.answer(servo_id)
            case 0x82:
                for each in parameters[2:]:
                    self.answer(each, *parameters[:2])
            case 0x83:
                step = parameters[1] + 1
                for i in range(2, len(parameters), step):
                    self.store(parameters[i], parameters[0], parameters[i + 1 : i + step])

    def store(self, servo_id: int, address: int, data: bytes) -> None:
        self.memory[servo_id][address : address + len(data)] = data

    def answer(self, servo_id: int, address: int = 0, length: int = 0) -> None:
        if servo_id in self.memory:
            data = self.memory[servo_id][address : address + length]
            body = bytes((servo_id, len(data) + 2, self.errors[servo_id])) + data
            self.answers += b"\xff\xff" + body + bytes((255 - sum(body) % 256,))


def wire(model: ServoModel, count: int) -> list[Wired]:
    return [Wired(f"j{i}", "leg", i, i + 1, model, Calibration(1, 0.0, 2048, STEP), -1.0, 1.0) for i in range(count)]


def bus_of(servos: Servos, *ids: int) -> SerialServoBus:
    """Joints j0, j1 ...; j1 turns the other way round."""
    wired = [
        Wired(f"j{i}", "leg", i, servo_id, STS, Calibration(-1 if i == 1 else 1, 0.0, 2048, STEP), -3.1, 3.1)
        for i, servo_id in enumerate(ids)]
    line = ServoLine("legs", servos, 1_000_000, feetech_protocol, wired)
    return SerialServoBus([f"j{i}" for i in range(len(ids))], [line], Clock())


class TestBus:
    def test_arming_knows_the_model_by_a_read_and_holds_the_present_position_before_torque(self) -> None:
        servos = Servos(3, 4)
        servos.place(3, b"\x64\x08")  # 2148
        servos.place(4, b"\x38\x07")  # 1848
        state = bus_of(servos, 3, 4).arm(PERIOD)
        assert state.position == pytest.approx((100 * STEP, 200 * STEP))
        asked = [frame.hex(" ") for frame in servos.heard]
        assert asked[:2] == ["ff ff 03 02 01 f9", "ff ff 03 04 02 03 02 f1"]  # ping, model number
        second = asked.index("ff ff 04 02 01 f8")
        assert asked[second + 1] == "ff ff 04 04 02 03 02 f0"
        goals = bytes.fromhex("FF FF FE 0A 83 2A 02 03 64 08 04 38 07 96")
        torque_on = bytes.fromhex("FF FF 03 04 03 28 01 CC")
        assert servos.heard.index(goals) < servos.heard.index(torque_on)
        assert [memory[40] for memory in servos.memory.values()] == [1, 1]

    def test_a_tick_is_one_sync_write_and_one_sync_read(self) -> None:
        servos = Servos(3, 4)
        for servo_id in (3, 4):
            servos.place(servo_id, b"\x00\x08")
        bus = bus_of(servos, 3, 4)
        bus.arm(PERIOD)
        servos.heard.clear()
        # A quarter of a turn back at half a turn a second; the load's sign is its bit 10.
        servos.place(3, b"\x00\x04", b"\x00\x88", b"\xfa\x04")
        servos.place(4, b"\x00\x04", b"\x00\x88", b"\xfa\x04")
        state = bus.exchange((0.1, 0.1), PERIOD)
        # round(0.1 rad / 0.00153398 rad) = 65 steps.
        assert [frame.hex(" ") for frame in servos.heard[:2]] == [
            "ff ff fe 0a 83 2a 02 03 41 08 04 bf 07 32", "ff ff fe 06 82 38 06 03 04 34"]
        assert state.position == pytest.approx((-math.pi / 2, math.pi / 2))
        assert state.velocity == pytest.approx((-math.pi, math.pi))
        assert state.effort == pytest.approx((-0.25, 0.25))

    def test_a_goal_below_the_encoders_zero_has_its_sign_in_bit_15(self) -> None:
        frames = GoalWriter(feetech_protocol, wire(STS, 1)).frames([-2148 * STEP])
        assert frames == bytes.fromhex("FF FF FE 07 83 2A 02 01 64 80 66")

    def test_disarming_switches_everybodys_torque_off_by_a_broadcast(self) -> None:
        servos = Servos(3, 4)
        for servo_id in (3, 4):
            servos.place(servo_id, b"\x00\x08")
        bus = bus_of(servos, 3, 4)
        bus.arm(PERIOD)
        bus.disarm()
        assert servos.heard.count(bytes.fromhex("FF FF FE 04 03 28 00 D2")) == 2
        # And each is asked whether it has let go.
        assert [frame.hex(" ") for frame in servos.heard[-2:]] == ["ff ff 03 04 02 28 01 cd", "ff ff 04 04 02 28 01 cc"]
        assert [memory[40] for memory in servos.memory.values()] == [0, 0]

    def test_another_model_is_refused(self) -> None:
        servos = Servos(3)
        servos.memory[3][3:5] = b"\x05\x05"
        with pytest.raises(BusError, match=r"should be a sts3215 \(model 777\); model 1285 answered"):
            bus_of(servos, 3).arm(PERIOD)

    def test_a_servo_in_overload_is_not_armed(self) -> None:
        servos = Servos(3, 4)
        servos.errors[4] = 0x20
        with pytest.raises(BusError, match=r"j1 \(id 4\) on bus legs reports a hardware error"):
            bus_of(servos, 3, 4).arm(PERIOD)
        assert [memory[40] for memory in servos.memory.values()] == [0, 0]

    def test_torque_is_on_is_no_fault(self) -> None:
        """Bit 0x10 of the error byte, as some firmware is said to use it."""
        servos = Servos(3)
        servos.place(3, b"\x00\x08")
        servos.errors[3] = 0x10
        assert bus_of(servos, 3).arm(PERIOD).valid == (True,)

    def test_a_read_that_brings_too_little_is_refused(self) -> None:
        servos = Servos(3)
        servos.memory[3] = servos.memory[3][:4]
        with pytest.raises(BusError, match="does not answer to a read of model_number"):
            bus_of(servos, 3).arm(PERIOD)

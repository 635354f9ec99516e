"""What IMUs send, against literal bytes, and what garbage makes of it."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.imu import uart_rvc, witmotion
from hal.imu.rotation import inverse, to_euler, turned
from hal.unasked_frames import FrameReceiver
from robotwalk.types import UP, Vec3

# BNO080 data sheet 1000-3927, 1.3.5.2: index 222, yaw 0.01, pitch -1.10, roll 20.85 deg; -371, -20, 977 mg.
RVC = bytes.fromhex("AA AA DE 01 00 92 FF 25 08 8D FE EC FF D1 03 00 00 00 E7")
# Made by hand from the formulas of WitMotion's data sheet: 1 g along z; 90 deg/s about x; 45, -22.5 and 90 deg.
WIT = bytes.fromhex(
    "55 51 00 00 00 00 00 08 10 27 E5"
    "55 52 CC 05 00 00 34 FA 10 27 DD"
    "55 53 00 20 00 F0 00 40 00 00 F8")


def degrees(*angles: float) -> tuple[float, ...]:
    return tuple(math.degrees(angle) for angle in angles)


def test_the_data_sheets_own_rvc_frame() -> None:
    (frame,) = FrameReceiver(uart_rvc.FRAMING).take(RVC)
    report = uart_rvc.decode(frame)
    assert report is not None
    assert report.angular_velocity is None
    assert report.acceleration == pytest.approx((-0.371 * 9.80665, -0.020 * 9.80665, 0.977 * 9.80665))
    roll, pitch, yaw = degrees(*to_euler(report.attitude))
    assert (roll, pitch) == pytest.approx((-1.10 / math.cos(math.radians(20.85)), 20.85), abs=0.01)
    assert yaw == pytest.approx(0.0, abs=0.5)


def test_the_data_sheets_example_feels_gravity_where_its_angles_say() -> None:
    """This is what tells that RVC's pitch is about x and its roll about y."""
    report = uart_rvc.decode(RVC)
    assert report is not None
    assert report.acceleration is not None
    up = turned(inverse(report.attitude), UP)
    felt = report.acceleration
    size = math.sqrt(sum(part * part for part in felt))
    assert [part / size for part in felt] == pytest.approx(up, abs=0.01)


@pytest.mark.parametrize(("at", "value"), [(3, 18001), (5, 9001), (7, -18001)])
def test_an_rvc_angle_that_cannot_be_is_no_measurement(at: int, value: int) -> None:
    assert uart_rvc.decode(RVC[:at] + struct.pack("<h", value) + RVC[at + 2:]) is None


def test_a_witmotion_measurement_is_whole_with_its_angles() -> None:
    receiver, decode = FrameReceiver(witmotion.FRAMING), witmotion.Decoder()
    packets = receiver.take(WIT)
    assert [decode(packet) for packet in packets[:2]] == [None, None]
    report = decode(packets[2])
    assert report is not None
    assert degrees(*to_euler(report.attitude)) == pytest.approx((45.0, -22.5, 90.0))
    assert report.acceleration == pytest.approx((0.0, 0.0, 9.80665))
    assert report.angular_velocity is not None
    assert degrees(*report.angular_velocity) == pytest.approx((90.576, 0.0, -90.576), abs=0.01)
    again = decode(packets[2])  # what was said before belongs to the measurement before
    assert again is not None
    assert again.angular_velocity is again.acceleration is None


def test_other_witmotion_packets_are_passed_over() -> None:
    magnetic = bytes.fromhex("55 54 01 00 02 00 03 00 10 27 E6")
    receiver, decode = FrameReceiver(witmotion.FRAMING), witmotion.Decoder()
    reports = [report for packet in receiver.take(magnetic + WIT + magnetic) if (report := decode(packet))]
    assert len(reports) == 1
    assert receiver.stray_bytes == 0


@pytest.mark.parametrize(("framing", "frames"), [(uart_rvc.FRAMING, RVC), (witmotion.FRAMING, WIT)])
@given(data=st.data())
def test_frames_are_found_behind_any_garbage_in_any_pieces(framing, frames, data) -> None:
    garbage = data.draw(st.lists(st.sampled_from([0x55, 0x51, 0xAA, 0x00]) | st.integers(0, 255), max_size=60))
    stream = bytes(garbage) + frames * 3
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=8)))
    receiver = FrameReceiver(framing)
    found = []
    for begin, end in zip([0, *cuts], [*cuts, len(stream)], strict=True):
        found += receiver.take(stream[begin:end])
    size = framing.size
    genuine = [frames[at:at + size] for at in range(0, len(frames), size)]
    # Garbage may complete a frame by chance and eat into the first one; the rest must be there.
    assert found[-2 * len(genuine):] == genuine * 2
    assert receiver.stray_bytes <= len(garbage) + size


@pytest.mark.parametrize(("framing", "frame"), [(uart_rvc.FRAMING, RVC), (witmotion.FRAMING, WIT[-11:])])
@given(data=st.data())
def test_no_single_changed_byte_is_believed(framing, frame, data) -> None:
    at, change = data.draw(st.integers(0, framing.size - 1)), data.draw(st.integers(1, 255))
    spoiled = bytearray(frame)
    spoiled[at] ^= change
    assert bytes(spoiled) not in FrameReceiver(framing).take(bytes(spoiled) + frame)


def summed(head: bytes, body: bytes, since: int) -> bytes:
    return head + body + bytes([sum((head + body)[since:]) % 256])


packets = st.builds(summed, st.sampled_from([b"\x55\x51", b"\x55\x52", b"\x55\x53"]), st.binary(min_size=8, max_size=8),
                    st.just(0))
rvc_frames = st.builds(summed, st.just(b"\xaa\xaa"), st.binary(min_size=16, max_size=16), st.just(2))


@given(st.lists(packets | rvc_frames | st.binary(max_size=20), max_size=12))
def test_whatever_comes_a_report_is_one_that_the_sensor_could_give_and_the_next_one_is_heard(pieces) -> None:
    noise = b"".join(pieces)
    lines = [
        (witmotion.FRAMING, witmotion.Decoder, WIT, 16.0 * 9.80665),
        (uart_rvc.FRAMING, lambda: uart_rvc.decode, RVC, 32.8 * 9.80665)]
    for framing, decoder, good, most in lines:
        decode, size = decoder(), framing.size
        # A frame that noise began swallows the first one behind it at the most.
        taken = FrameReceiver(framing).take(noise + 2 * good)
        reports = [report for frame in taken if (report := decode(frame)) is not None]
        alone = decoder()
        assert reports[-1] == [alone(good[at:at + size]) for at in range(0, len(good), size)][-1]
        for report in reports:
            assert math.hypot(*report.attitude) == pytest.approx(1.0)
            assert math.hypot(*(report.acceleration or (0.0,))) <= math.sqrt(3.0) * most
            assert max(map(abs, report.angular_velocity or (0.0,))) <= math.radians(2000.0)


def test_the_lines_of_a_silent_sensor_cost_no_memory() -> None:
    receiver = FrameReceiver(uart_rvc.FRAMING)
    for _ in range(100):
        assert receiver.take(bytes(1000)) == []
    assert len(receiver._buffer) <= 1
    assert receiver.stray_bytes == 100_000 - len(receiver._buffer)


def test_the_mounting_turns_vectors_and_attitude_alike() -> None:
    from hal.imu.rotation import of_euler, product
    base, mounting = of_euler(0.1, -0.2, 0.7), of_euler(3.0, 0.4, -1.2)
    sensor = product(base, mounting)
    seen = turned(inverse(sensor), Vec3(0.0, 0.0, 9.81))
    assert turned(mounting, seen) == pytest.approx(turned(inverse(base), Vec3(0.0, 0.0, 9.81)))
    assert to_euler(product(sensor, inverse(mounting))) == pytest.approx((0.1, -0.2, 0.7))

"""Which frames a stream holds: found by trying every place, with checksums of our own. Slow, simple and patient."""

from collections.abc import Iterable, Mapping

HEADER = b"\xff\xff\xfd\x00"
Frame = tuple[int, bytes]  # id, and what lies between length and checksum


def _crc_of_byte(byte: int) -> int:
    crc = byte << 8
    for _ in range(8):
        crc = (crc << 1) ^ (0x18005 if crc & 0x8000 else 0)
    return crc


_CRC = [_crc_of_byte(byte) for byte in range(256)]


def crc16(data: bytes) -> int:
    """Return the checksum of Dynamixel Protocol 2.0."""
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFFFF) ^ _CRC[crc >> 8 ^ byte]
    return crc


def dynamixel(servo_id: int, body: bytes) -> bytes:
    """Return a frame of Dynamixel 2.0; the body is not stuffed."""
    head = HEADER + bytes((servo_id,)) + (len(body) + 2).to_bytes(2, "little")
    return head + body + crc16(head + body).to_bytes(2, "little")


def checksummed(servo_id: int, body: bytes) -> bytes:
    """Return a frame of Dynamixel 1.0 or Feetech."""
    summed = bytes((servo_id, len(body) + 1)) + body
    return b"\xff\xff" + summed + bytes((255 - sum(summed) % 256,))


def dynamixel_joint(answers: Iterable[tuple[int, bytes]]) -> bytes:
    """Return the joint reply to a fast read."""
    answers = tuple(answers)
    length = 1 + sum(4 + len(data) for _, data in answers)
    frame = HEADER + b"\xfe" + length.to_bytes(2, "little") + b"\x55"
    for servo_id, data in answers:
        frame += bytes((0, servo_id)) + data
        frame += crc16(frame).to_bytes(2, "little")
    return frame


def places(stream: bytes, header: bytes) -> Iterable[int]:
    """Return where a header lies."""
    at = stream.find(header)
    while at >= 0:
        yield at
        at = stream.find(header, at + 1)


def dynamixel_frames(stream: bytes) -> set[Frame]:
    """Return all whole frames of Dynamixel 2.0, wherever they begin."""
    found = set()
    for at in places(stream, HEADER):
        end = at + 7 + int.from_bytes(stream[at + 5 : at + 7], "little")
        if not at + 10 <= end <= len(stream):
            continue
        if crc16(stream[at : end - 2]) == int.from_bytes(stream[end - 2 : end], "little"):
            found.add((stream[at + 4], stream[at + 7 : end - 2]))
    return found


def checksum_frames(stream: bytes) -> set[Frame]:
    """Return all whole frames of Dynamixel 1.0 or Feetech, wherever they begin."""
    found = set()
    for at in places(stream, b"\xff\xff"):
        if at + 6 > len(stream):
            break
        end = at + 4 + stream[at + 3]
        if at + 6 <= end <= len(stream) and sum(stream[at + 2 : end]) % 256 == 255:
            found.add((stream[at + 2], stream[at + 4 : end - 1]))
    return found


def joint_blocks(stream: bytes, lengths: Mapping[int, int]) -> set[tuple[int, int, bytes]]:
    """Return (id, error byte, data) of each block whose checksum, and that of all before it, is right."""
    length = 1 + sum(4 + size for size in lengths.values())
    head = HEADER + b"\xfe" + length.to_bytes(2, "little") + b"\x55"
    found = set()
    for at in places(stream, head):
        end = at + len(head)
        for servo_id, size in lengths.items():
            error, said, data = stream[end : end + 1], stream[end + 1 : end + 2], stream[end + 2 : end + 2 + size]
            end += size + 4
            if end > len(stream) or said != bytes((servo_id,)):
                break
            if crc16(stream[at : end - 2]) != int.from_bytes(stream[end - 2 : end], "little"):
                break
            found.add((servo_id, error[0], data))
    return found

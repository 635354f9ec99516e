"""An adapter that echoes is found out and its echo dropped; one that does not is left alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.echo import EchoFilter

PING, STATUS = b"\xff\xff\x01\x02\x01\xfb", b"\xff\xff\x01\x02\x00\xfc"


class Line:
    """A port whose far end the test plays."""

    def __init__(self) -> None:
        self.sent: list[bytes] = []
        self.coming = b""

    def fileno(self) -> int:
        return -1

    def write(self, data: bytes) -> None:
        self.sent.append(data)

    def waiting(self) -> int:
        return len(self.coming)

    def read(self) -> bytes:
        data, self.coming = self.coming, b""
        return data

    def close(self) -> None:
        pass


def hear(port: EchoFilter, line: Line, *pieces: bytes) -> bytes:
    heard = b""
    for piece in pieces:
        line.coming += piece
        heard += port.read()
    return heard


def test_without_an_echo_every_byte_passes() -> None:
    line = Line()
    port = EchoFilter(line)
    port.write(PING)
    assert hear(port, line, STATUS) == STATUS
    port.write(STATUS)
    assert hear(port, line, STATUS) == STATUS, "once found out, nothing is dropped any more"


@pytest.mark.parametrize("cuts", [(6,), (1, 3), (2, 7), (5,), (11,)])
def test_an_echo_is_dropped_however_it_is_cut(cuts: tuple[int, ...]) -> None:
    line = Line()
    port = EchoFilter(line)
    for _ in range(3):
        port.write(PING)
        stream = PING + STATUS
        pieces = [stream[a:b] for a, b in zip((0, *cuts), (*cuts, len(stream)), strict=True)]
        assert hear(port, line, *pieces) == STATUS
    assert line.sent == [PING] * 3


def test_a_silent_line_decides_nothing() -> None:
    line = Line()
    port = EchoFilter(line)
    port.write(PING)
    assert hear(port, line, b"", b"") == b""
    port.write(PING)
    assert hear(port, line, PING + PING + STATUS) == STATUS


def test_an_answer_is_not_taken_for_an_echo_that_did_not_come() -> None:
    line = Line()
    port = EchoFilter(line)
    port.write(PING)
    hear(port, line, PING + STATUS)
    port.write(PING)
    assert hear(port, line, STATUS) == STATUS
    port.write(PING)
    assert hear(port, line, PING + STATUS) == STATUS


@given(frames=st.lists(st.binary(min_size=1, max_size=30), min_size=1, max_size=8), data=st.data())
def test_with_an_echo_only_the_answers_remain(frames: list[bytes], data: st.DataObject) -> None:
    line = Line()
    port = EchoFilter(line)
    for frame in frames:
        answer = data.draw(st.binary(max_size=20))
        stream = frame + answer
        cut = data.draw(st.integers(0, len(stream)))
        port.write(frame)
        assert hear(port, line, stream[:cut], stream[cut:]) == answer

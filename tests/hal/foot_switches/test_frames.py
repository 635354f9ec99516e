"""What a board of foot switches sends, against docs/foot-switches.md's literal bytes, and what garbage makes of it."""

from hypothesis import given
from hypothesis import strategies as st

from hal.foot_switches.frame import FRAMING, decode
from hal.unasked_frames import FrameReceiver

FRAME = bytes.fromhex("46 53 15 80 2E")  # inputs 0, 2, 4 and 15
WORDS = st.integers(0, 0xFFFF)


def framed(word: int) -> bytes:
    body = b"FS" + word.to_bytes(2, "little")
    return body + bytes([sum(body) % 256])


def test_the_pages_own_frame() -> None:
    assert [decode(frame) for frame in FrameReceiver(FRAMING).take(FRAME)] == [1 << 0 | 1 << 2 | 1 << 4 | 1 << 15]


@given(words=st.lists(WORDS, min_size=3, max_size=6), garbage=st.binary(max_size=12), data=st.data())
def test_words_come_back_behind_any_garbage(words: list[int], garbage: bytes, data: st.DataObject) -> None:
    stream = garbage + b"".join(map(framed, words))
    cuts = sorted(data.draw(st.lists(st.integers(0, len(stream)), max_size=6)))
    receiver = FrameReceiver(FRAMING)
    found = [
        decode(frame) for begin, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)
        for frame in receiver.take(stream[begin:end])]
    # Garbage may complete a frame by chance and eat into the first one; the rest must be there.
    assert found[-len(words) + 1:] == words[1:]


@given(word=WORDS, at=st.integers(0, 4), change=st.integers(1, 255))
def test_no_single_changed_byte_is_believed(word: int, at: int, change: int) -> None:
    spoiled = bytearray(framed(word))
    spoiled[at] ^= change
    assert bytes(spoiled) not in FrameReceiver(FRAMING).take(bytes(spoiled) + framed(word))

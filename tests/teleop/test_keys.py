"""From the bytes of a terminal to what the robot is to do, with no terminal and no robot."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotwalk.assembly import Blueprint, load
from robotwalk.teleop.hands import Held, Latched
from robotwalk.teleop.keystrokes import Decoder, Event, Sign, Stroke
from robotwalk.teleop.layout import CENTRED, Act, Faster, Lean, Stick, action, help_of
from robotwalk.teleop.tiller import Tiller
from robotwalk.types import STILL

P, R, U = Event.PRESSED, Event.REPEATED, Event.RELEASED
AHEAD, LEFT = Stick(1, 0, 0), Stick(0, 0, 1)

# What xterm, tmux and the Linux console send.
OLD = {
    b"i": [Stroke("i")], b"I": [Stroke("i", shift=True)], b"<": [Stroke(",", shift=True)], b" ": [Stroke("space")],
    b"\r": [Stroke("enter")], b"\x7f": [Stroke("backspace")], b"\x03": [Stroke("c", ctrl=True)],
    b"\x1b[A": [Stroke("up")], b"\x1bOD": [Stroke("left")], b"\x1b[1;2C": [Stroke("right", shift=True)],
    b"\x1b[?64;1;9c": [Sign.ATTRIBUTES], b"\x1b[O": [Sign.FOCUS_LOST], b"\x1b[I": [Sign.OTHER],
    b"\x1b[15~": [Sign.OTHER], b"\xc3\xa4": [Sign.OTHER, Sign.OTHER],
}
# What kitty and foot send with `CSI > 11 u` in force (kitty's documentation gives the form of each).
KITTY = {
    b"\x1b[?11u": [Sign.HAS_KITTY],
    b"\x1b[105u\x1b[105;1:2u\x1b[105;1:3u": [Stroke("i"), Stroke("i", event=R), Stroke("i", event=U)],
    b"\x1b[57441;2u\x1b[105;2u\x1b[105;2:3u\x1b[57441;1:3u": [
        Sign.OTHER, Stroke("i", shift=True), Stroke("i", shift=True, event=U), Sign.OTHER],
    b"\x1b[105:73;2u": [Stroke("i", shift=True)], b"\x1b[105;65u": [Stroke("i")],  # caps lock is no shift
    b"\x1b[99;5u\x1b[27u\x1b[13u\x1b[32u": [Stroke("c", ctrl=True), Stroke("esc"), Stroke("enter"), Stroke("space")],
    b"\x1b[1;1:3A": [Stroke("up", event=U)], b"\x1b[105;1:9u": [Sign.OTHER],
}


@pytest.mark.parametrize(("data", "said"), [*OLD.items(), *KITTY.items()], ids=lambda value: str(value)[:30])
def test_bytes_become_keystrokes_however_they_are_split(data: bytes, said: list[Stroke | Sign]) -> None:
    for cut in range(len(data)):
        decoder = Decoder()
        assert decoder.feed(data[:cut]) + decoder.feed(data[cut:]) == said
        assert not decoder.pending


def test_an_escape_alone_is_the_key_once_nothing_has_followed() -> None:
    decoder = Decoder()
    assert decoder.feed(b"i\x1b") == [Stroke("i")]
    assert decoder.pending
    assert decoder.flush() == [Stroke("esc")]
    assert decoder.feed(b"\x1b[1;") + decoder.flush() == [], "half a sequence is no key"


@settings(max_examples=50)
@given(st.lists(st.binary(max_size=8) | st.sampled_from([b"\x1b", b"\x1b[", b"9" * 80, b";:", b"u"]), max_size=20))
def test_noise_is_survived_and_never_kept(pieces: list[bytes]) -> None:
    decoder = Decoder()
    for piece in pieces:
        decoder.feed(piece)
    decoder.flush()
    assert decoder.feed(b"k")[-1:] == [Stroke("k")]


def test_both_layouts_move_as_their_users_expect() -> None:
    # ros2/teleop_twist_keyboard's moveBindings: x, y, and turn.
    small = [(1, 0, 1), (1, 0, 0), (1, 0, -1), (0, 0, 1), (0, 0, -1), (-1, 0, -1), (-1, 0, 0), (-1, 0, 1)]
    capital = [(1, 1, 0), (1, 0, 0), (1, -1, 0), (0, 1, 0), (0, -1, 0), (-1, 1, 0), (-1, 0, 0), (-1, -1, 0)]
    for shift, sticks in ((False, small), (True, capital)):
        assert [action(Stroke(key, shift), "ros") for key in "uiojlm,."] == sticks
    assert action(Stroke("k"), "ros") is action(Stroke("space"), "ros") is action(Stroke("space"), "wasd") is Act.HALT
    assert action(Stroke("e"), "ros") == Faster(angular=1.1)
    assert [action(Stroke(key), "wasd") for key in "wsadqe"] == [
        (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    assert action(Stroke("w", shift=True), "wasd") == AHEAD, "caps lock is no reason to stand still"
    assert all(len(line) <= 72 for layout in ("ros", "wasd") for line in help_of(layout))


def test_latched_keys_fade_after_0_7_s_without_a_byte() -> None:
    hands = Latched()
    assert hands.stick(0.0) == CENTRED
    hands.heard(10.0)
    hands.press("i", AHEAD, P)
    assert hands.stick(10.7) == AHEAD
    assert hands.stick(10.85).x == pytest.approx(0.5)
    assert hands.stick(11.0) == CENTRED
    hands.heard(12.0)
    assert hands.stick(12.0) == CENTRED, "another key does not bring it back"


def test_held_keys_last_and_add_up_until_they_are_released_or_the_terminal_is_silent() -> None:
    hands = Held()
    hands.heard(1.0)
    hands.press("i", AHEAD, P)
    hands.press("j", LEFT, P)
    assert hands.stick(1.4) == Stick(1, 0, 1)
    hands.press("i", AHEAD, U)
    assert hands.stick(1.4) == LEFT
    assert hands.stick(1.6) == CENTRED
    hands.heard(1.6)
    hands.press("j", LEFT, R)
    assert hands.stick(1.6) == CENTRED, "what was let go is to be pressed anew"


@pytest.fixture(scope="module")
def hexapod() -> Blueprint:
    return load("hexapod")


@pytest.fixture
def tiller(hexapod: Blueprint) -> Tiller:
    return Tiller(hexapod.model.motion, hexapod.model.heights, ("wave", "ripple", "tripod"), "tripod")


def test_a_stick_is_a_share_of_full_speed_in_every_direction(tiller: Tiller) -> None:
    assert tiller.command(AHEAD, 0.0, 0.02).twist == (0.125, 0.0, 0.0)
    aslant = tiller.command(Stick(1, 1, 0), 0.0, 0.02).twist
    assert math.hypot(aslant.vx, aslant.vy) == pytest.approx(0.125)
    tiller.adjust(Faster(1.1, 0.9))
    assert tiller.command(Stick(1, 0, 1), 0.0, 0.02).twist == pytest.approx((0.1375, 0.0, math.radians(27.0)))
    for _ in range(50):
        tiller.adjust(Faster(1.1, 1.1))
    assert tiller.speed == 0.25, "never more than the robot can"


def test_by_heading_the_third_axis_turns_what_is_faced(tiller: Tiller) -> None:
    tiller.adjust(Act.HEADING)
    assert tiller.command(AHEAD, 0.3, 0.02).heading == pytest.approx(0.3), "it holds what it faces"
    assert tiller.command(AHEAD, 0.2, 0.02).heading == pytest.approx(0.3), "and turns back to it"
    heading = tiller.command(LEFT, 0.3, 0.1).heading
    assert heading == pytest.approx(0.3 + 0.1 * math.radians(30.0))
    for _ in range(100):
        heading = tiller.command(LEFT, 0.3, 0.1).heading
    assert heading == pytest.approx(0.3 + math.radians(30.0)), "not far ahead of a body that cannot follow"
    assert tiller.command(CENTRED, 0.3, 0.02)[:2] == (STILL, None)


def test_gait_height_and_posture_stay_within_the_robot(tiller: Tiller) -> None:
    tiller.adjust(Act.NEXT_GAIT)
    assert tiller.command(CENTRED, 0.0, 0.0).gait == "wave"
    for _ in range(20):
        tiller.adjust(Lean(height=1, pitch=-1))
    command = tiller.command(CENTRED, 0.0, 0.0)
    assert command.height == pytest.approx(0.135)
    assert command.posture.pitch == pytest.approx(math.radians(-10.0))
    tiller.adjust(Act.LEVEL)
    assert tiller.command(CENTRED, 0.0, 0.0)[2:4] == (0.109, (0, 0, 0, 0, 0, 0))

"""Who drives, and what programs say: without a robot."""

import json
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robotwalk.errors import ConfigError, UsageError
from robotwalk.teleop import messages
from robotwalk.teleop.ask import Ask, Wish
from robotwalk.teleop.helm import Helm
from robotwalk.teleop.websocket import Address, WebSocketDoor
from robotwalk.types import LEVEL, STILL, Command, Twist

AHEAD = Command(Twist(0.1, 0.0, 0.0), heading=0.2, height=0.12, gait="wave")


def test_the_first_has_the_helm_until_it_leaves_or_is_silent_for_half_a_second() -> None:
    helm = Helm()
    assert helm.hear(Ask("pad", AHEAD), 0.0) is None
    assert helm.hear(Ask("keys", Command()), 0.4) == "pad drives"
    assert helm.hear(Ask("keys", wish=Wish.SIT), 0.4) == "pad drives"
    assert helm.command(0.5) == AHEAD
    stands = AHEAD._replace(twist=STILL, heading=None)
    assert helm.hear(Ask("keys"), 0.6) is None
    assert helm.command(0.6) == stands, "a beat takes the helm, and starts nothing"
    assert helm.hear(Ask("pad", AHEAD), 0.6) == "keys drives"
    assert helm.hear(Ask("keys", wish=Wish.LEAVE), 0.7) is None
    assert helm.hear(Ask("pad", AHEAD), 0.7) is None
    assert helm.command(1.21) == stands, "as high as it was, but still"


def test_anybody_may_stop_and_nobody_drives_then() -> None:
    helm = Helm()
    helm.hear(Ask("pad", AHEAD), 0.0)
    assert helm.hear(Ask("a watcher", wish=Wish.STOP), 0.1) is None
    assert helm.driver(0.1) is None
    assert helm.command(0.1).twist == STILL
    for now in (0.2, 0.6, 1.0):
        assert "stopped while it drove" in (helm.hear(Ask("pad", AHEAD), now) or "")
    assert helm.hear(Ask("a watcher", wish=Wish.CLEAR), 1.1) is None
    assert helm.hear(Ask("a watcher", wish=Wish.LEAVE), 1.2) is None
    assert helm.hear(Ask("pad", AHEAD), 1.6) is None, "it had let go"


def test_a_message_becomes_a_command() -> None:
    text = '{"type": "drive", "vx": 1e-1, "wz": -0.2, "height": 0.12, "posture": {"pitch": 0.1}, "gait": "wave"}'
    assert messages.read(text, "socket 1") == Ask("socket 1", Command(
        Twist(0.1, 0.0, -0.2), None, 0.12, LEVEL._replace(pitch=0.1), "wave"))
    assert messages.read('{"type": "stop"}', "socket 1") == Ask("socket 1", wish=Wish.STOP)
    assert messages.read('{"type": "beat"}', "socket 1") == Ask("socket 1")


@pytest.mark.parametrize(("text", "says"), [
    ('{"type": "drive", "vxx": 1}', "unknown key 'vxx': did you mean 'vx'?"),
    ('{"type": "drive", "vx": "fast"}', "vx: expected a number (got 'fast')"),
    ('{"type": "drive", "vx": NaN}', "vx: expected a finite number"),
    ('{"type": "quit"}', "type: expected one of drive, beat, stand, sit, stop, clear, leave (got \"quit\")"),
    ('{"vx": 1}', "expected one of drive, beat"), ('{"type": "sit", "vx": 1}', "unknown key 'vx'"),
    ("[1]", "(got null)"), ("{", "not valid JSON"), ("[" * 4000, "not valid JSON"),
    ('{"type": "drive", "posture": {"yow": 1}}', "posture: unknown key 'yow': did you mean 'yaw'?"),
])
def test_a_wrong_message_is_answered_in_words(text: str, says: str) -> None:
    with pytest.raises(ConfigError, match="message") as error:
        messages.read(text, "socket 1")
    assert says in str(error.value)


@settings(max_examples=40)
@given(st.recursive(
    st.none() | st.booleans() | st.floats() | st.text(max_size=5) | st.sampled_from(["drive", "stop", "type"]),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(
        st.sampled_from(["type", "vx", "posture", "yaw", "gait", "x"]), inner, max_size=4)))
def test_no_message_breaks_the_door_or_carries_a_nan(content: object) -> None:
    try:
        ask = messages.read(json.dumps(content), "socket 1")
    except ConfigError:
        return
    assert ask.command is None or all(map(math.isfinite, [*ask.command.twist, *ask.command.posture]))


def test_beyond_this_computer_a_token_is_demanded() -> None:
    assert [Address.parse(text).loopback for text in ("localhost:1", "127.0.0.2:1", "[::1]:1", "0.0.0.0:1", "pi:1")] \
        == [True, True, True, False, False]
    with pytest.raises(UsageError, match="ROBOTWALK_TOKEN"):
        WebSocketDoor(Address.parse("0.0.0.0:0"), "hexapod", ())
    for wrong in ("8765", ":1", "host:", "host:99999", "host:x"):
        with pytest.raises(UsageError, match="HOST:PORT"):
            Address.parse(wrong)

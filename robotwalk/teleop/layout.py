"""What the keys do, in two layouts: that of ROS's teleop_twist_keyboard, and WASD."""

from collections.abc import Mapping
from enum import Enum
from typing import Literal, NamedTuple

from robotwalk.teleop.keystrokes import Stroke


class Stick(NamedTuple):
    """Where to, each from -1 to 1, as a stick would show: REP-103, so x ahead, y and w to the left."""

    x: float = 0.0
    y: float = 0.0
    w: float = 0.0


CENTRED = Stick()


class Faster(NamedTuple):
    """Change full speed by factors."""

    linear: float = 1.0
    angular: float = 1.0


class Lean(NamedTuple):
    """Change how the body is carried, in steps."""

    height: int = 0
    roll: int = 0
    pitch: int = 0
    yaw: int = 0


class Act(Enum):
    """What else a key does."""

    HALT = "halt"
    STAND = "stand"
    SIT = "sit"
    STOP = "stop"
    QUIT = "quit"
    NEXT_GAIT = "next gait"
    LAST_GAIT = "last gait"
    HEADING = "heading or turn"
    LEVEL = "level"


Action = Stick | Faster | Lean | Act
LayoutName = Literal["ros", "wasd"]
_Keys = Mapping[tuple[str, bool], Action]  # by the key and whether shift is held

_COMMON: _Keys = {
    ("space", False): Act.HALT, ("esc", False): Act.STOP, ("enter", False): Act.STAND, ("backspace", False): Act.SIT,
    ("g", False): Act.NEXT_GAIT, ("g", True): Act.LAST_GAIT, ("h", False): Act.HEADING, ("0", False): Act.LEVEL,
    ("=", False): Faster(1.1, 1.1), ("=", True): Faster(1.1, 1.1), ("-", False): Faster(0.9, 0.9),
    ("r", False): Lean(height=1), ("f", False): Lean(height=-1),
    ("up", False): Lean(pitch=-1), ("down", False): Lean(pitch=1),
    ("left", False): Lean(roll=-1), ("right", False): Lean(roll=1),
    ("v", False): Lean(yaw=1), ("n", False): Lean(yaw=-1),
}  # fmt: skip

# As in ros2/teleop_twist_keyboard, moveBindings and speedBindings.
_ROS: _Keys = {
    ("i", False): Stick(1, 0, 0), (",", False): Stick(-1, 0, 0),
    ("j", False): Stick(0, 0, 1), ("l", False): Stick(0, 0, -1),
    ("u", False): Stick(1, 0, 1), ("o", False): Stick(1, 0, -1),
    ("m", False): Stick(-1, 0, -1), (".", False): Stick(-1, 0, 1),
    ("i", True): Stick(1, 0, 0), (",", True): Stick(-1, 0, 0),
    ("j", True): Stick(0, 1, 0), ("l", True): Stick(0, -1, 0),
    ("u", True): Stick(1, 1, 0), ("o", True): Stick(1, -1, 0),
    ("m", True): Stick(-1, 1, 0), (".", True): Stick(-1, -1, 0),
    ("k", False): Act.HALT, ("k", True): Act.HALT,
    ("q", False): Faster(1.1, 1.1), ("z", False): Faster(0.9, 0.9),
    ("w", False): Faster(linear=1.1), ("x", False): Faster(linear=0.9),
    ("e", False): Faster(angular=1.1), ("c", False): Faster(angular=0.9),
}  # fmt: skip

_WASD: _Keys = {
    ("w", False): Stick(1, 0, 0), ("s", False): Stick(-1, 0, 0),
    ("a", False): Stick(0, 1, 0), ("d", False): Stick(0, -1, 0),
    ("q", False): Stick(0, 0, 1), ("e", False): Stick(0, 0, -1),
}  # fmt: skip

_LAYOUTS: Mapping[LayoutName, _Keys] = {"ros": {**_COMMON, **_ROS}, "wasd": {**_COMMON, **_WASD}}

_HELP: Mapping[LayoutName, tuple[str, ...]] = {
    "ros": (
        "u i o   go and turn     capitals: sideways   q/z  all speeds",
        "j k l   k, space: halt                       w/x  speed",
        "m , .                                        e/c  turn",
    ),
    "wasd": (
        "q w e   w/s ahead, back   q/e turn           +/-  all speeds",
        "a s d   a/d sideways      space: halt",
        "",
    ),
}
_HELP_FOR_ALL = (
    "g/G gait   h heading or turn   r/f height   arrows, v/n body   0 level",
    "Enter stand   Backspace sit   Esc STOP, Enter clears   ^D sit and end",
)


def help_of(layout: LayoutName) -> tuple[str, ...]:
    """Return what the keys do, in lines of at most 72 columns."""
    return (*_HELP[layout], *_HELP_FOR_ALL)


def action(stroke: Stroke, layout: LayoutName) -> Action | None:
    """Return what a key does when it is pressed."""
    if stroke.ctrl:
        return Act.QUIT if stroke.key == "d" else None
    keys = _LAYOUTS[layout]
    return keys.get((stroke.key, stroke.shift)) or keys.get((stroke.key, False))

"""How often a servo is brought back before it is given up."""

from typing import Any

from robotwalk.config.safety import RecoveryConfig
from robotwalk.recovery import NOBODY, Recovery


class Mended:
    """A treatment that has succeeded."""

    over, failure = True, None


class Bus:
    """Can bring every servo back."""

    def revive(self, slot: int) -> Mended:
        return Mended()


def test_a_servo_is_given_up_when_it_lets_go_too_often_and_old_tries_are_forgotten() -> None:
    bus: Any = Bus()
    recovery = Recovery(("knee",), bus, RecoveryConfig(tries=2, forget_after_s=6.0), rate_hz=10)
    given_up = []
    for tick in range(200):
        treatment = recovery.step({0: "it let go"} if tick in (0, 40, 70, 80) else {}, seated=True)
        if treatment.lost:
            given_up.append(tick)
            assert treatment.lost == {0: "it let go, after 2 tries"}
            break
    # At 70 the one of 0 counts no more; at 80 those of 40 and 70 do.
    assert given_up == [80]
    assert Recovery(("knee",), bus, RecoveryConfig(), 10).step({}, seated=False) == NOBODY

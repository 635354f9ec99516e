"""The schema of a robot's `safety` section: when its watchers act. All of it has defaults."""

from typing import Self

from pydantic import model_validator

from robotwalk.config.section import Positive, Section


class StaleConfig(Section):
    """What is done about a joint that does not answer: it goes on by its goals, then holds, then the robot sits."""

    hold_after_s: Positive = 0.2  # as long as servos with a watchdog of their own go on
    sit_after_s: Positive = 0.5

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.hold_after_s >= self.sit_after_s:
            raise ValueError("hold_after_s should be below sit_after_s")
        return self


class SafetyConfig(Section):
    """All of it."""

    stale: StaleConfig = StaleConfig()

"""The fixture `fake_robot`, for tests of one's own robot. pytest finds it as soon as robotwalk is installed."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from robotwalk.testing import FakeRobot


@pytest.fixture
def fake_robot(request: pytest.FixtureRequest) -> "Callable[..., FakeRobot]":
    """Return what makes a `robotwalk.testing.FakeRobot` of a YAML file beside the test, or of a bundled name."""
    from robotwalk.testing import FakeRobot  # MuJoCo takes its time: only for tests that need it

    def make(robot: str | Path, **options: Any) -> FakeRobot:
        beside = request.path.parent / robot
        return FakeRobot(beside if beside.is_file() else robot, **options)

    return make

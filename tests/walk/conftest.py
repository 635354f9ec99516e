"""What tests of this folder may ask for."""

from collections.abc import Iterator
from typing import Any

import pytest

from robotwalk import assembly

from .joint_watch import JointWatch


@pytest.fixture
def watched_joints(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """See to it that no joint of any robot that the test simulates is ever beyond its limits."""
    simulate, watches = assembly.simulate, list[JointWatch]()

    def watched(*args: Any, **keys: Any) -> assembly.Simulation:
        simulation = simulate(*args, **keys)
        watches.append(JointWatch(simulation))
        return simulation

    monkeypatch.setattr(assembly, "simulate", watched)
    yield
    assert watches
    for watch in watches:
        assert watch.beyond == watch.past_stops == {}

"""A servo that is dead, or a joint that is stuck: six legs walk on as five, the sixth folded."""

import math
from itertools import groupby

import pytest

from robotwalk import assembly
from robotwalk.chain import chain_points
from robotwalk.folded import posture
from robotwalk.loop import Tick

from .bystander import Bystander

AT = 5.0  # s


@pytest.mark.parametrize(("fault", "joint", "tilt_deg"), [
    ("dead_servo", "lf_tibia", 7.0),  # a corner, where balance is hardest
    ("stuck_joint", "lm_tibia", 18.0),  # its leg stands in the way when the body is lowered
])
def test_a_hexapod_walks_on_with_five_legs(fault: str, joint: str, tilt_deg: float) -> None:
    simulation = assembly.simulate("hexapod", faults=[{"at": AT, "fault": fault, "joint": joint}])
    bystander = Bystander(simulation)
    ticks: list[Tick] = []
    places: list[float] = []
    with simulation.robot as walker:
        walker.stand()
        walker.observers.extend([ticks.append, lambda tick: places.append(simulation.world.truth().base.x)])
        walker.walk(vx=0.10, seconds=17.0, gait="tripod")
        yaw = simulation.world.truth().base.yaw
        assert simulation.world.truth().base.z > 0.09
    assert [state for state, _ in groupby(tick.state.value for tick in ticks)][:4] == ["walk", "mend", "stand", "walk"]
    assert [event.text for event in walker.events if event.kind == "legs"] == [f"going on without {joint[:2]}"]
    down = next(tick.time * 1e-9 for tick in ticks if tick.state.value == "mend")
    assert down - AT < (1.0 if fault == "dead_servo" else 3.0)
    # Steadily on: at least 3 cm/s in its last 4 s, the centre of mass between the feet that stand.
    last = [(tick, x) for tick, x in zip(ticks, places, strict=True) if tick.state.value == "walk"][-400:]
    assert last[-1][1] - last[0][1] > 0.12
    assert min(tick.stability.margin or -1.0 for tick, _ in last) > 0.005
    assert all(len(tick.wanted.planted) == 5 and sum(tick.wanted.planted) >= 4 for tick, _ in last)
    assert math.degrees(abs(yaw)) < 20.0
    assert bystander.largest_tilt() < tilt_deg
    assert bystander.fastest_drop() < 0.25
    assert bystander.sees_it_down()
    assert bystander.joints.beyond == bystander.joints.past_stops == {}


def test_a_healthy_joint_that_lags_is_not_taken_for_stuck() -> None:
    """In a fast stroll the femurs' goals lead by a radian, for less time than a joint needs to follow."""
    with assembly.simulate("hexapod").robot as walker:
        walker.stand()
        walker.walk(vx=-0.24, seconds=3.5, gait="stroll")
        walker.walk(vx=0.24, seconds=3.0, gait="stroll")
    assert [event for event in walker.events if event.kind in ("mend", "legs")] == []


@pytest.mark.parametrize("dead", ["coxa", "femur", "tibia"])
def test_a_folded_leg_clears_the_ground_wherever_its_dead_joint_hangs(dead: str) -> None:
    model = assembly.load("hexapod").model
    leg = model.legs[0]
    index = [joint.name for joint in leg.joints].index(f"lf_{dead}")
    angles = posture(leg, {index})
    for joint, angle in zip(leg.joints, angles, strict=True):
        assert joint.lower < angle < joint.upper
    low, high = leg.joints[index].lower, leg.joints[index].upper
    for step in range(21):
        angles[index] = low + (high - low) * step / 20
        lowest = min(point.z for point in chain_points(leg, angles)[1:]) - model.foot_radius
        assert lowest > -model.heights.stand + 0.02

"""Behaviours steer a body that does just what it is told."""

import math

import pytest

from robotwalk.behaviours import Arrive, Behaviour, Facing, FollowPath, KeepHeading, Seek, Wander
from robotwalk.body import advanced
from robotwalk.estimator import Estimate
from robotwalk.types import LEVEL, Command, Pose, Twist

DT = 0.01
EIGHT = [(0.5, 0.0), (0.5, 0.5), (0.25, 0.5), (0.25, -0.5), (0.0, -0.5), (0.0, 0.0)]  # crosses its own first piece


def steered(
    behaviour: Behaviour, start: Pose = LEVEL, seconds: float = 60.0, push: tuple[float, float] | None = None
) -> list[tuple[Pose, Command]]:
    """Return where the body was in each tick, and what it was told, until the behaviour is done; pushed after 2 s."""
    pose, run = start, []
    for tick in range(round(seconds / DT)):
        if push is not None and tick == 200:
            pose = pose._replace(x=pose.x + push[0], y=pose.y + push[1])
        command = behaviour.step(Estimate(pose, 6), DT)
        run.append((pose, command))
        if behaviour.done:
            break
        turn = command.twist.wz if command.heading is None else 2.0 * (command.heading - pose.yaw)
        pose = advanced(pose, command.twist._replace(wz=turn), DT)
    return run


@pytest.mark.parametrize("facing", ["kept", "ahead", 1.0])
@pytest.mark.parametrize("start", [LEVEL, Pose(-0.3, 0.7, 0.1, 0.0, 0.0, 2.5), Pose(1.0, 1.0, 0.1, 0.0, 0.0, -8.0)])
def test_arriving_ends_slowly_at_the_goal(start: Pose, facing: Facing) -> None:
    run = steered(Arrive(0.8, -0.4, speed=0.1, facing=facing), start)
    pose, command = run[-1]
    assert math.hypot(pose.x - 0.8, pose.y + 0.4) <= 0.01
    assert math.hypot(*command.twist[:2]) <= 0.0101
    assert max(math.hypot(*command.twist[:2]) for _, command in run) == pytest.approx(0.1)
    way = math.atan2(-0.4 - start.y, 0.8 - start.x)
    wanted = {"kept": start.yaw, "ahead": start.yaw + math.remainder(way - start.yaw, math.tau)}.get(facing, facing)
    assert pose.yaw == pytest.approx(wanted, abs=0.02)


def test_seeking_gets_there_at_full_speed_and_ends_even_if_it_passes_by() -> None:
    run = steered(Seek(0.5, 0.2, speed=0.1))
    assert math.hypot(*run[-1][1].twist[:2]) == pytest.approx(0.1)
    assert math.dist(run[-1][0][:2], (0.5, 0.2)) <= 0.01
    run = steered(Seek(0.3, 0.0, speed=0.1), push=(0.2, 0.05))
    assert len(run) == 201
    run = steered(Seek(0.5, 0.0, speed=0.1), push=(0.6, 0.1))  # far off its way it comes back
    assert math.dist(run[-1][0][:2], (0.5, 0.0)) <= 0.01


@pytest.mark.parametrize("facing", ["kept", "ahead"])
def test_a_path_is_followed_all_along_though_it_crosses_itself(facing: Facing) -> None:
    run = steered(FollowPath(EIGHT, speed=0.1, facing=facing))
    for waypoint in EIGHT:
        assert min(math.dist(pose[:2], waypoint) for pose, _ in run) < 0.04
    length = sum(math.dist(a, b) for a, b in zip([(0.0, 0.0), *EIGHT], EIGHT, strict=False))
    assert len(run) * DT == pytest.approx(length / 0.1, rel=0.15)
    assert run[-1][0].yaw == pytest.approx(0.0 if facing == "kept" else math.pi / 2, abs=0.1)


def test_a_body_pushed_off_its_path_comes_back_to_it() -> None:
    run = steered(FollowPath([(1.0, 0.0)], speed=0.1), push=(0.0, 0.1))
    assert max(abs(pose.y) for pose, _ in run) == pytest.approx(0.1)
    assert abs(run[500][0].y) < 0.01
    assert math.dist(run[-1][0][:2], (1.0, 0.0)) <= 0.01


def test_a_direction_is_kept_whatever_turns_the_body() -> None:
    behaviour = KeepHeading(math.pi / 3, speed=0.1, facing="kept")
    twists = [behaviour.step(Estimate(LEVEL._replace(yaw=yaw), 6), DT).twist for yaw in (0.0, math.pi / 3, -1.0)]
    assert twists[1] == pytest.approx(Twist(0.1, 0.0, 0.0))
    assert math.atan2(twists[2].vy, twists[2].vx) == pytest.approx(math.pi / 3 + 1.0)
    ahead = steered(KeepHeading(3.0, speed=0.1), seconds=5.0)[-1]
    assert ahead[0].yaw == pytest.approx(3.0, abs=0.01)


def test_wandering_repeats_by_its_seed_and_stays_near_home() -> None:
    def wandered(seed: int) -> list[tuple[Pose, Command]]:
        return steered(Wander(speed=0.1, turn=0.5, within=0.6, seed=seed), seconds=120.0)

    run = wandered(1)
    assert run == wandered(1)
    assert run[-1] != wandered(2)[-1]
    farthest = max(math.hypot(*pose[:2]) for pose, _ in run)
    assert 0.5 < farthest < 0.6 + 2.0 * 0.1 / 0.5 + 0.01  # the half circle that it turns back on
    turns = [command.twist.wz for _, command in run]
    assert max(turns) > 0.2
    assert min(turns) < -0.2
    assert max(map(abs, turns)) <= 0.5

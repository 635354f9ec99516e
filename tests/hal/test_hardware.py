"""What the schema alone cannot see in a robot's hardware section."""

import pytest

from hal.drive import response
from hal.hardware import BusConfig, HardwareConfig, problems
from robotwalk.assembly import load_servo

JOINTS = {"a": (-90.0, 90.0), "b": (-45.0, 45.0)}
SERVOS = {"xl430-w250": load_servo("xl430-w250")}


def section(**changes: object) -> HardwareConfig:
    joints = {
        "a": {"bus": "legs", "id": 1, "servo": "xl430-w250", "direction": 1, "zero_deg": 0},
        "b": {"bus": "legs", "id": 2, "servo": "xl430-w250", "direction": -1, "zero_deg": 0},
    }
    for key, value in changes.items():
        joint, field = key.split("_", 1)
        joints[joint][field] = value
    buses = {name: {"port": f"/dev/{name}", "baud": 1_000_000} for name in ("legs", "tail")}
    return HardwareConfig.model_validate({"buses": buses, "joints": joints})


def found(config: HardwareConfig) -> list[tuple[tuple[str, ...], str]]:
    return [(problem.path, problem.what) for problem in problems(config, JOINTS, SERVOS)]


def test_a_sound_section_has_no_problem() -> None:
    assert found(section()) == []


def test_one_id_on_two_buses_is_no_problem_and_on_one_bus_is() -> None:
    assert found(section(b_id=1, b_bus="tail")) == []
    assert found(section(b_id=1)) == [(("joints", "b", "id"), "already the id of a on bus 'legs'")]


@pytest.mark.parametrize(("change", "path", "what"), [
    ({"a_bus": "arms"}, ("joints", "a", "bus"), "no such bus; there are legs, tail"),
    ({"a_servo": "sg90"}, ("joints", "a", "servo"), "no such servo; there are xl430-w250"),
    ({"a_zero_deg": 95.0}, ("joints", "a", "zero_deg"), "leave the servo's range"),
    ({"b_zero_deg": -140.0}, ("joints", "b", "zero_deg"), "leave the servo's range"),
])
def test_each_problem_is_found_where_it_is(change: dict[str, object], path: tuple[str, ...], what: str) -> None:
    (problem,) = found(section(**change))
    assert problem[0] == path
    assert what in problem[1]


def test_a_baud_that_the_servos_do_not_have_is_told_at_the_bus() -> None:
    config = section()
    odd = config.model_copy(update={"buses": {**config.buses, "legs": BusConfig(port="x", baud=250_000)}})
    path, what = found(odd)[0]
    assert path == ("buses", "legs", "baud")
    assert what.startswith("servo xl430-w250 of a has only 9600, 57600,")


def test_joints_and_servos_must_match() -> None:
    config = section()
    assert [p.what for p in problems(config, {**JOINTS, "c": (0.0, 1.0)}, SERVOS)] == ["joint 'c' has no servo"]
    assert [p.path for p in problems(config, {"a": (0.0, 1.0)}, SERVOS)] == [("joints", "b")]


def test_the_response_of_an_xl430_is_the_one_worked_out_by_hand() -> None:
    # k = 1.7462 / 13.46 x 11.1 V x 3.68 duty/rad = 5.30 N m/rad; (0.2265 + 0.008) / k; 0.010 / k; 0.04 / k.
    drive = response(load_servo("xl430-w250"))
    assert drive.damping == pytest.approx(0.0442, abs=0.0003)
    assert drive.inertia == pytest.approx(0.001886, abs=0.00002)
    assert drive.friction == pytest.approx(0.00754, abs=0.00005)
    assert drive.max_speed == pytest.approx(5.969, abs=0.001)

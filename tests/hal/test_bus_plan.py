"""Wire time, against the figures of the reference's section 5.2."""

import math

import pytest

from hal import bus_plan, dynamixel1_protocol, dynamixel_protocol
from hal.calibration import Calibration
from hal.protocol import ServoProtocol
from hal.protocols import protocol_of
from hal.register_map import ServoModel
from hal.wired import Wired
from robotwalk.assembly import load_servo

XL430, AX, STS, XM430 = map(load_servo, ("xl430-w250", "ax-12a", "sts3215", "xm430-w350"))


def wire(*models: ServoModel) -> list[Wired]:
    return [
        Wired(f"j{i}", "leg", i, i + 1, model, Calibration(1, 0.1, model.encoder.centre, 0.01), -1.0, 1.0)
        for i, model in enumerate(models)]


def cycle(*models: ServoModel, fast: bool = True, protocol: ServoProtocol = dynamixel_protocol) -> bus_plan.Cycle:
    return bus_plan.cycle(protocol, wire(*models), fast=fast)


@pytest.mark.parametrize(("servos", "baud", "fast", "write_ms", "read_ms"), [
    (12, 1_000_000, False, 0.74, 2.78), (12, 1_000_000, True, 0.74, 2.02),
    (18, 1_000_000, False, 1.04, 4.10), (18, 1_000_000, True, 1.04, 2.92),
    (18, 4_000_000, True, 0.26, 0.73),
])
def test_dynamixel_wire_time_is_that_of_the_reference(
    servos: int, baud: int, fast: bool, write_ms: float, read_ms: float
) -> None:
    plan = cycle(*[XL430] * servos, fast=fast)
    assert 1e3 * plan.seconds(baud, 100) == pytest.approx(write_ms + read_ms, abs=0.011)


def test_eighteen_xl430_take_one_joint_reply() -> None:
    assert cycle(*[XL430] * 18).always == bus_plan.Exchange(tx_bytes=104 + 32, rx_bytes=260, return_delays=1)


def test_in_a_fast_read_the_return_delay_passes_once_and_else_for_each() -> None:
    for fast, delays in ((True, 1), (False, 18)):
        plan = cycle(*[XL430] * 18, fast=fast)
        more = plan.seconds(1_000_000, 100, return_delay=0.5e-3) - plan.seconds(1_000_000, 100)
        assert more == pytest.approx(delays * 0.5e-3)


def test_models_whose_registers_lie_alike_share_their_frames() -> None:
    assert cycle(XL430, XM430, XL430).always == cycle(*[XL430] * 3).always


def test_an_adapters_latency_passes_with_every_round_trip() -> None:
    plan = cycle(*[XL430] * 18)
    assert plan.seconds(1_000_000, 100, latency=1e-3) == pytest.approx(plan.seconds(1_000_000, 100) + 1e-3)


class TestServosThatAreReadOneByOne:
    PLAN = cycle(*[AX] * 18, protocol=dynamixel1_protocol)

    def test_a_tick_holds_all_goals_and_as_many_reads_as_it_must(self) -> None:
        # 8 bytes and 3 a servo; 8 bytes of request and 12 of answer. Every joint is read within 50 ms.
        assert self.PLAN.always == bus_plan.Exchange(62, 0, 0, 0)
        assert self.PLAN.spread == (bus_plan.Exchange(8, 12, 1),) * 18
        assert self.PLAN.seconds(1_000_000, 100) == pytest.approx(0.62e-3 + 4 * 0.2e-3), "4 of 18 in each of 5 ticks"
        assert self.PLAN.seconds(1_000_000, 10) == pytest.approx(0.62e-3 + 18 * 0.2e-3)

    def test_its_whole_is_everybody_once(self) -> None:
        assert self.PLAN.whole == bus_plan.Exchange(62 + 18 * 8, 18 * 12, 18, 18)

    @pytest.mark.parametrize(("latency", "largest"), [(0.0, 975), (1e-3, 439), (16e-3, 2)])
    def test_the_largest_rate_leaves_time_for_all_within_50_ms(self, latency: float, largest: int) -> None:
        rate = self.PLAN.largest_rate(1_000_000, 0.8, latency=latency)
        assert rate == largest
        assert self.PLAN.seconds(1_000_000, rate, latency=latency) * rate <= 0.8
        assert self.PLAN.seconds(1_000_000, rate + 1, latency=latency) * (rate + 1) > 0.8


def test_mixed_registers_take_one_bulk_read_where_the_protocol_has_it() -> None:
    xl330 = load_servo("xl330-m288")
    moved = xl330.model_copy(update={"cyclic": xl330.cyclic.model_copy(update={"effort": "present_pwm"})})
    plan = cycle(XL430, moved)
    assert moved.feedback.address != XL430.feedback.address
    assert plan.always.round_trips == 1
    assert plan.spread == ()


@pytest.mark.parametrize("rate", [50, 100, 200])
def test_a_cycle_is_never_planned_shorter_than_its_bytes(rate: int) -> None:
    for model in (XL430, AX, STS):
        protocol = protocol_of(model)
        plan = cycle(*[model] * 6, protocol=protocol)
        assert plan.seconds(1_000_000, rate) >= plan.always.seconds(1_000_000)
        assert math.isfinite(plan.largest_rate(1_000_000, 0.8))

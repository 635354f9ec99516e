"""The feedback of many servos, decoded at once, against each register decoded alone."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hal.calibration import Calibration
from hal.encoding import unpack
from hal.register_map import ServoModel
from hal.samples import samples_decoder
from hal.whole_reply import Outline
from hal.wired import Wired
from robotwalk.assembly import load_servo

MODELS = [load_servo(name) for name in ("xl430-w250", "ax-12a", "sts3215", "scs15")]


@given(st.sampled_from(MODELS), st.lists(st.binary(min_size=10, max_size=10), min_size=1, max_size=4))
def test_many_are_decoded_as_each_alone(model: ServoModel, blocks: list[bytes]) -> None:
    size = model.feedback.size
    servos = [
        Wired(f"j{i}", "leg", 7 - i, i + 1, model,
              Calibration(-1 if i % 2 else 1, 0.1 * i, model.encoder.centre, model.encoder.radians_per_tick), -1.0, 1.0)
        for i in range(len(blocks))]
    decode = samples_decoder(servos, Outline(3, 2, 1))
    assert decode is not None
    found = dict(decode(b"abc" + b"".join(b"xy" + block[:size] + b"z" for block in blocks)))
    assert list(found) == [servo.slot for servo in servos]
    for servo, block in zip(servos, blocks, strict=True):
        counts = {
            register.name: unpack(register, block[register.address - model.feedback.address :][: register.size])
            for register in model.feedback.registers}
        cyclic, calibration = model.cyclic, servo.calibration
        assert found[servo.slot] == (
            calibration.angle(counts[cyclic.position]),
            pytest.approx(calibration.speed(counts[cyclic.velocity], model[cyclic.velocity].si_scale)),
            pytest.approx(calibration.direction * counts[cyclic.effort] / cyclic.effort_full_scale))


def test_servos_whose_registers_lie_otherwise_are_not_decoded_at_once() -> None:
    xl330, xl430 = load_servo("xl330-m288"), MODELS[0]
    moved = xl330.model_copy(update={"cyclic": xl330.cyclic.model_copy(update={"effort": "present_pwm"})})
    servos = [
        Wired("j", "leg", i, i + 1, model, Calibration(1, 0.0, 2048, 0.01), -1.0, 1.0)
        for i, model in enumerate((xl430, moved))]
    assert samples_decoder(servos, Outline(0, 0, 0)) is None

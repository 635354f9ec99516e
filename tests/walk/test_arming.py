"""What a start leaves in servos' memories, looked at when they have lost power since."""

from robotwalk import assembly
from sim_backend.sts_firmware import StsServo


def test_a_feetech_keeps_what_arming_mends_and_is_locked_again() -> None:
    """Its lock must be open for that: what is written while it is closed acts until power goes, and no longer."""
    simulation = assembly.simulate("quadruped")
    servo = simulation.world.servos[4]
    assert isinstance(servo, StsServo)
    servo.write(7, b"\x7d")  # a return delay of 250 us, lock open: as the factory may have set it
    simulation.bus.arm(10_000_000)
    assert simulation.bus.disarm() == []
    assert servo.table["return_delay_time"] == 0
    assert servo.table["lock"] == 1
    servo.reboot(simulation.clock.now())
    assert servo.table["return_delay_time"] == 0
    assert [note for note in simulation.bus.notes if "return_delay" in note] == [
        "return_delay_time set to 0; it was 250 us: " + note_name(simulation, 4)]


def note_name(simulation: assembly.Simulation, slot: int) -> str:
    joint = simulation.blueprint.model.joint_names[slot]
    return f"{joint} (id {simulation.blueprint.hardware.joints[joint].id})"


def test_a_start_writes_no_eeprom_that_holds_it_already() -> None:
    """Its cells wear out."""
    simulation = assembly.simulate("quadruped")
    port = simulation.world.ports["legs"]
    sent: list[bytes] = []
    write = port.write

    def listen(data: bytes) -> None:
        sent.append(data)
        write(data)

    port.write = listen  # type: ignore[method-assign]
    for _ in range(2):
        simulation.bus.arm(10_000_000)
        simulation.bus.disarm()
    to_eeprom = [data for data in sent if data[4] in (0x03, 0x83) and data[5] < 40]
    assert to_eeprom == []

"""`robotwalk servo torque-off` and `reboot`."""

from robotwalk.cli.options import Json
from robotwalk.cli.output import complain, say, write_json
from robotwalk.cli.servo.options import Line, ServoId


def torque_off(*servo_ids: ServoId, line: Line, json: Json = False) -> None:
    """Let go of the shafts, and check that it is so. What these servos hold up will fall.

    Parameters
    ----------
    servo_ids
        Default: all servos on the line, at once.
    """
    with line.writing() as bench:
        servos = bench.torque_off(servo_ids)
    if json:
        write_json({"servos": [servo.id for servo in servos], "torque": False})
    else:
        say(f"torque is off: id {', '.join(str(servo.id) for servo in servos)}")


def reboot(servo_id: ServoId, /, *, line: Line, json: Json = False) -> None:
    """Restart one servo: its torque goes off, RAM goes back to defaults, latched hardware errors are cleared.

    """
    with line.writing() as bench:
        servo = bench.servo(servo_id)
        seconds = bench.reboot(servo)
        faults = servo.faults()
    if json:
        write_json({"id": servo.id, "model": servo.model.name, "seconds": round(seconds, 3), "hardware_errors": faults})
    else:
        say(f"{servo} answers again, after {seconds:.1f} s; its torque is off")
    if faults:
        complain(f"{servo} still reports a hardware error: {', '.join(faults)}")

"""The process of a loop, `python -m robotwalk.assembly.loop_process`; `robotwalk.assembly.connected` starts it.

One thread, which does nothing but this loop: no file is written, nothing logged, no garbage collected.
"""

import os
import sys

from hal.serial_transport import inherited_port
from robotwalk.assembly.blueprint import Files, build
from robotwalk.assembly.real_time import enter_real_time
from robotwalk.assembly.session import engine_of
from robotwalk.assembly.stop_reader import watch_of
from robotwalk.process.log_feed import LogFeed
from robotwalk.process.mailbox import unpacked
from robotwalk.process.messages import Brief
from robotwalk.process.pulse import PulsingClock
from robotwalk.process.servant import Servant
from robotwalk.process.shared import Mailbox
from robotwalk.realtime import end_with, name_process, processors_awake
from robotwalk.timing import Histogram


def main() -> None:
    """Run the loop that the parent asks for on stdin, until it is told to end."""
    name_process("robotwalk-loop")
    brief: Brief = unpacked(sys.stdin.buffer.read())
    end_with(brief.parent)
    os.dup2(os.open(os.devnull, os.O_RDONLY), sys.stdin.fileno())
    mailbox = Mailbox(brief.mailbox)
    blueprint = build(Files.parse(brief.files))
    if brief.hung:
        blueprint = blueprint.hang()
    sensors = blueprint.hardware.sensors
    ports = {
        name: inherited_port(url, blueprint.lines[name], descriptor, echoes=name not in sensors)
        for name, (url, descriptor) in brief.lines.items()}
    clock = PulsingClock(mailbox)
    wake, exchange, compute = map(Histogram, mailbox.histograms)
    engine = engine_of(
        blueprint, clock, ports, brief.rate_hz, LogFeed(mailbox.log) if brief.recorded else None,
        (wake, exchange, compute))
    heard = {"imu": engine.imu, "feet": engine.switches}
    with processors_awake() as awake:
        missing = enter_real_time(awake)
        Servant(
            engine.loop, engine.bus, {line: sensor for line, sensor in heard.items() if sensor is not None},
            clock, mailbox, brief.doorbell, missing, blueprint.model.safety.driver.sit_after_s,
            watch_of(blueprint.hardware.stop_input if brief.stop_input else None, mailbox)).serve()


if __name__ == "__main__":
    main()

"""The same exchange through the vendors' SDKs, as their examples do it: what ours is measured beside."""

import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import dynamixel_sdk
import scservo_sdk

from hal.encoding import pack
from hal.register_map import Block
from hal.wired import Wired
from robotwalk.errors import BusError

_LATE = 0.05  # s after which nothing is under way any more
_SDKS = {"dynamixel-2.0": (dynamixel_sdk, 2.0), "dynamixel-1.0": (dynamixel_sdk, 1.0), "feetech-sts": (scservo_sdk, 0)}
_LITTLE_ENDIAN = 0

Exchange = Callable[[], bool]  # whether all answered


def vendor_of(servos: Sequence[Wired]) -> str | None:
    """Return the name of the SDK that knows all these servos, if one does."""
    modules = {_SDKS.get(servo.model.protocol, (None, 0))[0] for servo in servos}
    module = modules.pop()
    return module.__name__.replace("_", "-") if module is not None and not modules else None


class VendorLines:
    """The servos of some buses, each bus opened by its vendor's SDK."""

    def __init__(
        self, urls: Mapping[str, str], bauds: Mapping[str, int], wiring: Mapping[str, Sequence[Wired]]
    ) -> None:
        """Open the ports. Raises BusError if the SDK cannot."""
        self._ports: list[Any] = []
        self._steps: list[Exchange] = []
        for bus, url in urls.items():
            sdk, version = _SDKS[wiring[bus][0].model.protocol]
            port = sdk.PortHandler(url)
            self._ports.append(port)
            if not port.openPort() or not port.setBaudRate(bauds[bus]):
                raise BusError(f"{sdk.__name__} does not open {url} at {bauds[bus]} baud")
            self._steps += _steps(sdk, port, sdk.PacketHandler(version or _LITTLE_ENDIAN), wiring[bus])

    def exchange(self) -> bool:
        """Write all goals and read all feedback, one bus after the other, as these SDKs must; tell if all answered."""
        good = sum(step() for step in self._steps) == len(self._steps)
        if not good:
            # Neither SDK throws away answers that come too late: they would pass for the next ones'. And scservo_sdk
            # never gives a port back on which an answer was garbled.
            time.sleep(_LATE)
            for port in self._ports:
                port.ser.reset_input_buffer()
                port.is_using = False
        return good

    def close(self) -> None:
        """Give the ports back."""
        for port in self._ports:
            port.closePort()


def _steps(sdk: Any, port: Any, handler: Any, servos: Sequence[Wired]) -> list[Exchange]:
    model = servos[0].model
    goal, feedback = model[model.cyclic.goal], model.feedback
    writer = sdk.GroupSyncWrite(port, handler, goal.address, goal.size)
    goals = {servo.id: list(pack(goal, servo.model.encoder.centre)) for servo in servos}

    def write() -> bool:
        writer.clearParam()
        for servo_id, data in goals.items():
            writer.addParam(servo_id, data)
        return bool(writer.txPacket() == sdk.COMM_SUCCESS)

    if not model.sync_read:
        return [write, *(partial(_read_one, sdk, port, handler, servo.id, feedback) for servo in servos)]
    reader = sdk.GroupSyncRead(port, handler, feedback.address, feedback.size)
    for servo in servos:
        reader.addParam(servo.id)

    def read() -> bool:
        fast = model.fast_sync_read_firmware is not None
        result = reader.fastSyncRead() if fast else reader.txRxPacket()
        for servo in servos:
            for register in feedback.registers:
                reader.getData(servo.id, register.address, register.size)
        return bool(result == sdk.COMM_SUCCESS)

    return [write, read]


def _read_one(sdk: Any, port: Any, handler: Any, servo_id: int, block: Block) -> bool:
    return bool(handler.readTxRx(port, servo_id, block.address, block.size)[1] == sdk.COMM_SUCCESS)

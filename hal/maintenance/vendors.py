"""Which vendor's SDK serves which protocol. Loads them all: import it only where one is needed."""

from collections.abc import Callable

from hal.maintenance.dynamixel_vendor import DynamixelSdk
from hal.maintenance.feetech_vendor import FeetechSdk
from hal.maintenance.sdk_port import SdkPort
from hal.maintenance.vendor_sdk import VendorSdk
from hal.register_map import ServoModel

_SDKS: dict[str, Callable[[SdkPort], VendorSdk]] = {
    "dynamixel-2.0": DynamixelSdk,
    "feetech-sts": FeetechSdk,
    "feetech-scs": FeetechSdk,
}


def vendor_sdk(model: ServoModel, port: SdkPort) -> VendorSdk:
    """Return the SDK of a servo model's vendor, over a port."""
    return _SDKS[model.protocol](port)

"""Feetech's protocol for the SCS series: the frames of the STS series, without sync read.

Numbers of two bytes have the high byte first; that is the registers' affair (`hal.encoding`).
"""

from collections.abc import Sequence

from hal.feetech_protocol import BROADCAST_ID as BROADCAST_ID
from hal.feetech_protocol import BULK_READ as BULK_READ
from hal.feetech_protocol import PING_SLOT_NS as PING_SLOT_NS
from hal.feetech_protocol import action as action
from hal.feetech_protocol import bulk_read as bulk_read
from hal.feetech_protocol import describe_error as describe_error
from hal.feetech_protocol import factory_reset as factory_reset
from hal.feetech_protocol import ping as ping
from hal.feetech_protocol import read as read
from hal.feetech_protocol import reboot as reboot
from hal.feetech_protocol import receiver as receiver
from hal.feetech_protocol import reg_write as reg_write
from hal.feetech_protocol import sync_write as sync_write
from hal.feetech_protocol import write as write
from hal.protocol import GroupReply


def group_read(address: int, length: int, ids: Sequence[int], *, fast: bool) -> tuple[bytes, GroupReply]:
    """Raise ValueError: these servos are read one by one."""
    raise ValueError("SCS servos have no sync read: read each by itself")

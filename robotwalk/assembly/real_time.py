"""What a process does to keep deadlines, once all that it needs is loaded."""

import gc

from robotwalk.doctor import rights
from robotwalk.realtime import keep_memory, lock_memory, pin, raise_priority, sharpen_timers


def enter_real_time(awake: bool) -> list[str]:
    """Keep whatever else this computer does from this process, as far as there is the right to; return what lacks."""
    gc.collect()
    gc.freeze()
    gc.disable()  # nothing in a tick makes cycles
    keep_memory()
    sharpen_timers()
    alone = pin()
    had = {rights.FIRST: raise_priority(), rights.MEMORY: lock_memory(), rights.AWAKE: awake}
    shares = [] if alone else ["every processor has a loop already: this one shares the processor of another"]
    return [*rights.lacking([right for right, there in had.items() if not there]), *shares]

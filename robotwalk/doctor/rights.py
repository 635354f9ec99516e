"""The rights that a loop wants from Linux. The loop tells which it lacks, the doctor did so before, in one voice."""

from collections.abc import Sequence
from typing import NamedTuple

from robotwalk.doctor.remedy import Remedy, writing

GROUP = "dialout"  # Debian's, of those who may use serial ports
_LIMITS = writing(
    f"@{GROUP} - rtprio 80\n@{GROUP} - memlock unlimited", ["/etc/security/limits.d/robotwalk.conf"],
    f"for members of {GROUP} who log in again")


class Right(NamedTuple):
    """Something that Linux lets only some processes do."""

    name: str  # in "no right to ..."
    why: str
    remedy: Remedy


FIRST = Right("run first (FIFO priority)", "whatever else runs here delays the loop by milliseconds", _LIMITS)
MEMORY = Right("lock memory", "a page that must come from the disk stops the loop meanwhile", _LIMITS)
AWAKE = Right(
    "keep processors awake", "idle processors sleep, and are up to a millisecond late",
    writing(
        f'KERNEL=="cpu_dma_latency", GROUP="{GROUP}", MODE="0660"', ["/etc/udev/rules.d/70-robotwalk-latency.rules"],
        f"from the next boot on, for members of {GROUP}"))


def lacking(rights: Sequence[Right]) -> list[str]:
    """Return what a loop has to say that lacks rights: a sentence for each command that grants some."""
    sentences = []
    for remedy in dict.fromkeys(right.remedy for right in rights):
        names = [right.name for right in rights if right.remedy == remedy]
        sentences.append(
            f"the loop may be late: no right to {' or to '.join(names)}; `{remedy.command}` grants it "
            f"{remedy.then}")
    return sentences

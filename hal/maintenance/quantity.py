"""Register values for people: counts <-> text in the register's unit, and what may be written."""

import math
import re
from collections.abc import Iterator
from difflib import get_close_matches

from hal.register_map import Access, Register, ServoModel
from robotwalk.errors import UsageError

_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*")


def register_of(model: ServoModel, name: str) -> Register:
    """Return a register by its name. Raises UsageError if there is none."""
    if name in model.by_name:
        return model[name]
    near = get_close_matches(name, model.by_name, n=1)
    hint = f"did you mean {near[0]!r}?" if near else "`robotwalk servo info ID` lists them"
    raise UsageError(f"{model.name} has no register {name!r}; {hint}")


def in_units(register: Register, counts: int) -> float:
    """Return a value in the register's unit, to as many digits as tell its counts apart."""
    return round(counts * register.scale, _decimals(register))


def text(register: Register, counts: int) -> str:
    """Return a value with its unit: "12.3 V". Flags are told in words."""
    value = f"{counts * register.scale:.{_decimals(register)}f}"
    if "." in value:
        value = value.rstrip("0").rstrip(".")
    words = f" ({', '.join(flags(register, counts))})" if register.flags and counts else ""
    return f"{value} {register.unit}".rstrip() + words


def flags(register: Register, counts: int) -> list[str]:
    """Return what the bits that are set mean; a bit that means nothing known is called by its number."""
    meanings = dict(enumerate(register.flags))
    return [meanings.get(bit) or f"bit {bit}" for bit in range(8 * register.size) if counts >> bit & 1]


def counts(register: Register, words: str, *, raw: bool = False) -> int:
    """Return what to write for a value in the register's unit, its unit behind it or not; `raw`: in counts.

    Raises:
        UsageError: it is no number, of another unit, or the register does not take it.
    """
    match = _NUMBER.fullmatch(words)
    number = float(match[1]) if match else math.nan
    if match is None or not math.isfinite(number) or match[2] not in ("", "" if raw else register.unit):
        unit = f" of {register.unit}" if register.unit and not raw else ""
        raise UsageError(f"{register.name} should be a number{unit}, not {words!r}")
    value = number if raw else number / register.scale
    if (raw or register.scale == 1.0) and not value.is_integer():
        raise UsageError(f"{register.name} should be a whole number, not {words!r}")
    check(register, round(value))
    return round(value)


def check(register: Register, value: int) -> None:
    """Check that a register takes a value (counts). Raises UsageError, which says what it takes."""
    if register.access is Access.READ:
        raise UsageError(f"{register.name} is read-only")
    if register.choices is not None and value not in register.choices:
        raise UsageError(f"{register.name} should be one of {', '.join(_each(register))}, not {_both(register, value)}")
    low, high = register.range or _capacity(register)
    if not low <= value <= high:
        limits = f"{text(register, low)} to {text(register, high)}"
        raise UsageError(f"{register.name} should be {limits}, not {_both(register, value)}")


def _each(register: Register) -> Iterator[str]:
    return (text(register, value) for value in register.choices or ())


def _both(register: Register, value: int) -> str:
    plain = text(register, value)
    return plain if register.scale == 1.0 else f"{plain} (counts: {value})"


def _decimals(register: Register) -> int:
    return 0 if register.scale.is_integer() else max(0, 1 - math.floor(math.log10(register.scale)))


def _capacity(register: Register) -> tuple[int, int]:
    """Return the least and the largest value that fit."""
    if register.sign_bit is not None:
        return 1 - (1 << register.sign_bit), (1 << register.sign_bit) - 1
    bits = 8 * register.size
    return (-(1 << bits - 1), (1 << bits - 1) - 1) if register.signed else (0, (1 << bits) - 1)

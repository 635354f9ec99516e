"""NamedTuples as plain tuples and back, by their annotations: what `marshal` takes, much faster than `pickle`."""

import marshal
import pickle
import types
from collections.abc import Callable, Sequence
from enum import Enum
from typing import Any, Generic, Literal, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

_Change = Callable[[Any], Any]
_UNTOLD = (tuple, Sequence, type, object)
_FORMAT = 2  # the last without references to what came before: finding them takes longer than writing it twice


Thing = TypeVar("Thing")


class Codec(Generic[Thing]):
    """Packs one class of NamedTuples.

    Their fields may be numbers, strings, literals, booleans, Enums, NamedTuples, `X | None`, and tuples or sequences of
    one kind, which come back as tuples. What an annotation does not tell is pickled: compiled code tells less (mypyc).
    """

    def __init__(self, kind: type[Thing]) -> None:
        """Prepare. Raises TypeError if a field is something else."""
        change = _changes(kind)
        self._plain, self._named = change or _Changes(_same, _same)

    def pack(self, thing: Thing) -> bytes:
        """Return it as bytes."""
        return marshal.dumps(self._plain(thing), _FORMAT)

    def unpack(self, data: bytes) -> Thing:
        """Return what `pack` made these bytes of."""
        thing: Thing = self._named(marshal.loads(data))
        return thing


class _Changes(NamedTuple):
    """To plain, and back."""

    plain: _Change
    named: _Change


def _same(thing: Any) -> Any:
    return thing


def _changes(kind: Any) -> _Changes | None:
    """Return how to change something of a kind; None: `marshal` takes it as it is."""
    arguments = get_args(kind)
    if kind in (int, float, str, bool, bytes) or get_origin(kind) is Literal:
        return None
    if kind in _UNTOLD:
        return _Changes(pickle.dumps, pickle.loads)
    if get_origin(kind) in (Union, types.UnionType):
        (inner,) = (argument for argument in arguments if argument is not type(None))
        return _optional(_changes(inner))
    if get_origin(kind) in (tuple, Sequence):
        if set(arguments[1:]) <= {arguments[0], Ellipsis}:
            return _many(_changes(arguments[0]))
    elif isinstance(kind, type) and issubclass(kind, Enum):
        return _Changes(lambda member: member.value, kind)
    elif hasattr(kind, "_make"):
        hints = get_type_hints(kind)
        return _record(kind, [_changes(hints[field]) for field in kind._fields])
    raise TypeError(f"cannot pack {kind}")


def _optional(inner: _Changes | None) -> _Changes | None:
    if inner is None:
        return None
    plain, named = inner
    return _Changes(
        lambda thing: None if thing is None else plain(thing), lambda thing: None if thing is None else named(thing))


def _many(inner: _Changes | None) -> _Changes | None:
    if inner is None:
        return _Changes(tuple, _same)  # `marshal` refuses a NamedTuple, which may be one
    plain, named = inner
    return _Changes(lambda things: tuple(map(plain, things)), lambda things: tuple(map(named, things)))


def _record(kind: Any, fields: Sequence[_Changes | None]) -> _Changes:
    changed = [(index, change) for index, change in enumerate(fields) if change is not None]
    if not changed:
        return _Changes(tuple, kind._make)
    to_plain = [(index, change.plain) for index, change in changed]
    to_named = [(index, change.named) for index, change in changed if change.named is not _same]

    def plain(thing: Any) -> Any:
        values = list(thing)
        for index, change in to_plain:
            values[index] = change(values[index])
        return tuple(values)

    def named(values: Any) -> Any:
        fields = list(values)
        for index, change in to_named:
            fields[index] = change(fields[index])
        return kind(*fields)

    return _Changes(plain, named)

"""What a loop shows of a tick comes to its driver as it was."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from robotwalk.process.messages import REPORT, Report
from robotwalk.process.plain import Codec


def as_tuples(thing: Any) -> Any:
    """Return a thing, its lists as tuples."""
    if isinstance(thing, tuple) and hasattr(thing, "_make"):
        return type(thing)(*map(as_tuples, thing))
    return tuple(map(as_tuples, thing)) if isinstance(thing, (list, tuple)) else thing


@settings(max_examples=25, suppress_health_check=[HealthCheck.data_too_large])
@given(st.from_type(Report))
def test_any_report_comes_back_as_it_was(report: Report) -> None:
    assert repr(REPORT.unpack(REPORT.pack(report))) == repr(as_tuples(report))  # by repr, for NaN is not itself


class Odd(NamedTuple):
    by_name: Mapping[str, float]


class Erased(NamedTuple):
    """As mypyc leaves one."""

    items: tuple  # type: ignore[type-arg]
    thing: object


def test_a_tuple_of_who_knows_what_comes_back_too() -> None:
    codec = Codec(Erased)
    erased = Erased((Erased((), None), 1.0, None), Erased((), 2))
    assert codec.unpack(codec.pack(erased)) == erased


class Mixed(NamedTuple):
    pair: tuple[str, float]


@pytest.mark.parametrize("kind", [Odd, Mixed, dict])
def test_what_it_cannot_pack_is_refused_before_anything_runs(kind: type[Any]) -> None:
    with pytest.raises(TypeError, match="cannot pack"):
        Codec(kind)

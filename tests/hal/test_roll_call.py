"""Who is asked when: those that fell silent last, and less and less often."""

from collections.abc import Set

from hypothesis import given
from hypothesis import strategies as st

from hal.roll_call import RollCall

IDS = (4, 1, 7, 2)


def ticks(roll: RollCall, dead: Set[int], count: int, *, later_ids_answer: bool) -> list[list[int]]:
    """Let `dead` servos be silent for some ticks, as if one reply held all; return who was asked."""
    asked = []
    for _ in range(count):
        ids = list(roll.next())
        asked.append(ids)
        first = next((i for i, servo_id in enumerate(ids) if servo_id in dead), len(ids))
        heard = set(ids) - dead if later_ids_answer else set(ids[:first])
        roll.note(ids, heard)
    return asked


def test_as_long_as_all_answer_all_are_asked_in_their_order() -> None:
    assert ticks(RollCall(IDS), set(), 5, later_ids_answer=False) == [list(IDS)] * 5


def test_a_silent_servo_costs_those_behind_it_one_sample_and_is_asked_last_and_ever_less_often() -> None:
    asked = ticks(RollCall(IDS), {1}, 75, later_ids_answer=False)
    assert asked[0] == [4, 1, 7, 2], "where 7 and 2 had no chance"
    assert asked[1] == [7, 2, 4, 1], "so they come first"
    assert all(set(ids) >= {4, 7, 2} for ids in asked)
    assert all(ids[-1] == 1 for ids in asked[1:] if 1 in ids)
    assert [i for i, ids in enumerate(asked) if 1 in ids] == [0, 1, 2, 4, 8, 16, 32, 52, 72]


def test_a_servo_that_speaks_again_has_its_place_again() -> None:
    roll = RollCall(IDS)
    ticks(roll, {1}, 20, later_ids_answer=False)
    asked = ticks(roll, set(), 30, later_ids_answer=False)
    assert asked[-1] == list(IDS)


def test_only_the_first_that_is_missing_is_blamed() -> None:
    roll = RollCall(IDS)
    roll.note(roll.next(), {4})
    assert [servo_id for servo_id in IDS if roll.is_silent(servo_id)] == [1]


def test_servos_read_one_by_one_take_turns() -> None:
    """Three fit into a tick."""
    roll, asked = RollCall(IDS), []
    for _ in range(4):
        for servo_id in roll.next()[:3]:
            asked.append(servo_id)
            roll.note([servo_id], {servo_id})
    assert asked == [4, 1, 7, 2, 4, 1, 7, 2, 4, 1, 7, 2]


@given(st.sets(st.sampled_from(IDS)), st.booleans())
def test_whoever_is_dead_somebody_is_asked_and_the_living_in_every_tick_but_one(
    dead: set[int], later_ids_answer: bool
) -> None:
    asked = ticks(RollCall(IDS), dead, 60, later_ids_answer=later_ids_answer)
    assert all(asked)
    for ids in asked[len(dead) :]:
        assert set(IDS) - dead <= set(ids)

"""Files that are based on others, and numbered items."""

from collections.abc import Mapping
from pathlib import Path

import pytest
from pydantic import BaseModel, ConfigDict

from robotwalk.config import inheritance, library
from robotwalk.config.document import Document
from robotwalk.errors import ConfigError

BASE = """\
name: small
colour: red
size: {width: 1, height: 2}
rows:
  - {name: led, at: 1}
  - {name: key, at: 2}
  - {name: dial, at: 3}
"""


class Row(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: str
    at: int


class Thing(BaseModel):
    model_config = ConfigDict(extra="forbid")
    name: str
    colour: str
    size: dict[str, int]
    rows: list[Row]


def read(text: str, files: Mapping[str, str] = {"small": BASE}) -> Document:
    def open_base(name: str) -> Document:
        return inheritance.resolve(Document.parse(files[name], f"{name}.yaml"), open_base)

    return inheritance.resolve(Document.parse(text, "big.yaml"), open_base)


def thing(text: str) -> Thing:
    return read(text).validate(Thing)


def complaint(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        thing(text)
    return str(caught.value)


def test_what_a_file_does_not_give_is_its_bases() -> None:
    assert thing("base: small\nname: big\n") == Thing(**{**Document.parse(BASE, "").value(()), "name": "big"})


def test_a_key_takes_the_place_of_all_that_the_base_has_there() -> None:
    assert thing("base: small\nname: big\nsize: {width: 7}\n").size == {"width": 7}


def test_named_items_are_replaced_added_and_left_out() -> None:
    rows = thing("base: small\nname: big\nwithout: [dial]\nrows: [{name: led, at: 9}, {name: horn, at: 4}]\n").rows
    assert {row.name: row.at for row in rows} == {"led": 9, "key": 2, "horn": 4}


def test_a_base_may_have_a_base() -> None:
    middle = "base: small\nname: middle\ncolour: blue\n"
    found = read("base: middle\nname: big\nwithout: [led]\n", {"small": BASE, "middle": middle}).validate(Thing)
    assert (found.name, found.colour, [row.name for row in found.rows]) == ("big", "blue", ["key", "dial"])


def test_numbered_items() -> None:
    text = BASE + "  - {name: fan, numbers: [3, 5], step: {at: 2}, at: 10}\n"
    assert [(row.name, row.at) for row in thing(text).rows[3:]] == [("fan_3", 10), ("fan_4", 12), ("fan_5", 14)]


def test_one_of_the_bases_numbered_items_is_replaced() -> None:
    base = BASE + "  - {name: fan, numbers: [1, 3], at: 10}\n"
    found = read("base: small\nname: big\nrows: [{name: fan_2, at: 0}]\n", {"small": base}).validate(Thing)
    assert {row.name: row.at for row in found.rows if "fan" in row.name} == {"fan_1": 10, "fan_2": 0, "fan_3": 10}


def test_a_mistake_is_reported_in_the_file_that_it_is_in() -> None:
    base = BASE.replace("at: 2", "at: two")
    with pytest.raises(ConfigError) as caught:
        read("base: small\nname: big\nrows:\n  - {name: led, att: 9}\n", {"small": base}).validate(Thing)
    assert str(caught.value).splitlines() == [
        "big.yaml:4:17: rows.2: unknown key 'att': did you mean 'at'?",
        "small.yaml:6:21: rows.0.at: expected a whole number (got 'two')",
    ]


def test_a_mistake_in_a_numbered_item_is_where_it_is_written() -> None:
    text = BASE + "  - {name: fan, numbers: [1, 2], at: 10, od: 1}\n"
    assert complaint(text).splitlines()[0].startswith("big.yaml:8:42: rows.3: unknown key 'od'")


@pytest.mark.parametrize(("text", "says"), [
    ("base: 7\nname: big\n", "big.yaml:1:7: base: expected the name of a file (got 7)"),
    ("base: small\n", "big.yaml:1:1: missing key 'name'"),
    ("without: [led]\n", "big.yaml:1:10: without: there is no base to take anything from"),
    ("base: small\nname: big\nwithout: led\n", "big.yaml:3:10: without: expected a list (got 'led')"),
    ("base: small\nname: big\nwithout: [lead]\n",
     "big.yaml:3:11: without.0: the base has no such item (got 'lead')"),
    (BASE + "  - {name: f, numbers: [2, 1], at: 1}\n",
     "big.yaml:8:24: rows.3.numbers: expected a first and a last number (got [2, 1])"),
    (BASE + "  - {name: f, numbers: [1, 2000], at: 1}\n",
     "big.yaml:8:24: rows.3.numbers: expected a first and a last number (got [1, 2000])"),
    (BASE + "  - {name: f, numbers: 2, at: 1}\n",
     "big.yaml:8:24: rows.3.numbers: expected a first and a last number (got 2)"),
    (BASE + "  - {numbers: [1, 2], at: 1}\n", "big.yaml:8:5: rows.3: missing key 'name'"),
    (BASE + "  - {name: 8, numbers: [1, 2], at: 1}\n", "big.yaml:8:12: rows.3.name: expected text (got 8)"),
    (BASE + "  - {name: f, numbers: [1, 2], at: 1, step: 2}\n",
     "big.yaml:8:45: rows.3.step: expected a mapping (got 2)"),
    (BASE + "  - {name: f, numbers: [1, 2], at: 1, step: {at: x}}\n",
     "big.yaml:8:50: rows.3.step.at: expected a whole number, of one that the item has (got 'x')"),
    (BASE + "  - {name: f, numbers: [1, 2], at: 1, step: {of: 1}}\n", "big.yaml:8:5: rows.3: missing key 'of'"),
])
def test_each_mistake_is_one_sentence(text: str, says: str) -> None:
    assert complaint(text) == says


def test_servos_of_users_are_based_on_bundled_ones_by_name_and_never_on_themselves(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text("base: mx-28\nname: mine\n")
    assert library.open_document("servos", str(mine)).value(("model_number",)) == 30
    mine.write_text("base: mx-29\nname: mine\n")
    with pytest.raises(ConfigError, match=r"mine.yaml:1:7: base: no servo is named 'mx-29'; did you mean 'mx-28'\?"):
        library.open_document("servos", str(mine))
    mine.write_text(f"base: {mine}\nname: mine\n")
    with pytest.raises(ConfigError, match="base: a file cannot be based on itself"):
        library.open_document("servos", str(mine))

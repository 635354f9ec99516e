"""What a user reads when a configuration file is wrong, word by word."""

from contextlib import suppress
from pathlib import Path
from typing import Annotated, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from robotwalk.config.document import Document
from robotwalk.errors import ConfigError


class Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Leg(Section):
    length_mm: Annotated[float, Field(gt=0)]
    mount: tuple[float, float] = (0.0, 0.0)
    motors: int = 3
    inverted: bool = False


class Wire(Section):
    kind: Literal["wire"]
    baud: int


class Radio(Section):
    kind: Literal["radio"]
    channel: int


class Robot(Section):
    schema_version: Annotated[Literal[1], Field(alias="schema")]
    name: str
    legs: Annotated[dict[str, Leg], Field(min_length=1)] = {}
    spares: list[Leg] = []
    spine: Leg | None = None
    link: Annotated[Wire | Radio, Field(discriminator="kind")] | None = None

    @field_validator("name")
    @classmethod
    def _no_spaces(cls, name: str) -> str:
        if " " in name:
            raise ValueError("expected a name without spaces")
        return name


GOOD = """\
schema: 1
name: hexapod
legs:
  left:
    length_mm: 80
    mount: [10, 20]
spares:
  - length_mm: 81
  - {length_mm: 82, motors: 4}
"""


def complaints(text: str, model: type[BaseModel] = Robot) -> list[str]:
    with pytest.raises(ConfigError) as caught:
        Document.parse(text, "robot.yaml").validate(model)
    return str(caught.value).splitlines()


def complaint(old: str, new: str) -> str:
    """Return the only line that is said of the good document after a replacement."""
    assert GOOD.count(old) == 1
    [line] = complaints(GOOD.replace(old, new))
    return line


def syntax_error(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        Document.parse(text, "f.yaml")
    return str(caught.value)


def test_a_good_document_is_read() -> None:
    robot = Document.parse(GOOD, "robot.yaml").validate(Robot)
    assert robot.schema_version == 1
    assert robot.legs == {"left": Leg(length_mm=80, mount=(10, 20))}
    assert [leg.length_mm for leg in robot.spares] == [81, 82]


class TestSchema:
    def test_unknown_key_with_a_near_one(self) -> None:
        assert complaint("    mount: [10, 20]", "    motor: 2") == (
            "robot.yaml:6:5: legs.left: unknown key 'motor': did you mean 'motors'?"
        )

    def test_unknown_key_inside_a_list(self) -> None:
        assert complaint("motors: 4", "mout: 4") == (
            "robot.yaml:9:21: spares.1: unknown key 'mout': did you mean 'mount'?"
        )

    def test_unknown_key_with_none_near(self) -> None:
        assert complaint("motors: 4", "colour: red") == (
            "robot.yaml:9:21: spares.1: unknown key 'colour': "
            "valid keys are 'length_mm', 'mount', 'motors', 'inverted'"
        )

    def test_keys_go_by_their_alias(self) -> None:
        assert complaint("schema: 1", "schema: 1\nshema: 1") == (
            "robot.yaml:2:1: unknown key 'shema': did you mean 'schema'?"
        )
        assert complaint("schema: 1", "schema: 2") == "robot.yaml:1:9: schema: expected 1 (got 2)"

    def test_unknown_key_in_an_optional_section(self) -> None:
        assert complaint("spares:", "spine:\n  {length_mm: 3, lenght_mm: 4}\nspares:") == (
            "robot.yaml:8:18: spine: unknown key 'lenght_mm': did you mean 'length_mm'?"
        )

    def test_missing_key_points_at_the_mapping(self) -> None:
        assert complaint("    length_mm: 80\n", "") == "robot.yaml:5:5: legs.left: missing key 'length_mm'"
        assert complaint("schema: 1\n", "") == "robot.yaml:1:1: missing key 'schema'"

    def test_a_path_does_not_name_the_member_of_a_union(self) -> None:
        assert complaint("legs:", "link: {kind: wire, baud: fast}\nlegs:") == (
            "robot.yaml:3:26: link.baud: expected a whole number (got 'fast')"
        )
        assert complaint("legs:", "link: {kind: radio, channel: 1, baud: 2}\nlegs:") == (
            "robot.yaml:3:33: link: unknown key 'baud': valid keys are 'kind', 'channel'"
        )

    @pytest.mark.parametrize(
        ("old", "new", "expected"),
        [
            ("80", ".nan", "robot.yaml:5:16: legs.left.length_mm: expected a finite number (got nan)"),
            ("80", "-.inf", "robot.yaml:5:16: legs.left.length_mm: expected a finite number (got -inf)"),
            ("80", "long", "robot.yaml:5:16: legs.left.length_mm: expected a number (got 'long')"),
            ("80", "[1]", "robot.yaml:5:16: legs.left.length_mm: expected a number (got [1])"),
            ("80", "{a: 1}", "robot.yaml:5:16: legs.left.length_mm: expected a number (got a mapping)"),
            ("80", "", "robot.yaml:5:15: legs.left.length_mm: expected a number (got nothing)"),
            ("80", "-2", "robot.yaml:5:16: legs.left.length_mm: expected a number greater than 0 (got -2)"),
            ("4}", "2.5}", "robot.yaml:9:29: spares.1.motors: expected a whole number (got 2.5)"),
            (
                "81",
                "81\n    inverted: 7",
                "robot.yaml:9:15: spares.0.inverted: expected true or false (got 7)",
            ),
            ("[10, 20]", "ahead", "robot.yaml:6:12: legs.left.mount: expected a list (got 'ahead')"),
            ("[10, 20]", "[10]", "robot.yaml:6:12: legs.left.mount: missing item 1"),
            ("[10, 20]", "[1, 2, 3]", "robot.yaml:6:12: legs.left.mount: expected 2 or fewer items (got 3)"),
            ("[10, 20]", "[1, up]", "robot.yaml:6:16: legs.left.mount.1: expected a number (got 'up')"),
            ("- length_mm: 81", "- 81", "robot.yaml:8:5: spares.0: expected a mapping (got 81)"),
            ("hexapod", "true", "robot.yaml:2:7: name: expected text (got true)"),
            ("hexapod", "a b", "robot.yaml:2:7: name: expected a name without spaces (got 'a b')"),
            ("legs:\n  left:", "legs: {}\nspine:", "robot.yaml:3:7: legs: expected 1 or more items (got 0)"),
        ],
    )
    def test_wrong_value(self, old: str, new: str, expected: str) -> None:
        assert complaint(old, new) == expected

    def test_long_values_are_cut(self) -> None:
        line = complaint("80", "x" * 500)
        assert line == f"robot.yaml:5:16: legs.left.length_mm: expected a number (got '{'x' * 56}...)"

    def test_all_problems_are_told_in_the_files_order(self) -> None:
        text = "spares: [{length_mm: -1}]\nextra: 2\nlegs: {a: {motors: x, length_mm: 1}}\nschema: 1\n"
        assert complaints(text) == [
            "robot.yaml:1:1: missing key 'name'",
            "robot.yaml:1:22: spares.0.length_mm: expected a number greater than 0 (got -1)",
            "robot.yaml:2:1: unknown key 'extra': "
            "valid keys are 'schema', 'name', 'legs', 'spares', 'spine', 'link'",
            "robot.yaml:3:20: legs.a.motors: expected a whole number (got 'x')",
        ]

    @pytest.mark.parametrize(("text", "got"), [("", "nothing"), ("just words", "'just words'")])
    def test_a_document_that_is_no_mapping(self, text: str, got: str) -> None:
        assert complaints(text) == [f"robot.yaml:1:1: expected a mapping (got {got})"]

    def test_a_key_that_the_schema_refuses(self) -> None:
        class Named(Section):
            legs: dict[Annotated[str, Field(max_length=3)], int]

        assert complaints("legs: {fr: 1,\n  front: 2}", Named) == [
            "robot.yaml:2:3: legs.front: String should have at most 3 characters (got 'front')"
        ]

    def test_a_check_of_the_whole_model_speaks_for_itself(self) -> None:
        class Pair(Section):
            low: int
            high: int

            @model_validator(mode="after")
            def _ordered(self) -> "Pair":
                if self.low > self.high:
                    raise ValueError("low must not be above high")
                return self

        assert complaints("low: 2\nhigh: 1", Pair) == ["robot.yaml:1:1: low must not be above high"]

    def test_a_part_of_the_document(self) -> None:
        document = Document.parse(GOOD.replace("80", "far"), "robot.yaml")
        assert document.validate(Leg, at=("spares", 1)).motors == 4
        with pytest.raises(ConfigError) as caught:
            document.validate(Leg, at=("legs", "left"))
        assert str(caught.value) == "robot.yaml:5:16: legs.left.length_mm: expected a number (got 'far')"


class TestLaterChecks:
    document = Document.parse(GOOD, "robot.yaml")

    def test_value(self) -> None:
        assert self.document.value(()) == {
            "schema": 1,
            "name": "hexapod",
            "legs": {"left": {"length_mm": 80, "mount": [10, 20]}},
            "spares": [{"length_mm": 81}, {"length_mm": 82, "motors": 4}],
        }
        assert self.document.value(("spares", 1, "motors")) == 4

    @pytest.mark.parametrize(
        ("path", "expected"),
        [
            (("legs", "right"), "robot.yaml:4:3: legs: missing key 'right'"),
            (("spares", 2), "robot.yaml:8:3: spares: missing item 2"),
            (("name", 0), "robot.yaml:2:7: name: missing item 0"),
        ],
    )
    def test_value_that_is_not_there(self, path: tuple[str | int, ...], expected: str) -> None:
        with pytest.raises(ConfigError) as caught:
            self.document.value(path)
        assert str(caught.value) == expected

    def test_error_at_a_value(self) -> None:
        error = self.document.error(("legs", "left", "length_mm"), "expected a leg of 90 mm", got=80)
        assert isinstance(error, ConfigError)
        assert str(error) == "robot.yaml:5:16: legs.left.length_mm: expected a leg of 90 mm (got 80)"

    def test_error_at_the_nearest_ancestor(self) -> None:
        error = self.document.error(("legs", "left", "knee", 3), "expected a knee")
        assert str(error) == "robot.yaml:5:5: legs.left.knee.3: expected a knee"

    def test_error_without_a_path_or_a_document(self) -> None:
        assert str(self.document.error((), "expected more")) == "robot.yaml:1:1: expected more"
        assert str(Document.parse("", "f.yaml").error(("a",), "expected b")) == "f.yaml:1:1: a: expected b"

    def test_nothing_is_something_that_may_have_been_found(self) -> None:
        assert str(self.document.error((), "wrong", got=None)) == "robot.yaml:1:1: wrong (got nothing)"


class TestYaml:
    @pytest.mark.parametrize(
        ("text", "expected"),
        [
            ("a: b: c", "f.yaml:1:5: not valid YAML: mapping values are not allowed here"),
            ("a:\n\tb: 1", "f.yaml:2:1: not valid YAML: while scanning for the next token, "
             "found character '\\t' that cannot start any token"),
            ("a: [1\nb: 2", "f.yaml:2:2: not valid YAML: while parsing a flow sequence, "
             "expected ',' or ']', but got ':'"),
            ("a: 1\n---\nb: 2", "f.yaml:2:1: not valid YAML: expected a single document in the stream, "
             "but found another document"),
            ("a: *b", "f.yaml:1:4: not valid YAML: found undefined alias 'b'"),
            ("a: !servo b", "f.yaml:1:4: not valid YAML: "
             "could not determine a constructor for the tag '!servo'"),
            ("a:\n  !servo {b: 1}", "f.yaml:2:3: a: the tag '!servo' is not known here"),
            ("a: \x07", "f.yaml:1:4: not valid YAML: character '\\x07' is not allowed"),
            ("a: 1\nb: !!int x", "f.yaml:2:4: b: expected a value that fits !!int (got 'x')"),
            ("a: 2026-02-31", "f.yaml:1:4: a: expected a value that fits !!timestamp (got '2026-02-31')"),
            ("a: 1\nb: 2\na: 3", "f.yaml:3:1: duplicate key 'a', which is on line 1 already"),
            ("l:\n- {x: 1,\n   x: 2}", "f.yaml:3:4: l.0: duplicate key 'x', which is on line 2 already"),
            ("a: {on: 1}", "f.yaml:1:5: a: expected text as a key, in quotes if need be (got on)"),
            ("1: a", "f.yaml:1:1: expected text as a key, in quotes if need be (got 1)"),
            ("? [a]\n: 1", "f.yaml:1:3: expected text as a key, in quotes if need be"),
            ("? !!str [a]\n: 1", "f.yaml:1:3: expected text as a key, in quotes if need be"),
            ("a: &x\n  b: [*x]", "f.yaml:1:4: a.b.0: an alias stands for something that contains it"),
            ("<<: 3", "f.yaml:1:5: not valid YAML: while constructing a mapping, "
             "expected a mapping or list of mappings for merging, but found scalar"),
            ("[" * 5000, "f.yaml:1:1: nested too deeply"),
        ],
    )
    def test_what_is_refused(self, text: str, expected: str) -> None:
        assert syntax_error(text) == expected

    def test_anchors_aliases_and_merges(self) -> None:
        text = "base: &base {length_mm: 5, motors: 2}\nlegs: {a: *base, b: {<<: *base, motors: x}}\n"
        document = Document.parse(text, "f.yaml")
        assert document.value(("legs",)) == {
            "a": {"length_mm": 5, "motors": 2},
            "b": {"length_mm": 5, "motors": "x"},
        }
        assert str(document.error(("legs", "b", "motors"), "wrong")) == "f.yaml:2:41: legs.b.motors: wrong"
        assert str(document.error(("legs", "a", "motors"), "wrong")) == "f.yaml:1:36: legs.a.motors: wrong"

    def test_aliases_of_aliases_take_no_time(self) -> None:
        lines = ["a0: &a0 [1]", *(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]" for i in range(1, 60))]
        assert Document.parse("\n".join(lines), "f.yaml").value(("a1", 0, 0)) == 1

    @given(st.text(alphabet="a1 :,-[]{}&*!<>|?#'\"\n\t.%@\x07\ufeff", max_size=40))
    def test_no_text_raises_anything_else(self, text: str) -> None:
        with suppress(ConfigError):
            Document.parse(text, "f.yaml").validate(Robot)


class TestFile:
    def test_read(self, tmp_path: Path) -> None:
        path = tmp_path / "robot.yaml"
        path.write_bytes(b"\xef\xbb\xbfname: \xc3\xa4\n")
        document = Document.read(path)
        assert document.name == str(path)
        assert document.value(("name",)) == "ä"
        assert str(document.error(("name",), "wrong")) == f"{path}:1:7: name: wrong"

    def test_a_byte_order_mark_is_no_column(self, tmp_path: Path) -> None:
        path = tmp_path / "robot.yaml"
        path.write_bytes(b"\xef\xbb\xbfa: \x07\n")
        with pytest.raises(ConfigError) as caught:
            Document.read(path)
        assert str(caught.value) == f"{path}:1:4: not valid YAML: character '\\x07' is not allowed"

    def test_absent(self, tmp_path: Path) -> None:
        with pytest.raises(ConfigError) as caught:
            Document.read(tmp_path / "none.yaml")
        assert str(caught.value) == f"{tmp_path}/none.yaml: cannot be read: No such file or directory"

    def test_folder(self, tmp_path: Path) -> None:
        with pytest.raises(ConfigError) as caught:
            Document.read(tmp_path)
        assert str(caught.value) == f"{tmp_path}: cannot be read: Is a directory"

    def test_not_utf8(self, tmp_path: Path) -> None:
        path = tmp_path / "robot.yaml"
        path.write_bytes(b"\xef\xbb\xbf\xe4\n")
        with pytest.raises(ConfigError) as caught:
            Document.read(path)
        assert str(caught.value) == f"{path}:1:1: expected UTF-8 text (got byte 0xe4)"
        path.write_bytes(b"name: 1\nlast: \xe4\n")
        with pytest.raises(ConfigError) as caught:
            Document.read(path)
        assert str(caught.value) == f"{path}:2:7: expected UTF-8 text (got byte 0xe4)"

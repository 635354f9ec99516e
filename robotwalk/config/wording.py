"""What is wrong with a file, in its own words: pydantic's complaints, by the keys and values that people wrote."""

from collections.abc import Mapping
from difflib import get_close_matches
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import ErrorDetails

KeyPath = tuple[str | int, ...]

_EXPECTED = {
    "bool_parsing": "true or false",
    "bool_type": "true or false",
    "dict_type": "a mapping",
    "finite_number": "a finite number",
    "float_parsing": "a number",
    "float_type": "a number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "int_type": "a whole number",
    "list_type": "a list",
    "model_type": "a mapping",
    "string_type": "text",
    "tuple_type": "a list",
}


def follow(model: Any, location: tuple[str | int, ...]) -> tuple[KeyPath, list[Any]]:
    """Return the path in the document that pydantic's `location` means, and the schemas that its end is in.

    Where a location comes to a union, it names the member that was tried; a path does not.
    """
    path: KeyPath = ()
    holders: list[Any] = []
    schema = model
    for step in location:
        members = _members(schema)
        if len(members) > 1:
            schema = next((member for member in members if step in _labels(member)), members[0])
        elif step != "[key]":
            path = (*path, step)
            holders = members
            schema = _inside(members[0], step)
    return path, holders


def _members(schema: Any) -> list[Any]:
    """Return the members of a union but None, or just the schema."""
    if get_origin(schema) is Annotated:
        return _members(get_args(schema)[0])
    if get_origin(schema) in (Union, UnionType):
        return [member for each in get_args(schema) if each is not NoneType for member in _members(each)]
    return [schema]


def _labels(schema: Any) -> set[str]:
    """Return what pydantic may call the member of a union: by its class or by a discriminator."""
    values = [get_args(f.annotation) for f in _fields(schema).values() if get_origin(f.annotation) is Literal]
    return {getattr(schema, "__name__", ""), *(str(value) for group in values for value in group)}


def _inside(schema: Any, step: str | int) -> Any:
    arguments = get_args(schema)
    if not arguments:
        field = _fields(schema).get(str(step))
        return field.annotation if field else None
    if isinstance(step, int) and step < len(arguments) and arguments[-1] is not ...:
        return arguments[step]
    return arguments[0] if isinstance(step, int) else arguments[-1]


def _fields(schema: Any) -> Mapping[str, FieldInfo]:
    """Return a model's fields by the keys that the file has for them."""
    if not (isinstance(schema, type) and issubclass(schema, BaseModel)):
        return {}
    return {field.alias or name: field for name, field in schema.model_fields.items()}


def missing(step: str | int) -> str:
    """Say that a key, or an item of a list, is not there."""
    return f"missing item {step}" if isinstance(step, int) else f"missing key {step!r}"


def nearest(key: str | int, schemas: list[Any]) -> str | None:
    """Return the valid key that was probably meant, if one is near."""
    near = get_close_matches(str(key), _valid_keys(schemas), n=1)
    return near[0] if near else None


def _valid_keys(schemas: list[Any]) -> list[str]:
    return [name for schema in schemas for name in _fields(schema)]


def unknown(key: str | int, schemas: list[Any]) -> str:
    """Say that none of the schemas has a key, and which one was meant."""
    near = nearest(key, schemas)
    hint = f"did you mean {near!r}?" if near else f"valid keys are {', '.join(map(repr, _valid_keys(schemas)))}"
    return f"unknown key {key!r}: {hint}"


def wrong_value(detail: ErrorDetails) -> str:
    """Say what was expected, and what was there."""
    kind, message, context = detail["type"], detail["msg"], detail.get("ctx", {})
    if kind in ("value_error", "assertion_error"):
        return str(context["error"]) + ("" if isinstance(detail["input"], dict) else got(detail["input"]))
    if kind == "too_short":
        return f"expected {context['min_length']} or more items (got {context['actual_length']})"
    if kind == "too_long":
        return f"expected {context['max_length']} or fewer items (got {context['actual_length']})"
    wanted = _EXPECTED.get(kind) or message.removeprefix("Input should be ")
    if wanted.startswith(("greater", "less")):
        wanted = f"a number {wanted}"
    return ("" if wanted == message else "expected ") + wanted + got(detail["input"])


def got(value: object) -> str:
    """Return what was found, as YAML would have it."""
    if value is ...:
        return ""
    if value is None or isinstance(value, bool):
        shown = {None: "nothing", True: "true", False: "false"}[value]
    elif isinstance(value, dict):
        shown = "a mapping"
    else:
        shown = repr(value) if isinstance(value, (str, list, tuple)) else str(value)
    return f" (got {shown if len(shown) <= 60 else shown[:57] + '...'})"

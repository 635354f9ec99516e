"""Files that say "as that one, except", and lists whose items are numbered.

    base: NAME          all that this file does not give is as in the file of that name
    without: [ITEM]     but for these items of its lists

What the file gives under a key takes the place of all that the base has there. Lists of items with a `name` alone are
taken together: an item takes the place of the base's of its name, or is added.

    {name: led, numbers: [1, 3], address: 20, step: {address: 2}}

stands for led_1, led_2 and led_3, at 20, 22 and 24. Every item keeps the place in the file that it came from.
"""

from collections.abc import Callable, Iterator
from typing import TypeGuard

import yaml

from robotwalk.config.document import Document
from robotwalk.config.wording import KeyPath

_INT = "tag:yaml.org,2002:int"
_MOST = 1000  # numbered items


def resolve(document: Document, open_base: Callable[[str], Document]) -> Document:
    """Return a document with its base filled in and its numbered items written out.

    Raises:
        ConfigError: one of these keys does not say what it should. What `open_base` raises goes through.
    """
    if not isinstance(document.root, yaml.MappingNode):
        return document
    own = {key.value: (key, _expanded(document, (key.value,), value)) for key, value in document.root.value}
    if "base" not in own:
        if "without" in own:
            raise document.error(("without",), "there is no base to take anything from")
        return Document.from_nodes(document.name, document.text, _mapping(document.root, own))
    name = document.value(("base",))
    if not isinstance(name, str):
        raise document.error(("base",), "expected the name of a file", name)
    document.value(("name",))  # that one may not be the base's
    base = open_base(name).root
    assert isinstance(base, yaml.MappingNode)  # or it would have no name
    left_out = _names_left_out(document, base)
    del own["base"]
    own.pop("without", None)
    merged = {key.value: (key, _trimmed(value, left_out)) for key, value in base.value}
    for step, (key, value) in own.items():
        inherited = merged.get(step, (key, value))[1]
        merged[step] = key, _merged(inherited, value)
    return Document.from_nodes(document.name, document.text, _mapping(document.root, merged))


def _names_left_out(document: Document, base: yaml.MappingNode) -> set[str]:
    if "without" not in document.value(()):
        return set()
    names = document.value(("without",))
    if not isinstance(names, list):
        raise document.error(("without",), "expected a list", names)
    known = {name for _, value in base.value if _is_named_list(value) for name in map(_name, value.value)}
    for index, name in enumerate(names):
        if name not in known:
            raise document.error(("without", index), "the base has no such item", name)
    return set(names)


def _trimmed(node: yaml.Node, left_out: set[str]) -> yaml.Node:
    if not _is_named_list(node):
        return node
    return _sequence(node, [item for item in node.value if _name(item) not in left_out])


def _merged(base: yaml.Node, own: yaml.Node) -> yaml.Node:
    if not (_is_named_list(base) and _is_named_list(own)):
        return own
    # Not by name alone: that a file gives a name twice is for its schema to see.
    given = {_name(item) for item in own.value}
    return _sequence(own, [item for item in base.value if _name(item) not in given] + own.value)


def _expanded(document: Document, path: KeyPath, node: yaml.Node) -> yaml.Node:
    """Write out the numbered items of every list in `node`."""
    if isinstance(node, yaml.MappingNode):
        pairs = {key.value: (key, _expanded(document, (*path, key.value), value)) for key, value in node.value}
        return _mapping(node, pairs)
    if isinstance(node, yaml.SequenceNode):
        return _sequence(node, [
            each for index, item in enumerate(node.value) for each in _items(document, (*path, index), item)])
    return node


def _items(document: Document, path: KeyPath, node: yaml.Node) -> Iterator[yaml.Node]:
    pairs = {key.value: (key, value) for key, value in node.value} if isinstance(node, yaml.MappingNode) else {}
    if "numbers" not in pairs:
        yield _expanded(document, path, node)
        return
    first, last = _bounds(document, path)
    steps = _steps(document, path)
    for place, number in enumerate(range(first, last + 1)):
        item = {step: pair for step, pair in pairs.items() if step not in ("numbers", "step")}
        key, name = item["name"]
        item["name"] = key, _scalar(name, name.tag, f"{name.value}_{number}")
        for step, size in steps.items():
            key, value = item[step]
            item[step] = key, _scalar(value, _INT, str(document.value((*path, step)) + place * size))
        yield _mapping(node, item)


def _bounds(document: Document, path: KeyPath) -> tuple[int, int]:
    if not isinstance(document.value((*path, "name")), str):
        raise document.error((*path, "name"), "expected text", document.value((*path, "name")))
    match document.value((*path, "numbers")):
        case [int(first), int(last)] if 0 <= first <= last < first + _MOST:
            return first, last
        case numbers:
            raise document.error((*path, "numbers"), "expected a first and a last number", numbers)


def _steps(document: Document, path: KeyPath) -> dict[str, int]:
    if "step" not in document.value(path):
        return {}
    steps = document.value((*path, "step"))
    if not isinstance(steps, dict):
        raise document.error((*path, "step"), "expected a mapping", steps)
    for key, size in steps.items():
        if not isinstance(size, int) or not isinstance(document.value((*path, key)), int):
            raise document.error((*path, "step", key), "expected a whole number, of one that the item has", size)
    return steps


def _is_named_list(node: yaml.Node) -> TypeGuard[yaml.SequenceNode]:
    return isinstance(node, yaml.SequenceNode) and all(
        isinstance(item, yaml.MappingNode) and _name(item) is not None for item in node.value)


def _name(item: yaml.MappingNode) -> str | None:
    return next((str(value.value) for key, value in item.value if key.value == "name"), None)


def _mapping(like: yaml.Node, pairs: dict[str, tuple[yaml.Node, yaml.Node]]) -> yaml.MappingNode:
    return yaml.MappingNode(like.tag, list(pairs.values()), like.start_mark, like.end_mark)


def _sequence(like: yaml.Node, items: list[yaml.Node]) -> yaml.SequenceNode:
    return yaml.SequenceNode(like.tag, items, like.start_mark, like.end_mark)


def _scalar(like: yaml.Node, tag: str, value: str) -> yaml.ScalarNode:
    return yaml.ScalarNode(tag, value, like.start_mark, like.end_mark)

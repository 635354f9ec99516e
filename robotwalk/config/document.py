"""YAML documents that keep positions, so that every complaint can say where:

    hexapod.yaml:12:9: skeleton.body: unknown key 'mas_g': did you mean 'mass_g'?

Lines and columns count from 1, items of a list from 0. A missing key is reported where its mapping begins.
"""

import io
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import yaml
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails
from yaml.reader import ReaderError

from robotwalk.config import wording
from robotwalk.config.wording import KeyPath
from robotwalk.errors import ConfigError

M = TypeVar("M", bound=BaseModel)

_TAG = "tag:yaml.org,2002:"
_MERGE = _TAG + "merge"
_MOST_TEXT, _LONGEST = 200_000, 400  # characters of a file and of a line that are left to libyaml


class _Place(NamedTuple):
    """Where something stands; a document that is based on another one holds parts from both files."""

    file: str
    line: int
    column: int


class _Problem(NamedTuple):
    """One complaint; sorts by its place."""

    place: _Place
    path: KeyPath
    text: str


class _PlainDumper(yaml.SafeDumper):
    """Writes what occurs twice twice: we accept no aliases."""

    def ignore_aliases(self, data: Any) -> bool:
        """Say that nothing may become an alias."""
        return True


class Document:
    """What a YAML file holds, and where.

    Attributes:
        name: what complaints call it.
        text: all of the file.
        root: its nodes, each with its place; None if it is empty.
    """

    def __init__(self, name: str, text: str, root: yaml.Node | None, content: Any) -> None:
        self.name = name
        self.text = text
        self.root = root
        self._content = content

    @classmethod
    def from_nodes(cls, name: str, text: str, root: yaml.Node | None) -> "Document":
        """Return the document of nodes in which `parse` found no flaw."""
        return cls(name, text, root, yaml.SafeLoader("").construct_document(root) if root else None)

    @classmethod
    def read(cls, path: Path) -> "Document":
        """Read a file. Raises ConfigError if that fails or if it is not YAML that we accept."""
        try:
            data = path.read_bytes()
        except OSError as error:
            raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
        try:
            text = data.decode("utf-8").removeprefix("\ufeff")
        except UnicodeDecodeError as error:
            before = data[: error.start].decode("utf-8-sig")
            problem = f"expected UTF-8 text (got byte 0x{data[error.start]:02x})"
            raise _config_error([_Problem(_end(str(path), before), (), problem)]) from error
        return cls.parse(text, str(path))

    @classmethod
    def parse(cls, text: str, name: str) -> "Document":
        """Read `text`, which complaints are to call `name`. Raises ConfigError as `read` does."""
        try:
            loader = yaml.SafeLoader(text)
            loader.name = name  # which every mark repeats
            root = _composed(text, name) or loader.get_single_node()
            flaws = list(_flaws(loader, root, (), (), set())) if root else []
            if not flaws:
                return cls.from_nodes(name, text, root)
        except ReaderError as error:
            problem = f"not valid YAML: character {chr(error.character)!r} is not allowed"
            flaws = [_Problem(_end(name, text[: error.position]), (), problem)]
        except yaml.MarkedYAMLError as error:
            words = ", ".join(filter(None, (error.context, error.problem)))
            flaws = [_Problem(_place(error.problem_mark), (), f"not valid YAML: {words}")]
        except RecursionError:
            flaws = [_Problem(_Place(name, 1, 1), (), "nested too deeply")]
        raise _config_error(flaws)

    @property
    def whole_text(self) -> str:
        """All that it holds, with what it is based on, as YAML that stands alone. Comments are lost."""
        return yaml.dump(self._content, Dumper=_PlainDumper, sort_keys=False, allow_unicode=True, width=120)

    def value(self, path: KeyPath) -> Any:
        """Return what is at `path`. Raises ConfigError if nothing is."""
        value = self._content
        for depth, step in enumerate(path):
            inside = dict(enumerate(value)) if isinstance(value, list) else value
            if not isinstance(inside, dict) or step not in inside:
                raise self.error(path[:depth], wording.missing(step))
            value = inside[step]
        return value

    def validate(self, model: type[M], at: KeyPath = ()) -> M:
        """Return what is at `at` as a `model`. Raises one ConfigError that tells everything wrong with it."""
        try:
            return model.model_validate(self.value(at))
        except ValidationError as error:
            details = error.errors(include_url=False)
        # A mistyped key is also missing; once is enough.
        meant = {
            (*path[:-1], wording.nearest(path[-1], schemas))
            for path, schemas in (wording.follow(model, d["loc"]) for d in details if d["type"] == "extra_forbidden")}
        details = [d for d in details if d["type"] != "missing" or wording.follow(model, d["loc"])[0] not in meant]
        raise _config_error([self._problem(model, at, detail) for detail in details])

    def error(self, path: KeyPath, problem: str, got: object = ...) -> ConfigError:
        """Return the error that says `problem` of what is at `path`, or of its nearest ancestor."""
        return _config_error([_Problem(self._position(path), path, problem + wording.got(got))])

    def _position(self, path: KeyPath, of_key: bool = False) -> _Place:
        """Return where the value at `path` is, or the key that holds it."""
        if self.root is None:
            return _Place(self.name, 1, 1)
        key = value = self.root
        for step in path:
            inside = _children(value)
            if step not in inside:
                return _place(value.start_mark)
            key, value = inside[step]
        return _place((key if of_key else value).start_mark)

    def _problem(self, model: type[BaseModel], at: KeyPath, detail: ErrorDetails) -> _Problem:
        """Put one of pydantic's complaints into words."""
        path, schemas = wording.follow(model, detail["loc"])
        path = at + path
        if detail["type"] == "missing":
            return _Problem(self._position(path[:-1]), path[:-1], wording.missing(path[-1]))
        if detail["type"] == "extra_forbidden":
            return _Problem(self._position(path, of_key=True), path[:-1], wording.unknown(path[-1], schemas))
        of_key = detail["loc"][-1:] == ("[key]",)
        return _Problem(self._position(path, of_key), path, wording.wrong_value(detail))


class _Named(io.StringIO):
    """A text with a name, which every mark repeats."""

    def __init__(self, text: str, name: str) -> None:
        super().__init__(text)
        self.name = name


def _composed(text: str, name: str) -> yaml.Node | None:
    """Return the nodes of a document by libyaml, ten times as fast as PyYAML itself.

    None: PyYAML is to do it. It has the better words for what is wrong, and notices what is nested too deeply, where
    libyaml's binding would overflow the stack.
    """
    if not yaml.__with_libyaml__ or len(text) > _MOST_TEXT or max(map(len, text.splitlines()), default=0) > _LONGEST:
        return None
    loader = yaml.CSafeLoader(_Named(text, name))
    try:
        root: yaml.Node | None = loader.get_single_node()
    except yaml.YAMLError:
        return None
    finally:
        loader.dispose()
    return root


def _flaws(
    loader: yaml.SafeLoader, node: yaml.Node, path: KeyPath, above: tuple[yaml.Node, ...], seen: set[int]
) -> Iterator[_Problem]:
    """Find what YAML allows and we do not, in every node once."""
    if node in above:
        yield _Problem(_place(node.start_mark), path, "an alias stands for something that contains it")
    if id(node) in seen:
        return
    seen.add(id(node))
    if isinstance(node, yaml.MappingNode):
        yield from _key_flaws(node, path)
    if isinstance(node, yaml.CollectionNode):
        if node.tag not in (_TAG + "map", _TAG + "seq"):
            yield _Problem(_place(node.start_mark), path, f"the tag {node.tag!r} is not known here")
    elif isinstance(node, yaml.ScalarNode):
        try:
            loader.construct_object(node)
        except (ValueError, LookupError, AttributeError):  # SafeLoader on `!!int x`, on 2026-02-31
            text = f"expected a value that fits {node.tag.replace(_TAG, '!!')}" + wording.got(node.value)
            yield _Problem(_place(node.start_mark), path, text)
    for step, (_, child) in _children(node).items():
        yield from _flaws(loader, child, (*path, step), (*above, node), seen)


def _key_flaws(node: yaml.MappingNode, path: KeyPath) -> Iterator[_Problem]:
    """Check that the keys of a mapping are text and are there once."""
    first: dict[str, int] = {}
    for key, _ in node.value:
        place = _place(key.start_mark)
        if not isinstance(key, yaml.ScalarNode) or key.tag not in (_TAG + "str", _MERGE):
            got = f" (got {key.value})" if isinstance(key, yaml.ScalarNode) else ""
            yield _Problem(place, path, f"expected text as a key, in quotes if need be{got}")
        elif key.value in first:
            text = f"duplicate key {key.value!r}, which is on line {first[key.value]} already"
            yield _Problem(place, path, text)
        else:
            first[key.value] = place.line


def _children(node: yaml.Node) -> dict[str | int, tuple[yaml.Node, yaml.Node]]:
    """Return the (key, value) nodes of a mapping, or twice each item of a sequence."""
    if isinstance(node, yaml.MappingNode):
        return {str(key.value): (key, value) for key, value in node.value}
    if isinstance(node, yaml.SequenceNode):
        return {index: (item, item) for index, item in enumerate(node.value)}
    return {}


def _place(mark: Any) -> _Place:
    return _Place(mark.name, mark.line + 1, mark.column + 1)


def _end(name: str, text: str) -> _Place:
    return _Place(name, text.count("\n") + 1, len(text) - text.rfind("\n"))


def _config_error(problems: Iterable[_Problem]) -> ConfigError:
    ordered = sorted(problems, key=lambda problem: problem.place)
    return ConfigError("\n".join(map(_written, ordered)))


def _written(problem: _Problem) -> str:
    path = ".".join(map(str, problem.path))
    file, line, column = problem.place
    return f"{file}:{line}:{column}: {path}{': ' if path else ''}{problem.text}"

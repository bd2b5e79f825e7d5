"""The JSON Schema of scenes, made from the tables and the records of their keys, for editors of TOML."""

from functools import cache
from typing import Any, NamedTuple

from pydantic import TypeAdapter

from camopt.core.storage.version import SITE
from camopt.scene.choices import NumberChoice, NumberRange, numbers_of
from camopt.scene.places import key_of, tables_of
from camopt.scene.scene import Scene
from camopt.scene.tables import SceneTable
from camopt.scene.tolerances import GivenTolerance

DIALECT = "http://json-schema.org/draft-07/schema#"
"""What every linter reads; nothing here needs a later one."""
BOUNDS = {"ge": "minimum", "le": "maximum", "lt": "exclusiveMaximum", "gt": "exclusiveMinimum"}
WITH_UNIT = {"type": "string", "pattern": r"^\s*[-+]?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?\s*(1/)?[a-zA-Zµ°%]"}
"""What a text is where a number is expected."""
ROW = "^[1-9][0-9]*$"
"""The number of a row, as ``[search]`` names it."""
TABLES = tables_of(Scene)
"""Every table by where it stands in a scene."""
MODELS = {model.__name__: (place, model) for place, model in TABLES.items()}


def scene_schema(site: str = SITE) -> dict[str, Any]:
    """The schema of a whole scene; with links to the reference where the address of the site is known."""
    made = dict(_made())
    tables = {name: _described(_shaped(each), *MODELS[name], site) for name, each in made.pop("$defs").items()}
    for table, choice in (("Search", NumberChoice), ("Tolerances", GivenTolerance)):
        reads = _Reads(table.lower(), choice, sizes=table == "Tolerances", site=site)
        for name in ("cam", "follower", "drive", "materials"):
            tables[table]["properties"][name] |= reads.numbers(TABLES[name], name)
        rows = {"additionalProperties": False, "patternProperties": {ROW: reads.numbers(TABLES["train"], "train")}}
        tables[table]["properties"]["train"] |= rows
    tables["NumberRange"] = _described(_shaped(NumberRange.model_json_schema()), "search.KEY", NumberRange, site)
    top = _described(_shaped(made), *MODELS["Scene"], site)
    about = {"$schema": DIALECT, "title": "camopt scene"}
    known = {"properties": dict.fromkeys(tables["Limits"]["properties"], True), "additionalProperties": False}
    top |= {"if": {"required": ["quantities"]}, "else": {"properties": {"limits": known}}}  # others are of its own
    return {**about, **top, "description": "A cam, its follower, and what is asked of them.", "definitions": tables}


def table_schema(place: str) -> dict[str, Any]:
    """What the keys of a table allow, by key."""
    made = _made()
    table = made if place == "" else made["$defs"][TABLES[place].__name__]
    properties: dict[str, Any] = _shaped(table)["properties"]
    return properties


@cache
def _made() -> dict[str, Any]:
    """What pydantic makes of the tables, which takes it a tenth of a second."""
    return Scene.model_json_schema()


def _shaped(schema: Any) -> Any:
    """What pydantic makes, in the words of the dialect, and as TOML has it: without nulls."""
    if isinstance(schema, list):
        return [_shaped(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        return {"$ref": schema["$ref"].replace("$defs", "definitions")}
    found = {BOUNDS.get(key, key): _shaped(value) for key, value in schema.items() if key != "title"}
    found |= (
        {"properties": {k: _shaped(v) for k, v in schema["properties"].items()}} if "properties" in schema else {}
    )
    if found.get("default", found) in (None, [], {}):
        del found["default"]
    if rows := found.pop("prefixItems", None):
        found["items"] = rows[0]
    if found.get("type") == "number":
        bounds = {key: found.pop(key) for key in ("type", *BOUNDS.values()) if key in found}
        return {"anyOf": [bounds, WITH_UNIT], **found}
    kinds = [kind for kind in found.pop("anyOf", found.pop("oneOf", [])) if kind != {"type": "null"}]
    if len(kinds) == 1:
        return kinds[0] | found
    return found | ({"anyOf": [each for kind in kinds for each in kind.get("anyOf", [kind])]} if kinds else {})


def _described(schema: dict[str, Any], place: str, model: type[SceneTable], site: str) -> dict[str, Any]:
    """A table whose keys say what the code says of them."""
    if "description" in schema:
        schema["description"] = schema["description"].split("\n\n")[0].replace("\n", " ")
    for name, each in schema["properties"].items():
        _describe(each, model, name, f"{place}.{name}" if place else name, site)
    return schema


def _describe(schema: dict[str, Any], model: type[SceneTable], name: str, key: str, site: str) -> None:
    """Text, unit and link of a key."""
    if target := schema.pop("$ref", None):  # what stands beside a reference is not read
        schema["allOf"] = [{"$ref": target}]
    record = key_of(model, name)
    schema["description"] = f"{record.sentence}. Unit: {record.units}." if record.units else f"{record.sentence}."
    if site:
        page = f"{site}/reference/{'limits' if key.startswith('limits.') else 'scene'}.html#key-{key}"
        schema["description"] += f" [Reference]({page})"
        schema["x-taplo"] = {"links": {"key": page}}


class _Reads(NamedTuple):
    """A table that has something of numbers of other ones."""

    place: str
    what: Any
    """The type of what it has of a number."""
    sizes: bool
    """Whether of sizes too."""
    site: str

    def numbers(self, table: type[SceneTable], place: str) -> dict[str, Any]:
        """The numbers of another table as it takes them."""
        choice = _shaped(TypeAdapter(self.what).json_schema())
        properties: dict[str, Any] = {}
        for name, inner in numbers_of(table, sizes=self.sizes).items():
            nested = isinstance(inner, type) and issubclass(inner, SceneTable)
            properties[name] = self.numbers(inner, f"{place}.{name}") if nested else {"anyOf": [*choice["anyOf"]]}
            _describe(properties[name], table, name, f"{place}.{name}", self.site)
        return {"type": "object", "additionalProperties": False, "properties": properties}

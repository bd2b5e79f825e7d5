"""The JSON Schema of scenes, made from the tables and the records of their keys, for editors of TOML."""

from functools import cache
from typing import Any

from pydantic import TypeAdapter

from camopt.core.storage.version import SITE
from camopt.scene.choices import NumberChoice, NumberRange, searchable_number_types
from camopt.scene.scene import SCENE_TABLES, Scene
from camopt.scene.table_places import key_record
from camopt.scene.tables import SceneTable
from camopt.scene.tolerances import GivenTolerance

DIALECT = "http://json-schema.org/draft-07/schema#"
"""The draft that every linter reads; the schema needs no later one."""
SCHEMA_BOUNDS = {"ge": "minimum", "le": "maximum", "lt": "exclusiveMaximum", "gt": "exclusiveMinimum"}
UNIT_TEXT_SCHEMA = {"type": "string", "pattern": r"^\s*[-+]?[0-9]+(\.[0-9]+)?(e[-+]?[0-9]+)?\s*(1/)?[a-zA-Zµ°%]"}
"""A number with a unit, allowed in place of a number."""
ROW_PATTERN = "^[1-9][0-9]*$"
"""The number of a row, as a key in ``[search]``."""
MODELS_BY_NAME = {model.__name__: (place, model) for place, model in SCENE_TABLES.items()}


def scene_schema(site: str = SITE) -> dict[str, Any]:
    """The JSON schema of a whole scene; with a ``site``, keys link to the reference there."""
    schema = dict(_pydantic_schema())
    tables = {
        name: _add_key_descriptions(_convert_schema_dialect(each), *MODELS_BY_NAME[name], site)
        for name, each in schema.pop("$defs").items()
    }
    for table, choice in (("Search", NumberChoice), ("Tolerances", GivenTolerance)):
        own: dict[str, Any] = {"value_type": choice, "sizes": table == "Tolerances", "site": site}
        for name in ("cam", "follower", "drive", "materials"):
            tables[table]["properties"][name] |= _numbers_schema(SCENE_TABLES[name], name, **own)
        rows = {ROW_PATTERN: _numbers_schema(SCENE_TABLES["train"], "train", **own)}
        tables[table]["properties"]["train"] |= {"additionalProperties": False, "patternProperties": rows}
    tables["NumberRange"] = _add_key_descriptions(
        _convert_schema_dialect(NumberRange.model_json_schema()), "search.KEY", NumberRange, site
    )
    top = _add_key_descriptions(_convert_schema_dialect(schema), *MODELS_BY_NAME["Scene"], site)
    known = {"properties": dict.fromkeys(tables["Limits"]["properties"], True), "additionalProperties": False}
    top |= {"if": {"required": ["quantities"]}, "else": {"properties": {"limits": known}}}  # else only known limits
    return {
        "$schema": DIALECT,
        "title": "camopt scene",
        **top,
        "description": "A cam, its follower, their motion and their limits.",
        "definitions": tables,
    }


def table_schema(table_class: type[SceneTable], top_table: type[SceneTable] = Scene) -> dict[str, Any]:
    """The JSON schemas of the keys of a table in a scene, or in a machine (``top_table``), by key."""
    schema = _pydantic_schema(top_table)
    table = schema if table_class is top_table else schema["$defs"][table_class.__name__]
    properties: dict[str, Any] = _convert_schema_dialect(table)["properties"]
    return properties


@cache
def _pydantic_schema(top_table: type[SceneTable] = Scene) -> dict[str, Any]:
    """Pydantic's schema of a scene or a machine, cached since it takes a tenth of a second."""
    return top_table.model_json_schema()


def _convert_schema_dialect(schema: Any) -> Any:
    """Pydantic's schema in the draft of ``DIALECT``, without null, which TOML does not have."""
    if isinstance(schema, list):
        return [_convert_schema_dialect(each) for each in schema]
    if not isinstance(schema, dict):
        return schema
    if "$ref" in schema:
        return {"$ref": schema["$ref"].replace("$defs", "definitions")}
    result = {
        SCHEMA_BOUNDS.get(key, key): _convert_schema_dialect(value)
        for key, value in schema.items()
        if key != "title"
    }
    result |= (
        {"properties": {k: _convert_schema_dialect(v) for k, v in schema["properties"].items()}}
        if "properties" in schema
        else {}
    )
    if result.get("default", result) in (None, [], {}):
        del result["default"]
    if rows := result.pop("prefixItems", None):
        result["items"] = rows[0]
    if result.get("type") == "number":
        bounds = {key: result.pop(key) for key in ("type", *SCHEMA_BOUNDS.values()) if key in result}
        return {"anyOf": [bounds, UNIT_TEXT_SCHEMA], **result}
    kinds = [kind for kind in result.pop("anyOf", result.pop("oneOf", [])) if kind != {"type": "null"}]
    if len(kinds) == 1:
        return kinds[0] | result
    return result | ({"anyOf": [each for kind in kinds for each in kind.get("anyOf", [kind])]} if kinds else {})


def _add_key_descriptions(schema: dict[str, Any], place: str, model: type[SceneTable], site: str) -> dict[str, Any]:
    """Add the sentences, units and links of the keys of a table."""
    if "description" in schema:
        schema["description"] = schema["description"].split("\n\n")[0].replace("\n", " ").replace("``", "`")
    for name, each in schema["properties"].items():
        _add_key_description(each, model, name, f"{place}.{name}" if place else name, site)
    return schema


def _add_key_description(schema: dict[str, Any], model: type[SceneTable], name: str, key: str, site: str) -> None:
    """Add the sentence, unit and link of a key."""
    if target := schema.pop("$ref", None):  # readers ignore keys beside a $ref
        schema["allOf"] = [{"$ref": target}]
    record = key_record(model, name)
    schema["description"] = (
        f"{record.sentence}. Unit: {record.both_units_text}." if record.both_units_text else f"{record.sentence}."
    )
    if site:
        page = f"{site}/reference/{'limits' if key.startswith('limits.') else 'scene'}.html#key-{key}"
        schema["description"] += f" [Reference]({page})"
        schema["x-taplo"] = {"links": {"key": page}}


def _numbers_schema(
    table: type[SceneTable], place: str, *, value_type: Any, sizes: bool, site: str
) -> dict[str, Any]:
    """The schema of values for the numbers of a table, in a table such as ``[search]``.

    ``value_type`` is the type of a value; ``sizes`` says whether sizes have values here too.
    """
    choice = _convert_schema_dialect(TypeAdapter(value_type).json_schema())
    properties: dict[str, Any] = {}
    for name, inner in searchable_number_types(table, sizes=sizes).items():
        key = f"{place}.{name}"
        if isinstance(inner, type) and issubclass(inner, SceneTable):
            properties[name] = _numbers_schema(inner, key, value_type=value_type, sizes=sizes, site=site)
        else:
            properties[name] = {"anyOf": [*choice["anyOf"]]}
        _add_key_description(properties[name], table, name, key, site)
    return {"type": "object", "additionalProperties": False, "properties": properties}

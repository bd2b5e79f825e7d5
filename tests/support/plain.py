"""Values that are plain Python: numpy's are no JSON, or only some of them are."""

PLAIN = {dict, list, tuple, str, float, int, bool, type(None)}


def places_of_objects(value, where="document"):
    """The places of values whose type is no plain one."""
    if type(value) not in PLAIN:
        return [f"{where}: {type(value).__name__}"]
    inner = (
        value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, (list, tuple)) else ()
    )
    return [each for key, part in inner for each in places_of_objects(part, f"{where}.{key}")]

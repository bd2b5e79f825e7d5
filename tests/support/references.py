"""Cams with every quantity as another program has it: the sources' cams to 30 digits, and one of each mechanism and
law to 50 (``tests/data/make_reference.py``)."""

import json
from math import inf, isinf
from pathlib import Path

DATA = Path(__file__).parents[1] / "data"
REFERENCE = {entry["id"]: entry for entry in json.loads((DATA / "reference.json").read_text())}
WORKED = json.loads((DATA / "worked-examples.json").read_text())

# A few references are small differences of large numbers: the error is relative to the larger partner.
PARTNER = {
    "pitch_curvature_min_per_mm": "pitch_curvature_max_per_mm",
    "pitch_curvature_max_per_mm": "pitch_curvature_min_per_mm",
    "profile_radius_min_mm": "roller_radius_mm",
    "face_reach_min_mm": "face_reach_max_mm",
    "face_reach_max_mm": "face_reach_min_mm",
}


def relative_error(found, name, expected):
    """Of a quantity of an evaluation; infinite where a verdict is another."""
    if isinstance(expected, bool):
        return 0.0 if found[name] is expected else inf
    value = float(expected)
    if isinf(value):
        return 0.0 if found[name] == value else inf
    partner = abs(found.get(PARTNER.get(name, name), 0.0))
    scale = max(abs(value), partner if partner < inf else 0.0)
    return abs(found[name] - value) / scale if scale else abs(found[name])

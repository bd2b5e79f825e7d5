"""The summary of a sweep in its manifest, for repeated questions: counts, and some designs."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from math import isinf
from typing import Any

from camopt.front.pareto import Front
from camopt.quantities import QUANTITIES
from camopt.scene.scene import Scene
from camopt.tables.designs import ByLaw, Design
from camopt.verdicts.judging import Effort

KEPT_FIELDS: dict[str, Any] = {
    **dict.fromkeys(("impossible", "feasible"), int | None),
    **dict.fromkeys(("pareto", "evaluated", "boxes", "decided_by_boxes"), int),
    "reached": float | int,
    "every_cam": dict | None,
    "obstacle": str,
}
"""Fields that are kept as they are, and of which types they are."""


def summary_of(result: Any) -> dict[str, Any]:
    """The summary of a ``Sweep`` as plain values for JSON."""
    front, miss = result.front, result.nearest_miss
    return {
        **{name: getattr(result, name) for name in KEPT_FIELDS},
        "effort": [*result.effort],
        "best": {laws: _plain(design) for laws, design in result.best.items()},
        "nearest_miss": miss and [_plain(miss), miss.searched.to_toml()],
        "front": front and {**asdict(replace(front, knee={})), "knee": _plain(front.knee)},
    }


def from_summary(told: Mapping[str, Any], scene: Scene) -> dict[str, Any]:
    """The same as fields of a ``Sweep``; an error of some kind if it was not ``summary_of`` one."""
    front, miss = told["front"], told["nearest_miss"]
    if not all(isinstance(told[name], kind) for name, kind in KEPT_FIELDS.items()):
        raise TypeError
    return {
        **{name: told[name] for name in KEPT_FIELDS},
        "effort": Effort(*told["effort"]),
        "best": ByLaw((laws, _design(row, scene)) for laws, row in told["best"].items()),
        "nearest_miss": miss and _design(miss[0], Scene.embedded(miss[1], scene.file)),
        "front": front and Front(**{**front, "knee": _design(front["knee"], scene)}),
    }


def _plain(row: Mapping[str, Any]) -> dict[str, Any]:
    """A row with texts for infinite values, for which JSON has no numbers."""
    return {name: str(value) if isinstance(value, float) and isinf(value) else value for name, value in row.items()}


def _design(row: Mapping[str, Any], scene: Scene) -> Design:
    def value_of(name: str, value: Any) -> Any:
        known = name in scene.quantities or (name in QUANTITIES and QUANTITIES[name].kind is float)
        return float(value) if known else value

    return Design({name: value_of(name, value) for name, value in row.items()}, scene)

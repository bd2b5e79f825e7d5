"""The table ``[search]`` of a scene: what may vary, and the objectives."""

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from camopt.scene.choices import Choice, NumberRange, Range, free_numbers
from camopt.scene.tables import (
    Cam,
    Follower,
    LawName,
    Materials,
    Number,
    Quantities,
    Switch,
    Table,
    as_list,
    is_whole,
)

Laws = Annotated[tuple[LawName, ...], Field(min_length=1), BeforeValidator(as_list)]
MOST_SAMPLES, MOST_SEED = 2**22, 2**32 - 1  # 32 MB a size


class Search(Table):
    """What a sweep or an optimisation may vary, and its objectives. A size is a Range or a list of values.

    ``cam``, ``follower`` and ``materials`` hold other numbers of these tables, by the keys that they have in the
    scene, each a NumberRange or a list: a sweep combines their values with all sizes and laws.

    With ``samples`` a sweep takes so many designs, the same for each law, in place of a grid: drawn evenly from the
    ranges and lists by a ``sampler``, always the same ones for a ``seed``.

    ``thin`` is the share of each objective's range that rows left out of the front may be away from those kept;
    ``refine`` moves each row of the front off the grid, to an optimum of the continuous problem.
    ``angle_rise``, ``angle_return`` and ``angle_dwell`` free the angle (deg) of every segment of a kind within a
    Range: an optimisation shares out among freed segments the degrees that they have together in the scene.
    """

    elsewhere: ClassVar[Mapping[str, str]] = {
        "motion": "the motion is that of all designs; only its laws and angles vary: search.law, search.angle_rise",
        "limits": "limits are the same for all designs; objectives (search.minimise) show what a limit costs",
    }

    base_radius: Choice = None
    mean_radius: Choice = None
    offset: Choice = None
    roller_radius: Choice = None
    face_radius: Choice = None
    arm_length: Choice = None
    centre_distance: Choice = None
    face_offset: Choice = None
    law: Laws = ()
    law_rise: Laws = ()
    law_return: Laws = ()
    angle_rise: Range | None = None
    angle_return: Range | None = None
    angle_dwell: Range | None = None
    cam: Annotated[dict[str, Any], BeforeValidator(partial(free_numbers, Cam))] = Field(default_factory=dict)
    follower: Annotated[dict[str, Any], BeforeValidator(partial(free_numbers, Follower))] = Field(
        default_factory=dict
    )
    materials: Annotated[dict[str, Any], BeforeValidator(partial(free_numbers, Materials))] = Field(
        default_factory=dict
    )
    samples: Annotated[int, BeforeValidator(is_whole), Field(ge=1, le=MOST_SAMPLES)] | None = None
    sampler: Literal["sobol", "latin-hypercube"] = "sobol"
    seed: Annotated[int, BeforeValidator(is_whole), Field(ge=0, le=MOST_SEED)] = 0
    minimise: Quantities = ()
    maximise: Quantities = ()
    thin: Annotated[Number, Field(ge=1e-9, lt=1)] | None = None
    refine: Switch = False

    def angle_of(self, segment: str) -> Range | None:
        """The range of the angle of a rise, dwell or return; None where it stays as it is."""
        found: Range | None = getattr(self, f"angle_{segment}", None)
        return found

    @property
    def numbers(self) -> dict[str, NumberRange | tuple[float, ...]]:
        """The choices for numbers that are no sizes, by key of the scene, as ``cam.rpm``."""
        tables = {name: getattr(self, name) for name in ("cam", "follower", "materials")}
        return dict(sorted(_flat("", tables)))


def _flat(prefix: str, tables: dict[str, Any]) -> Iterator[tuple[str, Any]]:
    """The values of nested tables by dotted key."""
    for key, value in tables.items():
        if isinstance(value, dict):
            yield from _flat(f"{prefix}{key}.", value)
        else:
            yield f"{prefix}{key}", value

"""The table ``[search]`` of a scene: what may vary, and the objectives."""

from collections.abc import Mapping
from functools import partial
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from camopt.core.quantities.key import Key
from camopt.model.mechanisms import SECOND_FIELDS
from camopt.scene.choices import (
    CheckedChoice,
    Choice,
    NumberRange,
    StepRange,
    read_number_choices,
    read_row_choices,
)
from camopt.scene.mapping import leaf_values_by_key
from camopt.scene.sizes import SEARCH_SIZES
from camopt.scene.tables import (
    BoundedNumber,
    Cam,
    Drive,
    Follower,
    InnerTable,
    LawName,
    ListOrItem,
    Materials,
    QuantityNames,
    SceneTable,
    Switch,
    check_whole_number,
    single_value_as_list,
)
from camopt.scene.train import TrainStage

Laws = Annotated[tuple[LawName, ...], Field(min_length=1), ListOrItem(single_value_as_list)]
MOST_SAMPLES, MOST_SEED = 2**22, 2**32 - 1  # 32 MB a size


class Search(SceneTable):
    """What a sweep or an optimisation may vary, and its objectives.

    Each size is a range or a list of values. ``cam``, ``follower``, ``drive``, ``train`` and ``materials`` hold
    ranges or lists for other numbers, by their keys in the scene; a key of a train starts with the number of the
    stage, as in ``train.1.coupler``. A sweep combines all values with all laws.

    With ``samples`` a sweep draws designs evenly from the ranges and lists, in place of a grid. It uses the same
    designs for each law, and a ``seed`` always gives the same designs.

    ``thin`` shortens the front. For each row that it drops, a row stays that costs at most this share of the range
    more in any objective; in some objectives it may cost far less.

    An optimisation may vary the angles of segments. It redistributes the degrees that these segments have together
    in the scene.
    """

    elsewhere: ClassVar[Mapping[str, str]] = {
        "motion": "all designs have one motion; only its laws and angles vary: search.law, search.angle_rise",
        "limits": "all designs have the same limits; an objective (search.minimise) shows what a limit costs",
    }

    base_radius: Annotated[Choice, Key("Base radii of a disc cam", "mm")] = None
    mean_radius: Annotated[Choice, Key("Mean radii of a cylindrical cam", "mm")] = None
    offset: Annotated[Choice, Key("Offsets of a translating follower's axis", "mm")] = None
    roller_radius: Annotated[Choice, Key("Radii of the roller", "mm")] = None
    face_radius: Annotated[Choice, Key("Radii of a spherical face", "mm")] = None
    arm_length: Annotated[Choice, Key("Lengths of the arm", "mm")] = None
    centre_distance: Annotated[Choice, Key("Distances from the pivot to the cam's axis", "mm")] = None
    face_offset: Annotated[Choice, Key("Distances of an oscillating flat face from its pivot", "mm")] = None
    roller_spacing: Annotated[Choice, Key("Centre distances of the two rollers on either side of a rib", "mm")] = (
        None
    )
    law: Annotated[Laws, Key("Motion laws to try, each on rises and returns")] = ()
    law_rise: Annotated[Laws, Key("Motion laws to try on rises, each with every law of `law_return`")] = ()
    law_return: Annotated[Laws, Key("Motion laws to try on returns, each with every law of `law_rise`")] = ()
    angle_rise: Annotated[InnerTable[StepRange] | None, Key("Range for the angle of each rise", "deg")] = None
    angle_return: Annotated[InnerTable[StepRange] | None, Key("Range for the angle of each return", "deg")] = None
    angle_dwell: Annotated[InnerTable[StepRange] | None, Key("Range for the angle of each dwell", "deg")] = None
    cam: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Cam)),
        Key("Other numbers of `[cam]` that vary, such as `rpm`"),
    ] = Field(default_factory=dict)
    follower: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Follower)),
        Key("Other numbers of `[follower]` and `[follower.dynamics]` that vary"),
    ] = Field(default_factory=dict)
    drive: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Drive)),
        Key("Sizes and other numbers of `[drive]` that vary"),
    ] = Field(default_factory=dict)
    materials: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Materials)),
        Key("Numbers of `[materials]` that vary"),
    ] = Field(default_factory=dict)
    train: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_row_choices, TrainStage)),
        Key("Numbers of `[[train]]` that vary, by number of the stage"),
    ] = Field(default_factory=dict)
    samples: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=1, le=MOST_SAMPLES)] | None,
        Key("Number of designs that a sweep draws for each law, in place of a grid"),
    ] = None
    sampler: Annotated[Literal["sobol", "latin-hypercube"], Key("Method of drawing the designs of `samples`")] = (
        "sobol"
    )
    seed: Annotated[
        int,
        BeforeValidator(check_whole_number),
        Field(ge=0, le=MOST_SEED),
        Key("Seed of the random draw; another seed draws other designs"),
    ] = 0
    minimise: Annotated[QuantityNames, Key("Quantities to minimise: the objectives of the Pareto front")] = ()
    maximise: Annotated[QuantityNames, Key("Quantities to maximise: further objectives of the Pareto front")] = ()
    thin: Annotated[
        Annotated[float, BoundedNumber(ge=1e-9, lt=1)] | None,
        Key(
            "Shorten the front: drop a row if another row stays that costs at most this share of the "
            "range more in every objective",
            "no unit",
        ),
    ] = None
    robust: Annotated[
        Switch, Key("Whether every cam within the tolerances must meet the limits, not only the nominal cam")
    ] = False
    refine: Annotated[
        Switch, Key("Whether to move each row of the front off the grid, to an optimum between grid values")
    ] = False

    @property
    def angles(self) -> dict[str, StepRange]:
        """The given ranges of the angles of rises, returns and dwells, by kind of segment."""
        kinds = {"rise": self.angle_rise, "return": self.angle_return, "dwell": self.angle_dwell}
        return {kind: ends for kind, ends in kinds.items() if ends is not None}

    @property
    def objectives(self) -> dict[str, float]:
        """The objectives, each with the sign that makes it a cost: 1 if minimised, −1 if maximised."""
        return dict.fromkeys(self.minimise, 1.0) | dict.fromkeys(self.maximise, -1.0)

    @property
    def sizes(self) -> dict[str, CheckedChoice]:
        """The given choices for sizes, by key."""
        first = {key: choice for key in SEARCH_SIZES if (choice := getattr(self, key)) is not None}
        return first | {key: each for key, each in self.choices_by_key.items() if key in SECOND_FIELDS}

    @property
    def numbers(self) -> dict[str, NumberRange | tuple[float, ...]]:
        """The choices for other numbers, by key of the scene such as ``cam.rpm``."""
        return {key: each for key, each in self.choices_by_key.items() if key not in SECOND_FIELDS}

    @property
    def choices_by_key(self) -> dict[str, Any]:
        """The choices in inner tables, by key of the scene."""
        tables = {name: getattr(self, name) for name in ("cam", "follower", "drive", "materials", "train")}
        return dict(sorted(leaf_values_by_key(tables)))


def nest_dotted_keys(search: Any) -> Any:
    """The table with dotted keys, such as ``"train.1.coupler"`` in ``[search]``, as inner tables."""
    if not isinstance(search, dict):
        return search
    nested = {key: value for key, value in search.items() if "." not in key}
    for key in (each for each in search if each not in nested):
        *tables, last = key.split(".")
        table: Any = nested
        for name in tables:
            table = table.setdefault(name, {}) if isinstance(table, dict) else None
        if isinstance(table, dict) and last not in table:
            table[last] = search[key]
        else:  # a key given twice stays dotted, and the check of unknown keys reports it
            nested[key] = search[key]
    return nested

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
from camopt.scene.mapping import leaves
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
    as_list,
    check_whole_number,
)
from camopt.scene.train import TrainStage

Laws = Annotated[tuple[LawName, ...], Field(min_length=1), ListOrItem(as_list)]
MOST_SAMPLES, MOST_SEED = 2**22, 2**32 - 1  # 32 MB a size


class Search(SceneTable):
    """What a sweep or an optimisation may vary, and its objectives. A size is a range or a list of values.

    ``cam``, ``follower``, ``drive``, ``train`` and ``materials`` hold other numbers by the keys that they have in
    the scene, each a range or a list: a sweep combines their values with all sizes and laws. Of ``train`` the
    number of the stage comes first, as in ``train.1.coupler``.

    With ``samples`` a sweep takes the same designs for each law: drawn evenly from the ranges and lists, always
    the same ones for a ``seed``. With ``thin``, for each row that is left out of the front one stays that costs
    at most that share more, in every objective; it may cost far less in some. An optimisation shares out among
    segments whose angles are freed the degrees that they have together in the scene.
    """

    elsewhere: ClassVar[Mapping[str, str]] = {
        "motion": "the motion is that of all designs; only its laws and angles vary: search.law, search.angle_rise",
        "limits": "limits are the same for all designs; objectives (search.minimise) show what a limit costs",
    }

    base_radius: Annotated[Choice, Key("Base radii of a disc cam", "mm")] = None
    mean_radius: Annotated[Choice, Key("Mean radii of a cylindrical cam", "mm")] = None
    offset: Annotated[Choice, Key("Offsets", "mm")] = None
    roller_radius: Annotated[Choice, Key("Radii of the roller", "mm")] = None
    face_radius: Annotated[Choice, Key("Radii of a spherical face", "mm")] = None
    arm_length: Annotated[Choice, Key("Lengths of the arm", "mm")] = None
    centre_distance: Annotated[Choice, Key("Distances from the pivot to the cam's axis", "mm")] = None
    face_offset: Annotated[Choice, Key("Distances of an oscillating flat face from its pivot", "mm")] = None
    roller_spacing: Annotated[Choice, Key("Distances of the centres of two rollers about a rib", "mm")] = None
    law: Annotated[Laws, Key("Motion laws to try, each on rises and returns alike")] = ()
    law_rise: Annotated[Laws, Key("Motion laws to try on rises, with each of ``law_return``")] = ()
    law_return: Annotated[Laws, Key("Motion laws to try on returns")] = ()
    angle_rise: Annotated[InnerTable[StepRange] | None, Key("Range for the angle of each rise", "deg")] = None
    angle_return: Annotated[InnerTable[StepRange] | None, Key("Range for the angle of each return", "deg")] = None
    angle_dwell: Annotated[InnerTable[StepRange] | None, Key("Range for the angle of each dwell", "deg")] = None
    cam: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Cam)),
        Key("Other numbers of ``[cam]`` that vary, such as ``rpm``"),
    ] = Field(default_factory=dict)
    follower: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Follower)),
        Key("Other numbers of ``[follower]`` and ``[follower.dynamics]`` that vary"),
    ] = Field(default_factory=dict)
    drive: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Drive)),
        Key("Sizes and other numbers of ``[drive]`` that vary"),
    ] = Field(default_factory=dict)
    materials: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_number_choices, Materials)),
        Key("Numbers of ``[materials]`` that vary"),
    ] = Field(default_factory=dict)
    train: Annotated[
        dict[str, Any],
        BeforeValidator(partial(read_row_choices, TrainStage)),
        Key("Numbers of ``[[train]]`` that vary, by the number of the stage"),
    ] = Field(default_factory=dict)
    samples: Annotated[
        Annotated[int, BeforeValidator(check_whole_number), Field(ge=1, le=MOST_SAMPLES)] | None,
        Key("How many designs a sweep draws for each law, in place of a grid"),
    ] = None
    sampler: Annotated[Literal["sobol", "latin-hypercube"], Key("How the designs of ``samples`` are drawn")] = (
        "sobol"
    )
    seed: Annotated[
        int,
        BeforeValidator(check_whole_number),
        Field(ge=0, le=MOST_SEED),
        Key("Number of the draw: another one draws other designs"),
    ] = 0
    minimise: Annotated[QuantityNames, Key("Names of quantities that a Pareto front minimises")] = ()
    maximise: Annotated[QuantityNames, Key("Names of quantities that a Pareto front maximises")] = ()
    thin: Annotated[
        Annotated[float, BoundedNumber(ge=1e-9, lt=1)] | None,
        Key(
            "What a row that stays in the front costs at most more than one left out, as a share of "
            "an objective's range",
            "no unit",
        ),
    ] = None
    robust: Annotated[
        Switch, Key("Whether every cam within the tolerances has to hold the limits, not the nominal one alone")
    ] = False
    refine: Annotated[
        Switch, Key("Move each row of the front off the grid, to an optimum of the continuous problem")
    ] = False

    @property
    def angles(self) -> dict[str, StepRange]:
        """The ranges of the angles of rises, returns and dwells, by kind of segment; those that are given."""
        kinds = {"rise": self.angle_rise, "return": self.angle_return, "dwell": self.angle_dwell}
        return {kind: ends for kind, ends in kinds.items() if ends is not None}

    @property
    def objectives(self) -> dict[str, float]:
        """The objectives, and the sign that turns each into a cost: 1 if minimised, −1 if maximised."""
        return dict.fromkeys(self.minimise, 1.0) | dict.fromkeys(self.maximise, -1.0)

    @property
    def sizes(self) -> dict[str, CheckedChoice]:
        """The choices for sizes, by key; those that are given."""
        first = {key: choice for key in SEARCH_SIZES if (choice := getattr(self, key)) is not None}
        return first | {key: each for key, each in self.choices_by_key.items() if key in SECOND_FIELDS}

    @property
    def numbers(self) -> dict[str, NumberRange | tuple[float, ...]]:
        """The choices for numbers that are no sizes, by key of the scene, as ``cam.rpm``."""
        return {key: each for key, each in self.choices_by_key.items() if key not in SECOND_FIELDS}

    @property
    def choices_by_key(self) -> dict[str, Any]:
        """The choices in tables, by key of the scene."""
        tables = {name: getattr(self, name) for name in ("cam", "follower", "drive", "materials", "train")}
        return dict(sorted(leaves(tables)))


def nest_dotted_keys(search: Any) -> Any:
    """A table with tables in place of keys that lead to them, as ``"train.1.coupler"`` does in ``[search]``."""
    if not isinstance(search, dict):
        return search
    found = {key: value for key, value in search.items() if "." not in key}
    for key in (each for each in search if each not in found):
        *tables, last = key.split(".")
        table: Any = found
        for name in tables:
            table = table.setdefault(name, {}) if isinstance(table, dict) else None
        if isinstance(table, dict) and last not in table:
            table[last] = search[key]
        else:  # given twice, which is told
            found[key] = search[key]
    return found

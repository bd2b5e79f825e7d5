"""Options of the command line: those that commands share, and what they change in a scene."""

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import wraps
from pathlib import Path
from types import MappingProxyType
from typing import Any

import click

import camopt
from camopt import cli, library
from camopt.core.mistakes import BadInput, Mistake
from camopt.core.quantities.unit_systems import SYSTEMS, shown_in
from camopt.core.storage.files import check_writable, checked_suffix, path_of

DEFAULT_SCENE = "roller-1000rpm"
PICTURE_SUFFIXES = (".png", ".svg", ".pdf")
ANIMATION_SUFFIXES = (".gif", ".mp4", ".svg")


def output_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options common to all commands."""
    command = click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")(command)
    return click.option("--quiet", is_flag=True, help="Print no progress bar and no messages.")(
        units_option(command)
    )


class UnitNumber(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.4 on
    """A number in a unit, or a text with a unit of that kind, such as 0.25 in."""

    name = "float"

    def __init__(self, unit: str) -> None:
        self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        with suppress(ValueError):
            return float(value)
        try:
            return library.convert_text_to_unit(str(value), self.unit)
        except ValueError as trouble:
            self.fail(f"{value!r} must be {trouble}", param, ctx)


units_option = click.option(
    "--units",
    type=click.Choice(SYSTEMS),
    default=SYSTEMS[0],
    envvar="CAMOPT_UNITS",
    show_default=True,
    show_envvar=True,
    expose_value=False,
    callback=lambda context, option, units: context.with_resource(shown_in(units)),
    help="Units of what is shown, drawn and exported. JSON and Parquet stay as their names say.",
)


BARE_POINT = re.compile(r"[+-]?(\.\d+|\d+\.)")
"""A number that TOML does not read."""


class KeyValue(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.4 on
    """A key of the scene with a value as TOML has it; what is none is a text, and nothing clears the key."""

    name = "KEY=VALUE"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, Any]:
        key, equals, text = (part.strip() for part in value.partition("="))
        if not (key and equals):
            self.fail(f"{value!r} is not {self.name}", param, ctx)
        try:
            return key, tomllib.loads(f"value = {text}")["value"] if text else None
        except tomllib.TOMLDecodeError:
            if BARE_POINT.fullmatch(text):
                self.fail(f"{key} = {text}: TOML has digits on both sides of a point: {float(text)}", param, ctx)
            return key, text


OVERRIDE_KEYS = {
    "rpm": "cam.rpm",
    "max_pressure": "limits.pressure_angle",
    "max_pressure_return": "limits.pressure_angle_return",
    "min_curvature": "limits.curvature_radius",
    "relative_error": "accuracy.relative_error",
    "outputs": "outputs",
}


def option_spelling(name: str) -> str:
    """How a user writes an option."""
    return name if name.startswith("--") else f"--{name.replace('_', '-')}"


SCENE_OPTIONS = ("settings", "row", "rpm", "max_pressure", "max_pressure_return", "min_curvature", "relative_error")
OUTPUT_OPTIONS = ("outputs", "long", "units", "as_json", "quiet", "_click_default_help")


class Command(click.Command):
    """A command: its mistakes name its options in place of the library's parameters, and its help has groups.

    ``groups`` are headings with the names of the options under them.
    """

    def __init__(
        self, *given: Any, groups: Mapping[str, tuple[str, ...]] = MappingProxyType({}), **more: Any
    ) -> None:
        super().__init__(*given, **more)
        self.groups = groups

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the help of the options: those of the command first, then those that commands share."""
        options = [given for given in self.get_params(ctx) if isinstance(given, click.Option)]
        rows = {option.name: row for option in options if (row := option.get_help_record(ctx))}
        shared = {"Changes to the scene": SCENE_OPTIONS, "Output": OUTPUT_OPTIONS}
        groups = {
            heading: [rows.pop(name) for name in names if name in rows]
            for heading, names in {**self.groups, **shared}.items()
        }
        for heading, records in {"Options": [*rows.values()], **groups}.items():
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records)

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click does, but no option is told to be like the former name of another."""
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            former = {given.former for given in self.params if isinstance(given, RenamedOption)}
            like = [name for name in error.possibilities or () if name not in former]
            raise click.NoSuchOption(error.option_name, possibilities=like, ctx=error.ctx) from None

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except BadInput as error:
            written = {name: parameter_name(given) for given in self.params for name in _library_names(given)}
            raise BadInput(
                replace(m, key=written.get(m.key, m.key)) if m.file == "camopt" else m for m in error.mistakes
            ) from None


def parameter_name(given: click.Parameter) -> str:
    """What a command's help calls something that it takes."""
    return given.opts[0] if isinstance(given, click.Option) else given.human_readable_name.rstrip(".")


def _library_names(given: click.Parameter) -> tuple[str | None, str]:
    """What the library may call it: SCENE and --scene are a scene, whatever the command's function calls it."""
    return given.name, parameter_name(given).lower().removeprefix("--").replace("-", "_")


def refuse_without(option: str, others: dict[str, Any]) -> None:
    """BadInput for each of some options that mean nothing without another."""
    _refuse_options(f"belongs to {option}, which is not given", others)


def refuse_with(option: str, others: dict[str, Any]) -> None:
    """BadInput for each of some options that mean nothing with another."""
    _refuse_options(f"does not go with {option}", others)


def _refuse_options(why: str, others: dict[str, Any]) -> None:
    """BadInput for each option that is given."""
    given = {option_spelling(name): value for name, value in others.items() if value is not None}
    shown = {name: str(value) if isinstance(value, Path) else value for name, value in given.items()}
    shown |= {name: ", ".join(map(str, value)) for name, value in given.items() if isinstance(value, tuple)}
    if shown:
        raise BadInput([Mistake("camopt", name, value, why, bare=True) for name, value in shown.items()])


Changes = Mapping[str, tuple[str, Any]]
"""Changes by key, each from an option: the option and the value."""


def with_changes(scene: Any, changes: Changes) -> Any:
    """The scene with changes by key, each from an option; a mistake in one names the option.

    What an option says of a number holds for a search that varies it, too.
    """
    searched = {f"search.{key}": change for key, change in changes.items() if key in scene.search.numbers}
    with name_options_in_mistakes(changes := {**changes, **searched}):
        return scene.replace(**values_by_key(changes)) if changes else scene


def values_by_key(changes: Changes) -> dict[str, Any]:
    """The values by key."""
    return {key: value for key, (_, value) in changes.items()}


@contextmanager
def name_options_in_mistakes(changes: Changes) -> Iterator[None]:
    """Let a mistake in one of some changes name the option that it is from."""
    try:
        yield
    except BadInput as error:
        found: dict[str, Mistake] = {}
        for mistake in error.mistakes:
            key = next((key for key in changes if f"{mistake.key}.".startswith(f"{key}.")), None)
            option = changes[key][0] if key else ""
            if key and option.startswith("--set"):  # the key may lead into a table that it gives
                option += mistake.key[len(key) :]
            named = replace(mistake, file="camopt", key=option) if key else mistake
            found.setdefault(str(named), named)
        raise BadInput(found.values()) from None


def take_overrides(options: dict[str, Any]) -> dict[str, tuple[str, Any]]:
    """Take the overriding options out of all options: changes by key, each from an option."""
    given = {name: options.pop(name, None) for name in OVERRIDE_KEYS}
    changes = {
        OVERRIDE_KEYS[name]: (option_spelling(name), value) for name, value in given.items() if value is not None
    }
    for key, value in options.pop("settings", ()):
        option = f"--set {key}"
        if key in changes:
            why = f"is given by {changes[key][0]} already"
            raise BadInput([Mistake("camopt", option, value, why, bare=True)])
        changes[key] = option, value
    if given["max_pressure"] is not None:  # one limit on all strokes: the scene's own on returns is taken away
        changes.setdefault(OVERRIDE_KEYS["max_pressure_return"], (option_spelling("max_pressure"), None))
    return changes


class RenamedOption(click.Option):
    """An option that had another name in a former release, which is read still and shown nowhere."""

    def __init__(self, names: Sequence[str], former: str, **about: Any) -> None:
        super().__init__(names, **about)
        self.former = former

    def add_to_parser(self, parser: Any, ctx: click.Context) -> None:
        names = self.opts
        self.opts = [*names, self.former]
        super().add_to_parser(parser, ctx)
        self.opts = names


set_option = click.option(
    "--set",
    "settings",
    type=KeyValue(),
    multiple=True,
    help="Any key of the scene, such as follower.offset=5, motion.1.angle=90; KEY= clears it. Repeatable.",
)


def override_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options that override the scene."""
    for option in (
        click.option(
            "--relative-error",
            cls=RenamedOption,
            former="--tolerance",
            type=float,
            help="Largest relative error of each value.",
        ),
        click.option(
            "--min-curvature",
            type=UnitNumber("mm"),
            help="Least convex radius allowed on the profile, mm.",
        ),
        click.option("--max-pressure-return", type=float, help="Largest pressure angle allowed on returns, deg."),
        click.option("--max-pressure", type=float, help="Largest pressure angle allowed, deg."),
        click.option("--rpm", type=float, help="Speed of the cam, rev/min."),
        set_option,
    ):
        command = option(command)
    return command


def split_names(context: click.Context, option: click.Parameter, text: str | None) -> Any:
    """The names of an option that takes several, separated by commas."""
    return text and [name.strip() for name in text.split(",")]


outputs_option = click.option(
    "--outputs",
    callback=split_names,
    metavar="NAME,NAME|all",
    help="Quantities or effects to report beside sizes and limited ones, such as force,hertz, in place of the "
    "standard ones (`camopt effects` lists the effects); or all.",
)
row_option = click.option("--row", type=int, help="If a table is given: number of the row, from 0.")
again_option = click.option("--again", is_flag=True, help="Recompute, even if --out is up to date.")
former_again_option = click.option("--again", is_flag=True, hidden=True, expose_value=False)
"""What commands took that told an earlier result again: now each computes it anew."""


def scheduler_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """The option that says whose workers to use; the command gets the engine, None for this process and its own."""

    @wraps(command)
    def with_engine(scheduler: str | None, workers: int | None, **options: Any) -> Any:
        if scheduler is None:
            return command(engine=None, workers=workers, **options)
        with camopt.cluster(scheduler, workers) as engine:
            return command(engine=engine, workers=None, **options)

    return click.option(
        "--scheduler",
        metavar="ADDRESS|local",
        help="Use the workers of a Dask cluster (tcp://HOST:PORT), or of one that is started on this machine.",
    )(with_engine)


def scene_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options that override the scene; the command gets the scene itself."""

    @wraps(command)
    def with_scene(scene: str, row: int | None, **options: Any) -> Any:
        return command(scene=cli.read_scene(scene, row, take_overrides(options)), **options)

    return override_options(row_option(with_scene))


class Axis(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.4 on
    """START:STOP:STEP, START:STOP for a sample, or one value."""

    name = "START:STOP:STEP"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        try:
            numbers = [float(part) for part in str(value).split(":")]
        except ValueError:
            numbers = []
        if len(numbers) == 1:
            return numbers
        if len(numbers) not in (2, 3):
            self.fail(f"{value!r} is neither START:STOP:STEP nor one number", param, ctx)
        return dict(zip(("start", "stop", "step"), numbers, strict=False))


class PartNumber(click.ParamType):  # type: ignore[type-arg]
    """PART/PARTS, such as 3/100."""

    name = "I/N"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        part, slash, parts = value.partition("/")
        if not (slash and part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
            self.fail(f"{value!r} is not the number of a part and that of all parts, such as 3/100", param, ctx)
        return int(part), int(parts)


class SearchAxis(click.ParamType):  # type: ignore[type-arg]
    """A key of [search] with its axis: KEY=START:STOP:STEP, and as an axis else."""

    name = "KEY=START:STOP:STEP"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, Any]:
        key, equals, axis = value.partition("=")
        if not (key and equals):
            self.fail(f"{value!r} is not {self.name}", param, ctx)
        return key, Axis().convert(axis, param, ctx)


class OutputPath(click.ParamType):  # type: ignore[type-arg]
    """A path: of a folder or a file, or of a file that ends in one of some suffixes and can be written."""

    name = "path"

    def __init__(self, *suffixes: str) -> None:
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        try:
            path = path_of(value)
        except ValueError as trouble:
            self.fail(f"{value!r} must be {trouble}", param, ctx)
        if self.suffixes:
            checked_suffix(path, parameter_name(param) if param else "path", self.suffixes)
            check_writable(path)
        return path


def refuse_scene_file(own: str | None, out: Path, key: str = "--out") -> None:
    """A scene is never written over the user's own, if that is a file."""
    if own is not None and Path(own).exists() and out.exists() and out.samefile(own):
        raise BadInput([Mistake("camopt", key, str(out), "another file: this one is the scene itself")])


def refuse_scene_folder(scene: Any, out: Path, names: str = "scene.toml") -> None:
    """Scenes are written too (of such names); never over the user's own."""
    own = Path(scene.file)
    if own.exists() and any(file.samefile(own) for file in out.glob(names)):
        raise BadInput([Mistake("camopt", "--out", str(out), "another folder: this one holds the scene itself")])

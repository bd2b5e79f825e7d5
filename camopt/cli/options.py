"""Options that commands share, and the changes that options make to a scene."""

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
from camopt.core.quantities.unit_systems import SYSTEMS, shown_in, unit_in_shown_system
from camopt.core.storage.files import check_writable, checked_suffix, expand_user_path

DEFAULT_SCENE = "roller-1000rpm"
PICTURE_SUFFIXES = (".png", ".svg", ".pdf")
ANIMATION_SUFFIXES = (".gif", ".mp4", ".svg")


def output_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --json, --quiet and --units, which every command has."""
    command = click.option("--json", "as_json", is_flag=True, help="Print one JSON document.")(command)
    return click.option("--quiet", is_flag=True, help="Print no progress bar and no messages.")(
        units_option(command)
    )


class UnitNumber(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.4 on
    """A number, or a text with a unit such as "0.25 in"; converted to ``unit``.

    With ``--units inch`` a length must have its unit: a bare number could be either.
    """

    name = "float"

    def __init__(self, unit: str) -> None:
        self.unit = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        with suppress(ValueError):
            number, shown = float(value), unit_in_shown_system(self.unit)
            if shown == self.unit or not isinstance(value, str):
                return number
            self.fail(f"{value!r} must have its unit with --units inch: '{value} {shown}' or '{value} {self.unit}'")
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
    is_eager=True,
    callback=lambda context, option, units: context.with_resource(shown_in(units)),
    help="Units of tables, pictures and exported files. JSON and Parquet always use the units in their column "
    "names, such as mm in base_radius_mm.",
)


BARE_POINT = re.compile(r"[+-]?(\.\d+|\d+\.)")
"""A number without digits on one side of its point: TOML refuses it."""


class KeyValue(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.4 on
    """A key of the scene with a TOML value.

    A value that is not TOML is a text. An empty value clears the key.
    """

    name = "KEY=VALUE"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, Any]:
        key, equals, text = (part.strip() for part in value.partition("="))
        if not (key and equals):
            self.fail(f"{value!r} is not {self.name}", param, ctx)
        try:
            return key, tomllib.loads(f"value = {text}")["value"] if text else None
        except tomllib.TOMLDecodeError:
            if BARE_POINT.fullmatch(text):
                self.fail(
                    f"{key} = {text}: TOML needs digits on both sides of the point: {float(text)}", param, ctx
                )
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
    """An option as a user writes it: ``max_pressure`` is --max-pressure."""
    return name if name.startswith("--") else f"--{name.replace('_', '-')}"


SCENE_OPTIONS = ("settings", "row", "rpm", "max_pressure", "max_pressure_return", "min_curvature", "relative_error")
OUTPUT_OPTIONS = ("outputs", "long", "units", "as_json", "quiet", "_click_default_help")


class Command(click.Command):
    """A command whose help has groups, and whose mistakes name options, not parameters of the library.

    ``groups`` are headings with the names of the options under them.
    """

    def __init__(
        self, *args: Any, groups: Mapping[str, tuple[str, ...]] = MappingProxyType({}), **kwargs: Any
    ) -> None:
        super().__init__(*args, **kwargs)
        self.groups = groups

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the help of the options: first those of this command, then the shared ones."""
        options = [param for param in self.get_params(ctx) if isinstance(param, click.Option)]
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
        """Parse as click does, but never suggest the former name of an option."""
        try:
            return super().parse_args(ctx, args)
        except click.NoSuchOption as error:
            former = {param.former for param in self.params if isinstance(param, OptionWithFormerName)}
            similar = [name for name in error.possibilities or () if name not in former]
            raise click.NoSuchOption(error.option_name, possibilities=similar, ctx=error.ctx) from None

    def invoke(self, ctx: click.Context) -> Any:
        try:
            return super().invoke(ctx)
        except BadInput as error:
            spellings = {
                name: spelling  # the library names a parameter as its function does, or as the help (SCENE: scene)
                for param in self.params
                for spelling in (parameter_name_in_help(param),)
                for name in (param.name, spelling.lower().removeprefix("--").replace("-", "_"))
            }
            raise BadInput(
                replace(m, key=spellings.get(m.key, m.key)) if m.file == "camopt" else m for m in error.mistakes
            ) from None


def parameter_name_in_help(param: click.Parameter) -> str:
    """The name of an option or argument in the help of its command."""
    return param.opts[0] if isinstance(param, click.Option) else param.human_readable_name.rstrip(".")


def refuse_options_without(option: str, dependent_options: dict[str, Any]) -> None:
    """Raise BadInput for each option in ``dependent_options``: they mean nothing without ``option``."""
    _refuse_options(f"needs {option}", dependent_options)


def refuse_options_with(option: str, excluded_options: dict[str, Any]) -> None:
    """Raise BadInput for each option in ``excluded_options``: they mean nothing with ``option``."""
    _refuse_options(f"cannot be used with {option}", excluded_options)


def _refuse_options(why: str, refused_options: dict[str, Any]) -> None:
    """Raise BadInput for each option that has a value."""
    given = {option_spelling(name): value for name, value in refused_options.items() if value is not None}
    shown = {name: str(value) if isinstance(value, Path) else value for name, value in given.items()}
    shown |= {name: ", ".join(map(str, value)) for name, value in given.items() if isinstance(value, tuple)}
    if shown:
        raise BadInput([Mistake("camopt", name, value, why, bare=True) for name, value in shown.items()])


Changes = Mapping[str, tuple[str, Any]]
"""Changes to a scene: by key, the option that makes the change and the value."""


def scene_with_changes(scene: Any, changes: Changes) -> Any:
    """The scene with the changes of options. A mistake in a change names its option.

    If [search] varies the number of an option, the option replaces its range too.
    """
    searched = {f"search.{key}": change for key, change in changes.items() if key in scene.search.numbers}
    with name_options_in_mistakes(changes := {**changes, **searched}):
        return scene.replace(**changed_values_by_key(changes)) if changes else scene


def changed_values_by_key(changes: Changes) -> dict[str, Any]:
    """The value of each changed key."""
    return {key: value for key, (_, value) in changes.items()}


@contextmanager
def name_options_in_mistakes(changes: Changes) -> Iterator[None]:
    """Within the block, mistakes in changed keys name the options that changed them."""
    try:
        yield
    except BadInput as error:
        named_mistakes: dict[str, Mistake] = {}
        for mistake in error.mistakes:
            key = next((key for key in changes if f"{mistake.key}.".startswith(f"{key}.")), None)
            option = changes[key][0] if key else ""
            if key and option.startswith("--set"):  # the value may be a table, and the mistake in a key of it
                option += mistake.key[len(key) :]
            named = replace(mistake, file="camopt", key=option) if key else mistake
            named_mistakes.setdefault(str(named), named)
        raise BadInput(named_mistakes.values(), error.scene) from None


def pop_overrides_as_changes(options: dict[str, Any]) -> dict[str, tuple[str, Any]]:
    """Take the options that override the scene out of ``options``; return their changes by key."""
    given = {name: options.pop(name, None) for name in OVERRIDE_KEYS}
    changes = {
        OVERRIDE_KEYS[name]: (option_spelling(name), value) for name, value in given.items() if value is not None
    }
    for key, value in options.pop("settings", ()):
        option = f"--set {key}"
        if key in changes:
            raise BadInput([Mistake("camopt", option, value, f"is already set by {changes[key][0]}", bare=True)])
        changes[key] = option, value
    if given["max_pressure"] is not None:  # one limit for all strokes: it clears the scene's limit for returns
        changes.setdefault(OVERRIDE_KEYS["max_pressure_return"], (option_spelling("max_pressure"), None))
    return changes


class OptionWithFormerName(click.Option):
    """An option whose former name still works, but is in no help."""

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
    help="Set a key of the scene, such as follower.offset=5 or motion.1.angle=90; KEY= clears it. Repeatable.",
)


def override_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add the options that override keys of the scene."""
    for option in (
        click.option(
            "--relative-error",
            cls=OptionWithFormerName,
            former="--tolerance",
            type=float,
            help="Largest relative error of each value, such as 1e-6.",
        ),
        click.option(
            "--min-curvature",
            type=UnitNumber("mm"),
            help="Smallest radius of curvature allowed where the profile is convex, mm. It is a radius, "
            "not a curvature.",
        ),
        click.option("--max-pressure-return", type=float, help="Largest pressure angle allowed on returns, deg."),
        click.option("--max-pressure", type=float, help="Largest pressure angle allowed, deg."),
        click.option("--rpm", type=float, help="Speed of the cam, rev/min."),
        set_option,
    ):
        command = option(command)
    return command


def split_at_commas(context: click.Context, option: click.Parameter, text: str | None) -> Any:
    """The names of an option that takes names separated by commas."""
    return text and [name.strip() for name in text.split(",")]


outputs_option = click.option(
    "--outputs",
    callback=split_at_commas,
    metavar="NAME,NAME|all",
    help="Quantities or effects to report, such as force,hertz, or all; replaces the default ones. Sizes "
    "and limited "
    "quantities are always reported. `camopt effects` lists the effects.",
)
row_option = click.option("--row", type=int, help="Row of a table of designs, from 0.")
again_option = click.option("--again", is_flag=True, help="Recompute, even if --out is up to date.")
former_again_option = click.option("--again", is_flag=True, hidden=True, expose_value=False)
"""A former option of commands that now always recompute: it is accepted and does nothing."""


def scheduler_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --scheduler. The command gets the engine of that cluster, or None for this machine's own workers."""

    @wraps(command)
    def with_engine(scheduler: str | None, workers: int | None, **options: Any) -> Any:
        if scheduler is None:
            return command(engine=None, workers=workers, **options)
        with camopt.cluster(scheduler, workers) as engine:
            return command(engine=engine, workers=None, **options)

    return click.option(
        "--scheduler",
        metavar="ADDRESS|local",
        help="Use the workers of a Dask cluster at tcp://HOST:PORT; local starts a cluster on this machine.",
    )(with_engine)


def scene_or_machine_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """As ``scene_options``, for a command that also takes a machine, as it is."""
    with_scene = scene_options(command)

    @wraps(with_scene)
    def with_scene_or_machine(scene: str, row: int | None, **options: Any) -> Any:
        if not library.is_machine(scene):
            return with_scene(scene=scene, row=row, **options)
        given = [(option, value) for option, value in pop_overrides_as_changes(options).values()]
        refuse_options_with("a machine", {"row": row, **dict(given)})
        return command(scene=camopt.find_machine(scene), **options)

    return with_scene_or_machine


def scene_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Add --row and the options that override the scene; the command gets the changed scene.

    If a linkage of the scene cannot be assembled, the file ``picture`` of the command shows it as far as it goes.
    """

    @wraps(command)
    def with_scene(scene: str, row: int | None, **options: Any) -> Any:
        try:
            changed = cli.read_scene(scene, row, pop_overrides_as_changes(options))
        except BadInput as refused:
            if (picture := options.get("picture")) and library.draw_stage_of_refused_scene(refused, picture):
                cli.print_notes([f"{picture} shows the linkage as far as it goes"])
            raise
        return command(scene=changed, **options)

    return override_options(row_option(with_scene))


class Axis(click.ParamType):  # type: ignore[type-arg]  # generic from click 8.4 on
    """A grid START:STOP:STEP, a range START:STOP for samples, or one value."""

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
    """A part and the number of parts, such as 3/100."""

    name = "I/N"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[int, int]:
        part, slash, parts = value.partition("/")
        if not (slash and part.isdecimal() and parts.isdecimal() and 1 <= int(part) <= int(parts)):
            self.fail(f"{value!r} is not PART/PARTS with 1 <= PART <= PARTS, such as 3/100", param, ctx)
        return int(part), int(parts)


class SearchAxis(click.ParamType):  # type: ignore[type-arg]
    """A key of [search] with its axis, such as KEY=START:STOP:STEP; see ``Axis``."""

    name = "KEY=START:STOP:STEP"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, Any]:
        key, equals, axis = value.partition("=")
        if not (key and equals):
            self.fail(f"{value!r} is not {self.name}", param, ctx)
        return key, Axis().convert(axis, param, ctx)


class OutputPath(click.ParamType):  # type: ignore[type-arg]
    """A path of a folder or file. With ``suffixes``: of a file that ends in one of them and can be written."""

    name = "path"

    def __init__(self, *suffixes: str) -> None:
        self.suffixes = suffixes

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Path:
        try:
            path = expand_user_path(value)
        except ValueError as trouble:
            self.fail(f"{value!r} must be {trouble}", param, ctx)
        if self.suffixes:
            checked_suffix(path, parameter_name_in_help(param) if param else "path", self.suffixes)
            check_writable(path)
        return path


def refuse_to_overwrite_scene_file(scene_file: str | None, out: Path, key: str = "--out") -> None:
    """Raise BadInput if ``out`` is the user's scene, which is never overwritten."""
    if scene_file is not None and Path(scene_file).exists() and out.exists() and out.samefile(scene_file):
        raise BadInput([Mistake("camopt", key, str(out), "another file: this one is the scene itself")])


def refuse_to_overwrite_scene_in_folder(scene: Any, out: Path, file_pattern: str = "scene.toml") -> None:
    """Raise BadInput if a file of ``file_pattern`` in ``out`` is the user's scene, which is never overwritten."""
    scene_file = Path(scene.file)
    if scene_file.exists() and any(file.samefile(scene_file) for file in out.glob(file_pattern)):
        raise BadInput([Mistake("camopt", "--out", str(out), "another folder: this one holds the scene itself")])

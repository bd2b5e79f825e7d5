"""Animations: a cam turning under its follower, with diagrams whose cursors follow it."""

from base64 import b64encode
from dataclasses import dataclass, field

from camopt.drawing.canvas import Target, canvas
from camopt.drawing.frames import ffmpeg, write_gif, write_mp4
from camopt.drawing.moving_svg import moving_svg
from camopt.drawing.picture import Picture
from camopt.drawing.stage import DISC_SIZE, GROOVE_SIZE, set_stage
from camopt.problem.problem import resolve_design
from camopt.scene.arguments import SceneSource, scene_from
from camopt.storage.files import checked_suffix, whole_file

MOVING_KINDS = (".svg", ".gif", ".mp4")


@dataclass(frozen=True)
class Animation:
    """A cam that turns under its follower; a notebook shows it.

    Attributes
    ----------
    name : str
        The name of the scene.
    svg : str
        An animated SVG file: without scripts, one turn in 4 s.

    Examples
    --------
    >>> animation = camopt.animate(camopt.find_scene("two-pauses"))
    >>> "<animateTransform " in animation.svg, "<script" in animation.svg
    (True, False)
    """

    name: str
    svg: str = field(repr=False)

    def _repr_html_(self) -> str:
        image = b64encode(self.svg.encode()).decode()
        return f'<img src="data:image/svg+xml;base64,{image}" alt="a cam turning under its follower">'


def animate(scene: SceneSource, path: Target = None) -> Animation:
    """Animate a scene's cam, turning under its follower; to an SVG, GIF or MP4 file as well, if a path is given.

    Beside the cam, to scale, are diagrams of displacement, acceleration and pressure angle, whose cursors show the
    values at the cam angle; of a cylindrical cam the developed groove moves past the follower. One turn takes 4 s
    and 100 frames, each computed from the motion itself; between them, an SVG is interpolated. The same scene gives
    the same SVG or GIF, and the file appears only when whole.

    Parameters
    ----------
    scene : Scene, str or os.PathLike
        A scene with sizes of its own.
    path : str or os.PathLike, optional
        A file to write as well. SVG: one file without scripts, which browsers animate, and other programs show as
        it is at cam angle 0. MP4 needs ffmpeg, on the machine or by ``pip install "camopt[video]"``.

    Returns
    -------
    Animation
        Which a notebook shows; ``svg`` is the text of the SVG file.

    Raises
    ------
    BadInput
        If the file's name does not end in .svg, .gif or .mp4, or if there is no ffmpeg for an MP4.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> animation = camopt.animate(camopt.find_scene("two-pauses"), "turning.svg")
    """
    scene = scene_from(scene)
    suffix = None if path is None else checked_suffix(path, "path", MOVING_KINDS)
    if suffix == ".mp4":
        ffmpeg()  # or the trouble is known before the work
    picture = Picture(scene, resolve_design(scene))
    with canvas(None, GROOVE_SIZE if picture.problem.setup.mechanism.body.developed else DISC_SIZE) as figure:
        stage = set_stage(figure, picture)
        animation = Animation(scene.name, moving_svg(stage))
        if path is not None and suffix is not None:
            with whole_file(path) as partial:
                if suffix == ".svg":
                    partial.write_text(animation.svg, encoding="utf-8", newline="\n")
                else:
                    (write_gif if suffix == ".gif" else write_mp4)(stage, partial)
    return animation

"""Frames of an animation as GIF or MP4: fixed parts are drawn once, moving parts over them in each frame."""

import shutil
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow

from camopt.core.mistakes import BadInput, Mistake
from camopt.core.storage.files import whole_file
from camopt.show.drawing.moving_bodies import FRAMES, TURN_TIME, AnimatedFigure, body_artists

FRAME_DPI = 100
STILL_TIME = 3000  # ms: a frame that is read
PALETTE = 128  # colours of a GIF, those that cover the most of it: the white of the page stays white

Image = NDArray[np.uint8]


def frames(stage: AnimatedFigure) -> Iterator[Image]:
    """Each frame of one turn as rows of pixels, red, green and blue."""
    from matplotlib.transforms import Affine2D

    figure, placed = stage.figure, [(body, Affine2D()) for body in stage.bodies]
    figure.set_dpi(FRAME_DPI)
    for body, affine in placed:
        body.axes.set_visible(False)
        for artist in body_artists(body):
            artist.set_clip_on(body.windowed)
            artist.set_transform(affine + body.axes.transData)
    for reading in stage.readings:
        reading.text.set_visible(False)
    canvas = figure.canvas
    canvas.draw()
    behind = canvas.copy_from_bbox(figure.bbox)
    for moving in (*(body.axes for body in stage.bodies), *(reading.text for reading in stage.readings)):
        moving.set_visible(True)
    for frame in range(FRAMES):
        canvas.restore_region(behind)
        for body, affine in placed:
            body.place(affine, frame)
            body.axes.draw(canvas.get_renderer())
        for text, values in stage.readings:
            text.set_text(values[frame])
            text.draw(canvas.get_renderer())
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def write_gif(stage: AnimatedFigure, file: Path) -> None:
    """An animated GIF that repeats for ever, in one palette: that of the first frame."""
    _save_gif(frames(stage), round(1000 * TURN_TIME / FRAMES), file)


def write_still_gif(figures: Sequence[Any], path: Any) -> None:
    """A GIF that shows figures of one size one after the other, for ever; it appears only when whole."""
    images = []
    for figure in figures:
        figure.set_dpi(FRAME_DPI)
        figure.canvas.draw()
        images.append(np.asarray(figure.canvas.buffer_rgba())[..., :3].copy())
    with whole_file(path) as partial:
        _save_gif(images, STILL_TIME, partial)


def _save_gif(images: Iterable[Image], duration: int, file: Path) -> None:
    """Images as frames of a time in ms, in the palette of the first."""
    made: list[Any] = []
    for each in images:
        image = Pillow.fromarray(each)
        palette = made[0] if made else image.quantize(PALETTE, Pillow.Quantize.MAXCOVERAGE)
        made.append(image.quantize(palette=palette, dither=Pillow.Dither.NONE))
    made[0].save(file, format="GIF", save_all=True, append_images=made[1:], duration=duration, loop=0)


def write_mp4(stage: AnimatedFigure, file: Path) -> None:
    """A video of one turn, by ffmpeg.

    Raises
    ------
    BadInput
        If there is no ffmpeg.
    OSError
        If it fails.
    """
    width, height = (round(inches * FRAME_DPI) for inches in stage.figure.get_size_inches())
    given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", f"{FRAMES / TURN_TIME:g}"]
    made = ["-pix_fmt", "yuv420p", "-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact"]
    command = [ffmpeg(), "-v", "error", "-y", *given, "-i", "-", *made, "-movflags", "+faststart", "-f", "mp4"]
    with subprocess.Popen([*command, str(file)], stdin=subprocess.PIPE, stderr=subprocess.PIPE) as encoder:
        assert encoder.stdin is not None
        with suppress(BrokenPipeError):  # it has ended, and says why
            for frame in frames(stage):
                encoder.stdin.write(frame.tobytes())
        _, said = encoder.communicate()
    if encoder.returncode:
        raise OSError(f"ffmpeg: {said.decode(errors='replace').strip()}")


def ffmpeg() -> str:
    """The program that writes videos: that of the machine, or that of the extra ``video``.

    Raises
    ------
    BadInput
        If there is none.
    """
    if found := shutil.which("ffmpeg"):
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        why = 'needs ffmpeg: install it, or pip install "camopt[video]"'
        raise BadInput([Mistake("camopt", ".mp4", None, why, bare=True)]) from None
    program: Any = get_ffmpeg_exe()
    return str(program)

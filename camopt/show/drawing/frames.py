"""Frames of an animation as GIF or MP4. Fixed parts are drawn once, moving parts over them in each frame."""

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
from camopt.core.storage.files import atomically_written_file
from camopt.show.drawing.moving_bodies import FRAMES, TURN_TIME, AnimatedFigure, body_artists

FRAME_DPI = 100
STILL_TIME = 3000  # ms for a frame with text to read
PALETTE = 128  # colours of a GIF, chosen by area, so that the white page stays white

Image = NDArray[np.uint8]


def render_frames(animated_figure: AnimatedFigure) -> Iterator[Image]:
    """Frames of one turn, each as rows of RGB pixels."""
    from matplotlib.transforms import Affine2D

    figure, transforms = animated_figure.figure, [(body, Affine2D()) for body in animated_figure.bodies]
    figure.set_dpi(FRAME_DPI)
    for body, affine in transforms:
        body.axes.set_visible(False)
        for artist in body_artists(body):
            artist.set_clip_on(body.windowed)
            artist.set_transform(affine + body.axes.transData)
    for reading in animated_figure.readings:
        reading.text.set_visible(False)
    canvas = figure.canvas
    canvas.draw()
    behind = canvas.copy_from_bbox(figure.bbox)
    for moving in (
        *(body.axes for body in animated_figure.bodies),
        *(reading.text for reading in animated_figure.readings),
    ):
        moving.set_visible(True)
    for frame in range(FRAMES):
        canvas.restore_region(behind)
        for body, affine in transforms:
            centre, shift = body.origin, body.path[frame] - body.origin
            affine.clear().rotate_around(centre.real, centre.imag, body.angles[frame])
            affine.translate(shift.real, shift.imag)
            body.axes.draw(canvas.get_renderer())
        for text, values in animated_figure.readings:
            text.set_text(values[frame])
            text.draw(canvas.get_renderer())
        yield np.asarray(canvas.buffer_rgba())[..., :3].copy()


def write_gif(animated_figure: AnimatedFigure, file: Path) -> None:
    """Write an animated GIF that repeats for ever, with the palette of the first frame."""
    _save_gif(render_frames(animated_figure), round(1000 * TURN_TIME / FRAMES), file)


def write_still_gif(figures: Sequence[Any], path: Any) -> None:
    """Write a GIF that shows figures of one size one after the other; the file appears only when complete."""
    images = []
    for figure in figures:
        figure.set_dpi(FRAME_DPI)
        figure.canvas.draw()
        images.append(np.asarray(figure.canvas.buffer_rgba())[..., :3].copy())
    with atomically_written_file(path) as partial:
        _save_gif(images, STILL_TIME, partial)


def _save_gif(images: Iterable[Image], duration_ms: int, file: Path) -> None:
    """Save images as frames of a duration [ms], with the palette of the first."""
    quantized: list[Any] = []
    for pixels in images:
        image = Pillow.fromarray(pixels)
        palette = quantized[0] if quantized else image.quantize(PALETTE, Pillow.Quantize.MAXCOVERAGE)
        quantized.append(image.quantize(palette=palette, dither=Pillow.Dither.NONE))
    first, *others = quantized
    first.save(file, format="GIF", save_all=True, append_images=others, duration=duration_ms, loop=0)


def write_mp4(animated_figure: AnimatedFigure, file: Path) -> None:
    """Write a video of one turn with ffmpeg.

    Raises
    ------
    BadInput
        If there is no ffmpeg.
    OSError
        If ffmpeg fails.
    """
    width, height = (round(inches * FRAME_DPI) for inches in animated_figure.figure.get_size_inches())
    frames = f"-f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {FRAMES / TURN_TIME:g} -i -"
    encoding = "-pix_fmt yuv420p -threads 1 -fflags +bitexact -flags:v +bitexact -movflags +faststart -f mp4"
    command = [find_ffmpeg(), *f"-v error -y {frames} {encoding}".split(), str(file)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as encoder:
        assert encoder.stdin is not None
        with suppress(BrokenPipeError):  # ffmpeg has ended; its error message is read below
            for frame in render_frames(animated_figure):
                encoder.stdin.write(frame.tobytes())
        _, errors = encoder.communicate()
    if encoder.returncode:
        raise OSError(f"ffmpeg: {errors.decode(errors='replace').strip()}")


def find_ffmpeg() -> str:
    """Path of ffmpeg: that of the machine, or that of the extra ``video``.

    Raises
    ------
    BadInput
        If there is no ffmpeg.
    """
    if path := shutil.which("ffmpeg"):
        return path
    try:
        from imageio_ffmpeg import get_ffmpeg_exe
    except ImportError:
        why = 'needs ffmpeg: install it, or pip install "camopt[video]"'
        raise BadInput([Mistake("camopt", ".mp4", None, why, bare=True)]) from None
    return str(get_ffmpeg_exe())

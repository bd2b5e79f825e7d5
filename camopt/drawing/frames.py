"""Frames of an animation as GIF or MP4: fixed parts are drawn once, moving parts over them in each frame."""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from camopt.drawing.bodies import FRAMES, TURN_TIME, Stage, artists_of
from camopt.mistakes import BadInput, Mistake

FRAME_DPI = 100
PALETTE, SHADE_BITS = 128, 5  # of a GIF; bits of red, green and blue by which it tells colours apart

Image = NDArray[np.uint8]


def frames(stage: Stage) -> Iterator[Image]:
    """Each frame of one turn as rows of pixels, red, green and blue."""
    from matplotlib.transforms import Affine2D

    figure, placed = stage.figure, [(body, Affine2D()) for body in stage.bodies]
    figure.set_dpi(FRAME_DPI)
    for body, affine in placed:
        body.axes.set_visible(False)
        for artist in artists_of(body):
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


def write_gif(stage: Stage, file: Path) -> None:
    """An animated GIF that repeats for ever, in one palette: the most frequent colours of the first frame."""
    from PIL import Image as Pillow

    images: list[Any] = []
    for frame in frames(stage):
        if not images:
            palette = _palette(frame)
            nearest = _nearest(palette)
        images.append(Pillow.fromarray(nearest.take(_shades(frame))))
        images[-1].putpalette(palette.ravel().tolist())
    duration = round(1000 * TURN_TIME / FRAMES)
    images[0].save(file, format="GIF", save_all=True, append_images=images[1:], duration=duration, loop=0)


def _shades(colours: NDArray[Any]) -> NDArray[np.uint16]:
    """A number of the upper bits of colours (…, 3), red first."""
    red, green, blue = np.moveaxis((colours >> (8 - SHADE_BITS)).astype(np.uint16), -1, 0)
    shades: NDArray[np.uint16] = (red << 2 * SHADE_BITS) | (green << SHADE_BITS) | blue
    return shades


def _palette(image: Image) -> Image:
    """The most frequent colours of an image, one of each shade, (n, 3)."""
    colours, counts = np.unique(image.astype(np.intp) @ np.array([1 << 16, 1 << 8, 1]), return_counts=True)
    order: NDArray[np.intp] = colours[np.argsort(-counts, kind="stable")]
    usual = np.column_stack([order >> 16, order >> 8 & 255, order & 255])
    _, first = np.unique(_shades(usual), return_index=True)
    palette: Image = usual[np.sort(first)[:PALETTE]].astype(np.uint8)
    return palette


def _nearest(palette: Image) -> Image:
    """For each shade the place of its colour in a palette, or of the nearest."""
    levels = (np.arange(1 << SHADE_BITS) + 0.5) * (1 << 8 - SHADE_BITS)
    middles = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), axis=-1).reshape(-1, 3)
    nearest = np.argmin(np.square(middles[:, None] - palette.astype(float)).sum(axis=2), axis=1)
    nearest[_shades(palette)] = np.arange(len(palette))
    places: Image = nearest.astype(np.uint8)
    return places


def write_mp4(stage: Stage, file: Path) -> None:
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
    """The path of ffmpeg: the machine's own, or that of the extra ``video``.

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

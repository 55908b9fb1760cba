"""Recording: frames to a file: GIF by Pillow, MP4 by ffmpeg."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterable
from importlib import import_module
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from hotlap.core.errors import InputError
from hotlap.system.whole_files import written_whole

if TYPE_CHECKING:
    from PIL.Image import Image

Pixels = NDArray[np.uint8]

COLOURS = 200  # of a GIF
LINGER = 2.5  # s on the last frame
RATES = {".gif": 20, ".mp4": 30}  # frames a second


def check_recorder(path: Path) -> None:
    """Refuse a film that could not be written, before any time is spent on its flights.

    Raises:
        InputError: there is no ffmpeg for an MP4.
    """
    if path.suffix.lower() == ".mp4" and not find_ffmpeg():
        reason = "needs ffmpeg, which is not on the PATH; install it (or: pip install imageio-ffmpeg), or ask for a .gif"
        raise InputError(str(path), "", reason)


def find_ffmpeg() -> str:
    """Where ffmpeg is: on the PATH, or in the package imageio-ffmpeg; "" where it is not."""
    found = shutil.which("ffmpeg")
    if found:
        return found
    try:
        return str(import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        return ""


def record(path: Path, frames: Iterable[Pixels]) -> Path:
    """Write a film whole or not at all, in the format of its suffix; at least one frame.

    Args:
        path: .gif or .mp4.
        frames: each shape (height, width, 3), `RATES` of them a second.

    Raises:
        InputError: when it cannot be written.
    """
    with written_whole(path) as part:
        (_write_mp4 if path.suffix.lower() == ".mp4" else _write_gif)(part, frames, RATES[path.suffix.lower()])
    return path


def _write_gif(path: Path, frames: Iterable[Pixels], rate: int) -> None:
    """One palette for all frames; what does not change between them costs nothing."""
    from PIL import Image  # noqa: PLC0415  matplotlib brings it

    pictures = [Image.fromarray(frame) for frame in frames]
    palette = _colours_of(np.asarray(pictures[-1])).quantize(COLOURS, dither=Image.Dither.NONE)
    drawn = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures]
    pause = 1000 // rate
    durations = [*[pause] * (len(drawn) - 1), int(1000 * LINGER)]
    options = {"append_images": drawn[1:], "duration": durations, "loop": 0, "optimize": True, "disposal": 1}
    drawn[0].save(path, format="GIF", save_all=True, **options)


def _colours_of(frame: Pixels) -> Image:
    """Every colour of a frame with a weight that grows slowly with its area, so that thin lines get theirs too; as a row of pixels."""
    from PIL import Image  # noqa: PLC0415

    colours, counts = np.unique(frame.reshape(-1, 3), axis=0, return_counts=True)
    return Image.fromarray(np.repeat(colours, np.ceil(np.sqrt(counts)).astype(int), axis=0)[None])


def _write_mp4(path: Path, frames: Iterable[Pixels], rate: int) -> None:
    """H.264 that every browser plays."""
    frames = iter(frames)
    first = next(frames)
    size = f"{first.shape[1]}x{first.shape[0]}"
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", str(rate), "-i", "-"]
    made = ["-vf", f"tpad=stop_mode=clone:stop_duration={LINGER}", "-c:v", "libx264", "-crf", "20", "-pix_fmt", "yuv420p"]
    command = [find_ffmpeg(), "-y", "-loglevel", "error", *source, *made, "-movflags", "+faststart", "-f", "mp4", str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        _, complaint = _feed(process, chain([first], frames))
    if process.returncode:
        raise OSError(f"ffmpeg: {complaint.decode(errors='replace').strip().splitlines()[-1:] or ['it failed']}")


def _feed(process: subprocess.Popen[bytes], frames: Iterable[Pixels]) -> tuple[bytes, bytes]:
    """Send frames to ffmpeg until it has all of them or stops."""
    assert process.stdin is not None, "it was asked for"  # noqa: S101  our own mistake
    try:
        for frame in frames:
            process.stdin.write(np.ascontiguousarray(frame).tobytes())
    except BrokenPipeError:
        pass
    return process.communicate()

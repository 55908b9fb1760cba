"""Small files in the forms of other programs, and changes of them."""

from __future__ import annotations

from pathlib import Path

SAMPLES = Path(__file__).parent / "samples"
TRACKS = ("togt_track.yaml", "lsy_level.toml", "rpg_track.yaml", "fast_fly_gates.yaml")
QUADROTORS = (
    *("togt_drone.yaml", "rpg_quadrotor.yaml", "agilicious.yaml", "fast_fly_quadrotor.yaml", "mrs.yaml"),
    *("px4.sdf", "model/model.sdf", "pybullet.urdf"),
)
SEVERAL = "drone_models.toml"  # a file of several vehicles


def changed(sample: str, folder: Path, *changes: tuple[str, str]) -> Path:
    """A sample in a folder of its own, with words in place of others.

    Args:
        sample: its name.
        folder: where the copy goes.
        changes: words that stand there and what to write for them.
    """
    text = (SAMPLES / sample).read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path = folder / Path(sample).name
    path.write_text(text, encoding="utf-8")
    return path

"""A real study of the cheapest case: a plate that is moved to and fro, whose fastest motion is known.

Its peak speed is amplitude times angular speed: with an amplitude of at most 9 mm, 0.9 m/s at 100 rad/s.
"""

from __future__ import annotations

from pathlib import Path

CASE = Path(__file__).parents[2] / "cases" / "bushing-hysteresis"
PLATES = f"""
title = "A plate as fast as possible"
case = "{CASE}"
overrides = ["output.pictures=false", "duration_s=0.3", "screen.frames.plate.drive.run_up_s=0.08"]
goals = ["maximise speed"]
limits = ["way <= 0.009"]
seed = 3

[factors.amplitude]
range = [4, 12]
unit = "mm"
[factors.rate]
range = [40, 100]
unit = "rad/s"

[set]
"screen.frames.plate.drive.amplitude_m" = ["amplitude / 1000", "0", "0"]
"screen.frames.plate.drive.speed_rad_per_s" = "rate"

[responses.speed]
result = "probes.plate.peak_speed_m_per_s"
unit = "m/s"
[responses.way]
result = "probes.plate.half_range_m.0"
unit = "m"

[plan]
runs = 6
centres = 2
[search]
runs = 3
"""


def write_plates(folder: Path, *replaced: tuple[str, str]) -> Path:
    """Write the study into a folder, with parts of its text replaced."""
    text = PLATES
    for old, new in replaced:
        assert old in text, old
        text = text.replace(old, new)
    file = folder / "study.toml"
    file.write_text(text, encoding="utf-8")
    return file

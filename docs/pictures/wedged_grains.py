"""A grain between two walls over the turn that lets it go, and the share of grains that are out over the
stretch of their slots: numbers of a run of cases/wedged-grains, read by its released.py."""

import csv
from pathlib import Path

from drawing import DARK, PANELS, PARTICLES, ball, np, plt

CASE = Path(__file__).parents[2] / "cases" / "wedged-grains"
LAND, BELOW = 5.0, -17.0  # mm: width of a land; what fell deeper is not shown


def read(name: str) -> list[dict[str, float]]:
    with (CASE / name).open(newline="", encoding="utf-8") as text:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(text)]


def draw() -> None:
    frames, turns = read("turn.csv"), read("released.csv")
    _, rows = plt.subplot_mosaic(
        [[str(number) for number in range(len(frames))], ["share"] * len(frames)],
        figsize=(8.0, 4.6),
        height_ratios=(1, 1.5),
        constrained_layout=True,
    )
    for number, frame in enumerate(frames):
        axes = rows[str(number)]
        for side, out in (("left", -1), ("right", 1)):
            upper, lower = (
                np.array([frame[f"{side}_{edge}_{axis}_mm"] for axis in "xz"]) for edge in ("upper", "lower")
            )
            far = np.array([out * LAND / 2, 0.0])
            axes.fill(*np.array([upper, upper + far, lower + far, lower]).T, fc="#cfe0e6", ec=PANELS)
        if frame["grain_z_mm"] > BELOW:
            ball(axes, frame["grain_x_mm"], frame["grain_z_mm"], frame["size_mm"] / 2)
        wide = frame["right_upper_x_mm"] - frame["left_upper_x_mm"]
        axes.set(xlim=(-9.5, 9.5), ylim=(-14, 7), aspect="equal")
        axes.set_title(f"{1e3 * (frame['time_s'] - frames[0]['time_s']):.0f} ms\n{wide:.2f} mm", fontsize=9)
        axes.axis("off")
    share = rows["share"]
    stretch = [row["stretch_percent"] for row in turns]
    smaller = [row["smaller_percent"] for row in turns]
    share.plot(stretch, smaller, ":", color=DARK, label="smaller than their slots have been")
    share.plot(stretch, [row["released_percent"] for row in turns], "o", color=PARTICLES, label="thrown out")
    share.set(xlabel="largest stretch of the slots so far (%)", ylabel="of 70 grains (%)", ylim=(0, 100))
    share.legend(loc="upper left")
    words = f"a grain of {frames[0]['size_mm']:.2f} mm, and the width of its slot"
    plt.gcf().suptitle(words, fontsize=10)

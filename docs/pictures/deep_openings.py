"""Walls of openings on a bent mat, what holds a grain between them, and when a stretch lets grains go."""

from drawing import DARK, PALE, PANELS, PARTICLES, ball, np, plots

RADIUS, HALF_DEPTH, PITCH, OPENING = 30.0, 2.95, 6.0, 3.0


def on_mat(along: np.ndarray, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places of points at an offset from a mat bent to a circle."""
    angle = along / RADIUS
    return (RADIUS - offset) * np.sin(angle), RADIUS - (RADIUS - offset) * np.cos(angle)


def draw() -> None:
    mat, share = plots(2)
    for land in range(-2, 3):
        ends = PITCH * land + np.array([-1, 1]) * (PITCH - OPENING) / 2
        lower = ends + np.array([1, -1]) * HALF_DEPTH * 2 * np.tan(np.radians(5.0))
        upper_side, lower_side = np.linspace(*ends, 20), np.linspace(*lower[::-1], 20)
        half = np.full(20, HALF_DEPTH)
        x, y = np.hstack([on_mat(upper_side, half), on_mat(lower_side, -half)])
        mat.fill(x, y, facecolor="#cfe0e6", edgecolor=PANELS)
    middle = np.linspace(-14, 14, 80)
    mat.plot(*on_mat(middle, np.zeros(80)), color=DARK, linestyle=":", linewidth=0.8)
    x, y = on_mat(np.array([PITCH / 2]), np.array([HALF_DEPTH - 0.4]))
    ball(mat, x[0], y[0], 1.46)
    mat.set(aspect="equal", xlabel="along (mm)", ylabel="up (mm)", title="walls follow the mat's normal")
    strain = np.linspace(0, 5, 200)
    oversize = np.random.default_rng(1).uniform(0, 4, 60)
    share.step(strain, [100 * (oversize < each).mean() for each in strain], color=PARTICLES)
    share.plot([0, 4], [0, 100], color=DARK, linestyle=":", linewidth=0.8)
    share.axvspan(4, 5, color=PALE)
    share.set(
        xlabel="strain across the slots (%)",
        ylabel="smaller than the opening (%)",
        title="60 grains, 0 to 4 % too large",
    )

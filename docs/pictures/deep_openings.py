"""Walls of openings on a bent mat, and a grain between two of them."""

from drawing import DARK, PANELS, ball, np, plots

RADIUS, HALF_DEPTH, PITCH, OPENING = 30.0, 2.95, 6.0, 3.0


def on_mat(along: np.ndarray, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places of points at an offset from a mat bent to a circle."""
    angle = along / RADIUS
    return (RADIUS - offset) * np.sin(angle), RADIUS - (RADIUS - offset) * np.cos(angle)


def draw() -> None:
    mat = plots(1, 4.5, 2.8)
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

"""A drawing of a panel, and the triangles that particles touch between its openings."""

from drawing import DARK, PANELS, np, plots

from orchestrator.case.deck.triangle_grid import perforated_grid
from orchestrator.ports.drawn_openings import DrawnOpenings, as_outline
from orchestrator.ports.geometry import AperturePattern, Rectangle

LENGTH, WIDTH = 0.15, 0.09


def outlines() -> list[np.ndarray]:
    """A row of slots, a row of hexagons and two wedges."""
    slot = np.array([[-11, -2], [11, -2], [11, 2], [-11, 2]])
    turn = np.arange(6) * np.pi / 3
    hexagon = 6 * np.column_stack([np.cos(turn), np.sin(turn)])
    wedge = np.array([[-14, -5], [14, -2], [14, 2], [-14, 5]])
    places = [(slot, (25, y)) for y in range(10, 90, 10)] + [(hexagon, (60, y)) for y in range(15, 90, 20)]
    return [1e-3 * (shape + at) for shape, at in [*places, (wedge, (110, 25)), (wedge, (110, 65))]]


def draw() -> None:
    drawn = DrawnOpenings(tuple(map(as_outline, outlines())), (LENGTH, WIDTH))
    x, y, _ = np.eye(3)
    panel = Rectangle(np.zeros(3), x, y, LENGTH, LENGTH, WIDTH, 0.0)
    pattern = AperturePattern("polygon", *drawn.mean_sides_m, *drawn.pitch_m, drawn=drawn)
    grid = perforated_grid(panel, pattern, (10, 6))
    left, right = plots(2, 7.5, 2.6)
    sheet = np.array([[0, 0], [LENGTH, 0], [LENGTH, WIDTH], [0, WIDTH]])
    for corners in [sheet, *drawn.corners_m]:
        left.plot(*1e3 * np.vstack([corners, corners[:1]]).T, color=DARK, linewidth=1.1)
    right.triplot(*1e3 * grid.coordinates_m.T, grid.triangles, color=PANELS, linewidth=0.6)
    for axes, title in ((left, "the drawing"), (right, "what particles touch")):
        axes.set(aspect="equal", xlabel="along (mm)", ylabel="across (mm)", title=title)

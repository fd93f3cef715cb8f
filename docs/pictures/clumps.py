"""The shapes of grains in the square opening of their sieve size, and the chance that rods and spheres fall
straight through an opening."""

from drawing import DARK, PALE, PANELS, PARTICLES, Circle, Rectangle, np, plt, say

from orchestrator.case import solvers

SHAPES = ("rod", "stone", "flake")
SQUARE, SLOT = (3.0, 3.0, 4.5, 4.5), (20.0, 3.0, 25.0, 6.0)  # opening and pitch along and across, mm


def shadow(name: str) -> tuple[np.ndarray, np.ndarray]:
    """The spheres' places in the direction in which the shape fits into the least square, and their radii."""
    spheres = np.array(solvers.shape(name).spheres)
    places, radii = spheres[:, :3], spheres[:, 3]
    best, least = None, np.inf
    random = np.random.default_rng(0)
    frames = [np.eye(3), np.eye(3)[[1, 2, 0]], np.eye(3)[[2, 0, 1]]]
    frames += [np.linalg.qr(random.normal(size=(3, 3)))[0] for _ in range(20000)]
    for frame in frames:
        flat = places @ frame[:2].T
        low, high = (flat - radii[:, None]).min(axis=0), (flat + radii[:, None]).max(axis=0)
        side = (high - low).max()
        if side < least - 1e-9:
            least, best = side, flat - (low + high) / 2
    return best, radii


def falls_through(size: np.ndarray, opening: tuple[float, ...], rods: bool) -> np.ndarray:
    up = (np.arange(200) + 0.5) / 200
    turn = (np.arange(200) + 0.5) / 200 * np.pi / 2
    across = np.sqrt(1 - up**2)[:, None] if rods else np.zeros((1, 1))
    along, beside, pitch_along, pitch_across = opening
    chance = []
    for each in size:
        room = np.maximum(along - each * (1 + across * np.cos(turn)), 0)
        room = room * np.maximum(beside - each * (1 + across * np.sin(turn)), 0)
        chance.append(room.mean() / (pitch_along * pitch_across))
    return np.array(chance)


def draw() -> None:
    _, (left, right) = plt.subplots(1, 2, figsize=(8, 2.8), constrained_layout=True)
    left.set(xlim=(0, 5), ylim=(-1.1, 1.1), aspect="equal")
    left.axis("off")
    for name, x in zip(SHAPES, (0.8, 2.4, 4.0), strict=True):
        left.add_patch(Rectangle((x - 0.5, -0.5), 1, 1, fc=PALE, ec=DARK, lw=1.2))
        for place, radius in zip(*shadow(name), strict=True):
            left.add_patch(Circle((x + place[0], place[1]), radius, fc=PARTICLES, ec="white", lw=0.6))
        say(left, x, -0.75, name)
    say(left, 2.4, 0.85, "shadows in the square of the sieve size", size=9)
    share = np.linspace(0.05, 1.0, 96)
    for opening, color, words in ((SLOT, PANELS, "slots 3 × 20"), (SQUARE, PARTICLES, "squares of 3")):
        for rods, style in ((False, "--"), (True, "-")):
            label = f"{words}, {'rods' if rods else 'spheres'}"
            right.plot(share, falls_through(3 * share, opening, rods), style, color=color, label=label)
    right.set(xlabel="sieve size over the opening's width", ylabel="chance without a touch", ylim=(0, None))
    right.legend(fontsize=8)

"""Restitution by points, and the height of a grain that falls from 1 m."""

from drawing import DARK, PARTICLES, np, plots

GRAVITY_M_PER_S2 = 9.81
SPEED_M_PER_S, RESTITUTION = (0.1, 0.5, 1.0, 5.0), (0.89, 0.59, 0.50, 0.33)


def flights(restitution) -> tuple[np.ndarray, np.ndarray]:
    """Times and heights of a fall from 1 m and seven rebounds."""
    hit_s = np.sqrt(2 / GRAVITY_M_PER_S2)
    speed, t = GRAVITY_M_PER_S2 * hit_s, np.linspace(0, hit_s, 60)
    times, heights = [t], [1 - GRAVITY_M_PER_S2 * t**2 / 2]
    for _ in range(7):
        speed *= restitution(speed)
        t = np.linspace(0, 2 * speed / GRAVITY_M_PER_S2, 60)
        times.append(hit_s + t)
        heights.append(speed * t - GRAVITY_M_PER_S2 * t**2 / 2)
        hit_s += t[-1]
    return np.concatenate(times), np.concatenate(heights)


def draw() -> None:
    points, heights = plots(2)
    speed = np.geomspace(0.05, 10, 200)
    points.semilogx(speed, np.interp(speed, SPEED_M_PER_S, RESTITUTION), color=PARTICLES)
    points.plot(SPEED_M_PER_S, RESTITUTION, "o", color=PARTICLES)
    points.set(xlabel="impact speed (m/s)", ylabel="restitution", ylim=(0, 1))
    heights.plot(*flights(lambda _: 0.5), color=DARK, label="0.5 at every speed")
    heights.plot(
        *flights(lambda s: np.interp(s, SPEED_M_PER_S, RESTITUTION)), color=PARTICLES, label="by the points"
    )
    heights.set(xlabel="time (s)", ylabel="height (m)", xlim=(0, 1.4), ylim=(0, 1))
    heights.legend()

"""Coal in still air: terminal speeds, and paths of grains that are thrown at 3.5 m/s."""

from drawing import DARK, PALE, PANELS, PARTICLES, np, plots

from orchestrator.ports.physics import sphere_drag_N

DENSITY_KG_PER_M3, VISCOSITY_PA_S, GRAVITY_M_PER_S2, COAL_KG_PER_M3 = 1.204, 1.825e-5, 9.81, 1430.0


def slowing_m_per_s2(diameter_m: float, speed_m_per_s: float) -> float:
    drag_N = sphere_drag_N(diameter_m, speed_m_per_s, DENSITY_KG_PER_M3, VISCOSITY_PA_S)
    return float(drag_N / (COAL_KG_PER_M3 * np.pi / 6 * diameter_m**3))


def terminal_m_per_s(diameter_m: float) -> float:
    slow, fast = 1e-6, 100.0
    for _ in range(60):
        middle = np.sqrt(slow * fast)
        slow, fast = (
            (middle, fast) if slowing_m_per_s2(diameter_m, middle) < GRAVITY_M_PER_S2 else (slow, middle)
        )
    return float(middle)


def path_m(diameter_m: float, step_s: float = 1e-3) -> np.ndarray:
    place, velocity, places = np.zeros(2), np.array([2.5, 2.5]), []
    while place[1] >= 0:
        places.append(place)
        slowing = slowing_m_per_s2(diameter_m, float(np.hypot(*velocity)))
        air = slowing * velocity / np.hypot(*velocity)
        velocity = velocity - step_s * (air + np.array([0.0, GRAVITY_M_PER_S2]))
        place = place + step_s * velocity
    return np.array(places)


def draw() -> None:
    speeds, paths = plots(2)
    diameter_m = np.geomspace(5e-5, 2e-2, 60)
    speeds.loglog(1e3 * diameter_m, [terminal_m_per_s(each) for each in diameter_m], color=PARTICLES)
    speeds.axhspan(2.0, 4.0, color=PALE)
    speeds.text(0.06, 2.5, "throws of flip-flow mats", color=DARK)
    speeds.set(xlabel="diameter of coal (mm)", ylabel="terminal speed (m/s)")
    for diameter_mm, color in ((0.5, PARTICLES), (1, "#d99a2b"), (2, PANELS), (20, DARK)):
        paths.plot(*path_m(1e-3 * diameter_mm).T, color=color, label=f"{diameter_mm:g} mm")
    paths.set(xlabel="along (m)", ylabel="up (m)", ylim=(0, 0.7))
    paths.legend(ncols=2, loc="upper left")

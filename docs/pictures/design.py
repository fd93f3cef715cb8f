"""A search under way: noisy runs, what a Gaussian process makes of them, and where the next run pays most."""

import numpy as np
from drawing import DARK, PANELS, PARTICLES, plots
from scipy.stats import norm

LENGTH, NOISE = 0.55, 0.08
RUNS = np.array([-0.9, -0.35, 0.05, 0.45, 0.95])
VALUES = np.array([-0.85, -0.15, 0.42, 0.62, -0.30])


def covariance(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Matern 5/2 of variance one."""
    r = np.sqrt(5) * np.abs(x[:, None] - y[None, :]) / LENGTH
    return (1 + r + r**2 / 3) * np.exp(-r)


def draw() -> None:
    left, right = plots(2, 7.5, 2.8)
    x = np.linspace(-1, 1, 201)
    known = covariance(RUNS, RUNS) + NOISE**2 * np.eye(len(RUNS))
    weights = np.linalg.solve(known, covariance(RUNS, x)).T
    mean = weights @ VALUES
    deviation = np.sqrt(np.maximum(1 - (weights * covariance(x, RUNS)).sum(axis=1), 0))
    best = mean[np.argmax(mean)]
    z = (mean - best) / deviation
    gain = deviation * (z * norm.cdf(z) + norm.pdf(z))
    following = x[np.argmax(gain)]
    left.fill_between(x, mean - 1.96 * deviation, mean + 1.96 * deviation, color=PANELS, alpha=0.2, lw=0)
    left.plot(x, mean, color=PANELS, label="prediction, 95 %")
    left.errorbar(RUNS, VALUES, 1.96 * NOISE, fmt="o", ms=4, color=DARK, label="runs, 95 %")
    left.axhline(best, color="#bbbbbb", lw=0.8, ls=":")
    left.set(xlabel="factor, coded", ylabel="goal", xlim=(-1, 1))
    left.legend(loc="lower center", fontsize=9)
    right.plot(x, gain, color=PARTICLES)
    right.set(xlabel="factor, coded", ylabel="expected gain", xlim=(-1, 1), ylim=(0, None))
    for axes in (left, right):
        axes.axvline(following, color="#bbbbbb", lw=0.8)
    right.annotate("next run", (following, 0.02), (following + 0.04, 0.03), fontsize=9)

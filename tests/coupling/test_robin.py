"""The equations that the scheme ``robin`` solves in every interval."""

from __future__ import annotations

import numpy as np

from orchestrator.coupling.schemes.robin import SOLVED, conjugate_gradients
from orchestrator.ports import Array


def test_conjugate_gradients_solve_to_the_share_wanted() -> None:
    """Random masses joined by random springs, with an exact answer to find, in fewer iterations than there
    are masses (steepest descent takes 200 and more); no load gives no motion."""
    random = np.random.default_rng(1)
    springs = 10.0 * random.random((30, 30))
    stiffness = np.diag(random.uniform(1.0, 1e3, 30)) + springs @ springs.T
    products = 0
    exact = random.standard_normal((30, 3))
    right_side = stiffness @ exact
    diagonal = np.repeat(np.diag(stiffness)[:, None], 3, axis=1)

    def product(u: Array) -> Array:
        nonlocal products
        products += 1
        return stiffness @ u

    solution = conjugate_gradients(product, right_side, diagonal)
    left = np.linalg.norm(right_side - stiffness @ solution)
    assert 0.0 < left <= 1.01 * SOLVED * np.linalg.norm(right_side)
    assert products < 30
    assert not conjugate_gradients(product, 0.0 * right_side, diagonal).any()

"""A small neural network with one hidden layer, trained with several splits of the data and starts.

Source: D. E. Rumelhart, G. E. Hinton, R. J. Williams, Nature 323 (1986) 533, doi:10.1038/323533a0 (back
propagation); scikit-learn trains it.  The paper on the FFS0827 has 5 inputs, 9 nodes and 2 outputs, and
splits its samples into 70 % for training, 15 % for choosing and 15 % for testing.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from sklearn.exceptions import ConvergenceWarning
from sklearn.neural_network import MLPRegressor

from orchestrator.studies.design.surrogates import TooFewPoints, settings_of
from orchestrator.workbench.vocabulary import Array

TRAINED, CHOSEN = 0.70, 0.15  # shares of the settings; the rest tests
PENALTIES = (1e-3, 1e-2, 1e-1, 1.0)  # on the weights' squares; the share CHOSEN decides
FEWEST = 14  # settings: fewer leave two or none to choose by


@dataclass(frozen=True)
class Network:
    """All responses by one network of ``nodes`` hidden nodes, trained ``members`` times."""

    nodes: int = 9
    members: int = 20

    def fit(self, x: Array, y: Array, variance: Array, seed: int) -> FittedNetwork:
        """Train the members, each with a split of the settings and a start of its own.

        Raises TooFewPoints where runs of fewer than 14 settings have all responses.
        """
        known = np.isfinite(y).all(axis=1)
        settings = settings_of(x[known])
        count = len(np.unique(settings))
        if count < FEWEST:
            raise TooFewPoints(f"{count} settings with all responses for a network, which needs {FEWEST}")
        mean, scale = y[known].mean(axis=0), np.maximum(y[known].std(axis=0), 1e-300)
        inputs, outputs = x[known], (y[known] - mean) / scale
        rng = np.random.default_rng(seed)
        nets, tested = [], np.full((self.members, *outputs.shape), np.nan)
        for member in range(self.members):
            order = rng.permutation(count)
            ends = [round(TRAINED * count), round((TRAINED + CHOSEN) * count)]
            train, choose, test = (np.isin(settings, part) for part in np.split(order, ends))
            start = int(rng.integers(2**31))
            trials = [self._trained(inputs[train], outputs[train], penalty, start) for penalty in PENALTIES]
            errors = [((_outputs(net, inputs[choose]) - outputs[choose]) ** 2).mean() for net in trials]
            nets.append(trials[int(np.argmin(errors))])
            tested[member, test] = _outputs(nets[-1], inputs[test])
        return FittedNetwork(nets, known, mean, scale, outputs, tested)

    def _trained(self, x: Array, y: Array, penalty: float, start: int) -> MLPRegressor:
        net = MLPRegressor(
            hidden_layer_sizes=(self.nodes,),
            activation="tanh",
            solver="lbfgs",
            alpha=penalty,
            max_iter=500,
            random_state=start,
        )
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ConvergenceWarning)  # 500 iterations are the stop that is meant
            return net.fit(x, y if y.shape[1] > 1 else y[:, 0])


def _outputs(net: MLPRegressor, x: Array) -> Array:
    """The outputs of a net, (p, m), also of one output."""
    outputs: Array = net.predict(x).reshape(len(x), -1)
    return outputs


@dataclass(frozen=True)
class FittedNetwork:
    """The trained members.

    ``outputs``, (n, m), and ``tested``, (members, n, m), are scaled to the order of one; ``tested`` is what
    each member says of the points that it was neither trained nor chosen by.
    """

    nets: list[MLPRegressor]
    known: npt.NDArray[np.bool_]
    mean: Array
    scale: Array
    outputs: Array
    tested: Array

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict the members' mean, (m, p), and their scatter with the test error, (m, p, p)."""
        said = np.array([_outputs(net, x) for net in self.nets])
        error = np.nanmean((self.tested - self.outputs) ** 2, axis=(0, 1))
        covariance = [
            np.atleast_2d(np.cov(said[:, :, i].T)) + error[i] * np.eye(len(x)) for i in range(said.shape[2])
        ]
        mean = self.mean[:, None] + self.scale[:, None] * said.mean(axis=0).T
        return mean, np.array(covariance) * self.scale[:, None, None] ** 2

    def left_out(self) -> tuple[Array, Array]:
        """Predict each point by the members that had it in their test part, (n, m)."""
        mean, deviation = np.full((2, len(self.known), len(self.mean)), np.nan)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # a point may have been tested by no member
            mean[self.known] = self.mean + self.scale * np.nanmean(self.tested, axis=0)
            spread = np.nanvar(self.tested, axis=0)
        error = np.nanmean((self.tested - self.outputs) ** 2, axis=(0, 1))
        deviation[self.known] = self.scale * np.sqrt(spread + error)
        return mean, deviation

    def explained_by_members(self) -> Array:
        """Compute the share of each response's variance, (members, m), that a member explains in its test
        part."""
        return np.asarray(1.0 - np.nanmean((self.tested - self.outputs) ** 2, axis=1))

"""Sobol indices of what a surrogate predicts: how much of a response's variance each factor explains."""

from __future__ import annotations

import warnings

import numpy as np
from SALib.analyze import sobol as analysis
from SALib.sample import sobol as sampling

from orchestrator.studies.design.optimisers import predict_each
from orchestrator.studies.design.surrogates import Fitted
from orchestrator.workbench.vocabulary import Array

CONSTANT = 1e-9  # range over size of a response that no factor changes


def sobol_indices(fitted: Fitted, factors: int, samples: int = 1024, seed: int = 1) -> Array:
    """Compute first-order and total Sobol indices over the coded cube with their 95 % half widths.

    Return (m, 4, factors): first order, its half width, total, its half width, of each response; all zero of
    a response that is predicted to be constant.

    Source: A. Saltelli et al., Comput. Phys. Commun. 181 (2010) 259, doi:10.1016/j.cpc.2009.09.018;
    SALib does it.
    """
    problem = {
        "num_vars": factors,
        "names": [str(i) for i in range(factors)],
        "bounds": [[-1.0, 1.0]] * factors,
    }
    settings = sampling.sample(problem, samples, calc_second_order=False, seed=seed)
    indices = []
    for response in predict_each(fitted, settings)[0]:
        if np.ptp(response) <= CONSTANT * np.abs(response).max():
            indices.append([np.zeros(factors)] * 4)
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)  # of pandas, about the way SALib calls it
            result = analysis.analyze(problem, response, calc_second_order=False, seed=seed)
        indices.append([result[key] for key in ("S1", "S1_conf", "ST", "ST_conf")])
    return np.array(indices)

"""The surrogates by their names in ``study.toml``."""

from orchestrator.studies.design.gaussian_process import GaussianProcess
from orchestrator.studies.design.network import Network
from orchestrator.studies.design.quadratic import Quadratic
from orchestrator.studies.design.surrogates import Surrogate

SURROGATES: dict[str, type[Surrogate]] = {
    "gaussian-process": GaussianProcess,
    "quadratic": Quadratic,
    "network": Network,
}

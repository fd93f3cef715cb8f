"""The surrogates and optimisers by their names in ``study.toml``, with those of installed packages."""

from importlib.metadata import entry_points

from orchestrator.studies.design.gaussian_process import GaussianProcess
from orchestrator.studies.design.network import Network
from orchestrator.studies.design.optimisers import OPTIMISERS
from orchestrator.studies.design.quadratic import Quadratic
from orchestrator.studies.design.surrogates import Surrogate

SURROGATES: dict[str, type[Surrogate]] = {
    "gaussian-process": GaussianProcess,
    "quadratic": Quadratic,
    "network": Network,
}
SURROGATES |= {entry.name: entry.load() for entry in entry_points(group="flipflow.surrogates")}
OPTIMISERS |= {entry.name: entry.load() for entry in entry_points(group="flipflow.optimisers")}

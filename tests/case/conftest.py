"""The number of examples that the fuzzers try: as many as a few seconds allow, or thousands with ``pytest
tests/case --hypothesis-profile=long``."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

settings.register_profile(
    "long", max_examples=3000, deadline=None, print_blob=True, suppress_health_check=list(HealthCheck)
)

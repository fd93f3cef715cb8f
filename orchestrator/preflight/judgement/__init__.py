"""The judgement of effects in a case: their catalogue, and their verdicts weighed together."""

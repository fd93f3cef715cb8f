"""The records that a run writes into its folder."""

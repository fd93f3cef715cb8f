"""Many runs, and what they say together: sweeps, accuracy, hard cases, effects, the paper."""

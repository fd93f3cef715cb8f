"""The commands of ``flipflow study``, one module each."""

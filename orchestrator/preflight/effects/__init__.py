"""The effects that a scene may call for, one in each file (docs/theory/effects.md).

The name of a file is the name of its effect, and ``EFFECT`` defines it.  ``judgement/catalogue.py``
collects the effects.
"""

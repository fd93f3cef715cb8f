"""One file for each effect that a scene may call for (docs/theory/effects.md).

The file's name is the effect's, and its ``EFFECT`` is all there is to say of it;
``judgement/catalogue.py`` finds them.
"""

// Nothing of its own: the target that the precompiled GoogleTest headers belong to.

// CMake attaches precompiled headers to a target, and a target needs a source.

#pragma once

#include <pybind11/pybind11.h>

#include "engine.h"

namespace flipflow {

// The saved state as arrays by name, (n,) of float64 or int64, and back.
pybind11::dict save(Engine &engine);
void restore(Engine &engine, const pybind11::dict &arrays);

}  // namespace flipflow

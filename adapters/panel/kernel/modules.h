#pragma once

#include <pybind11/pybind11.h>

namespace flipflow {

void add_chain(pybind11::module_ &module);
void add_sheet(pybind11::module_ &module);

}  // namespace flipflow

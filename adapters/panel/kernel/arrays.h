#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "path.h"

// NumPy arrays as plain numbers.  Arrays are never converted: what is written to a copy would be
// lost.
namespace flipflow {

namespace py = pybind11;

using Doubles = py::array_t<double, py::array::c_style>;
using Ints = py::array_t<int, py::array::c_style>;

// The data of an array of `size` numbers.
inline const double *of(const Doubles &array, py::ssize_t size, const char *name) {
  if (array.size() != size)
    throw py::value_error(std::string(name) + ": " + std::to_string(size) + " numbers wanted, got " +
                          std::to_string(array.size()));
  return array.data();
}

inline double *into(Doubles &array, py::ssize_t size, const char *name) {
  of(array, size, name);
  return array.mutable_data();
}

template <class Array>
std::vector<typename Array::value_type> copied(const Array &array) {
  return {array.data(), array.data() + array.size()};
}

// The path of held points in arrays of `size` numbers.
inline HeldPath path_of(const Doubles &start_m, const Doubles &start_m_per_s, const Doubles &end_m,
             const Doubles &end_m_per_s, double length_s, py::ssize_t size) {
  return {of(start_m, size, "start_m"), of(start_m_per_s, size, "start_m_per_s"), of(end_m, size, "end_m"),
          of(end_m_per_s, size, "end_m_per_s"), length_s};
}

}  // namespace flipflow

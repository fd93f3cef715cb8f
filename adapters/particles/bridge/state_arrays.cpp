#include "state_arrays.h"

#include <pybind11/numpy.h>

#include <algorithm>

namespace py = pybind11;

namespace flipflow {

namespace {

template <class Value>
void to_arrays(const std::map<std::string, std::vector<Value>> &values, py::dict &arrays) {
  for (const auto &[name, value] : values) {
    py::array_t<Value> array(static_cast<py::ssize_t>(value.size()));
    std::copy(value.begin(), value.end(), array.mutable_data());
    arrays[py::str(name)] = array;
  }
}

template <class Value>
std::vector<Value> vector_of(const py::array_t<Value, py::array::c_style> &array) {
  return {array.data(), array.data() + array.size()};
}

}  // namespace

py::dict save(Engine &engine) {
  const SavedState saved = engine.save();
  py::dict arrays;
  to_arrays(saved.reals, arrays);
  to_arrays(saved.wholes, arrays);
  return arrays;
}

void restore(Engine &engine, const py::dict &arrays) {
  SavedState saved;
  for (const auto &[key, value] : arrays) {
    const auto name = key.cast<std::string>();
    const auto array = value.cast<py::array>();
    if (array.dtype().kind() == 'f')
      saved.reals[name] = vector_of<double>(array);
    else
      saved.wholes[name] = vector_of<std::int64_t>(array);
  }
  engine.restore(saved);
}

}  // namespace flipflow

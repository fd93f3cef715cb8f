// What a kernel is given by Python: arrays by their names.
//
// Every array is handed over by its name, and its size is checked under that name: several have the
// same size, so that two of them exchanged would not be noticed otherwise.  Arrays are never
// converted: what is written to a copy would be lost.

#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string>
#include <utility>
#include <vector>

namespace flipflow {

namespace py = pybind11;

template <class T>
using ArrayOf = py::array_t<T, py::array::c_style>;
using Doubles = ArrayOf<double>;

// The data of an array of `size` numbers.
inline const double *of(const Doubles &array, py::ssize_t size, const std::string &name) {
  if (array.size() != size)
    throw py::value_error(name + ": " + std::to_string(size) + " numbers wanted, got " +
                          std::to_string(array.size()));
  return array.data();
}

inline double *into(Doubles &array, py::ssize_t size, const std::string &name) {
  of(array, size, name);
  return array.mutable_data();
}

// What Python gives by name, each to be taken once: constants, which are copied, and the arrays of a
// state, which Python owns and which `arrays` keeps alive.
class Arguments {
 public:
  explicit Arguments(py::kwargs given) : given_(std::move(given)) {}

  std::vector<Doubles> arrays;

  template <class T>
  T number(const char *name) {
    return take(name).cast<T>();
  }

  template <class T = double>
  std::vector<T> copied(const char *name) {
    const auto array = taken_array<T>(name);
    return {array.data(), array.data() + array.size()};
  }

  std::vector<double> copied(const char *name, size_t size) {
    const auto array = taken_array<double>(name);
    const double *data = of(array, size, name);
    return {data, data + size};
  }

  double *state(const char *name, size_t size) {
    arrays.push_back(taken_array<double>(name));
    return into(arrays.back(), size, name);
  }

  void check_all_taken() const {
    for (const auto &item : given_)
      throw py::type_error("unknown argument " + py::str(item.first).cast<std::string>());
  }

 private:
  py::object take(const char *name) {
    if (!given_.contains(name)) throw py::type_error("missing argument " + std::string(name));
    return given_.attr("pop")(name);
  }

  template <class T>
  ArrayOf<T> taken_array(const char *name) {
    py::object array = take(name);
    if (!py::isinstance<ArrayOf<T>>(array))
      throw py::type_error(std::string(name) + ": not a contiguous array of the right type");
    return py::reinterpret_steal<ArrayOf<T>>(array.release());
  }

  py::kwargs given_;
};

}  // namespace flipflow

// adapters.panel._kernel: the explicit loops of sheet and strip, bound to Python.
//
// Every array is handed over by its name, and its size is checked under that name: several have the
// same size, so that two of them exchanged would not be noticed otherwise.  Arrays are never
// converted: what is written to a copy would be lost.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <string>
#include <utility>
#include <vector>

#include "chain.h"
#include "sheet.h"

namespace flipflow {

namespace {

namespace py = pybind11;

template <class T>
using ArrayOf = py::array_t<T, py::array::c_style>;
using Doubles = ArrayOf<double>;

// The data of an array of `size` numbers.
const double *of(const Doubles &array, py::ssize_t size, const std::string &name) {
  if (array.size() != size)
    throw py::value_error(name + ": " + std::to_string(size) + " numbers wanted, got " +
                          std::to_string(array.size()));
  return array.data();
}

double *into(Doubles &array, py::ssize_t size, const std::string &name) {
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

// A body and the state that it works on: pointers into `arrays`.
template <class Body, class State>
struct Bound {
  Body body;
  State state;
  std::vector<Doubles> arrays;

  void rest() { body.rest(state); }

  // In steps to the end of an interval; returns the work on the held points in J.
  double advance(const Doubles &start_m, const Doubles &start_m_per_s, const Doubles &end_m,
                 const Doubles &end_m_per_s, const Doubles &outside_N, double length_s, int steps,
                 Doubles impulse_N_s) {
    const py::ssize_t held = 3 * body.held();
    const HeldPath path = {of(start_m, held, "start_m"), of(start_m_per_s, held, "start_m_per_s"),
                           of(end_m, held, "end_m"), of(end_m_per_s, held, "end_m_per_s"), length_s};
    const double *force_N = of(outside_N, body.size(), "outside_N");
    double *impulse = into(impulse_N_s, held, "impulse_N_s");
    py::gil_scoped_release others_may_run;
    return body.advance(state, path, force_N, steps, impulse);
  }
};

using BoundSheet = Bound<Sheet, SheetState>;
using BoundChain = Bound<Chain, ChainState>;

BoundSheet bind_sheet(py::kwargs given) {
  Arguments from(std::move(given));
  const CellGrid grid = {from.copied("along_m"), from.copied("across_m")};
  const size_t cells = grid.cells(), nodes = grid.nodes(), size = 3 * nodes;
  const auto ratio = from.copied("ratio");
  const size_t branches = ratio.size(), groups = (cells + kLanes - 1) / kLanes;
  const size_t strains = groups * 9 * 3 * kLanes;
  const MembraneLaw law = {from.number<double>("c10_N_per_m"), from.number<double>("c01_N_per_m"),
                           from.copied("solid", cells), from.copied("rest"),
                           from.copied("strain_entries", 5 * cells)};
  if (!law.rest.empty() && law.rest.size() != 6 * cells)
    throw py::value_error("rest: six numbers of each cell wanted, or none");
  const auto offset = from.copied<int>("offset");
  Diagonals matrix(offset, from.copied("entry", offset.size() * nodes), static_cast<int>(nodes));
  Bending bending(std::move(matrix), from.copied("flat_m", size));
  Sheet body(Membrane(grid, law), std::move(bending),
             Branches(ratio, from.copied("time_s", branches)), from.copied("mobility_1_kg", nodes),
             from.copied<int>("held"));
  const SheetState state = {from.state("position_m", size),
                            from.state("velocity_m_per_s", size),
                            from.state("internal_N", size),
                            from.state("strain", strains),
                            from.state("strain_stress", strains * branches),
                            from.state("elastic_N", size),
                            from.state("bending_stress_N", size * branches),
                            from.state("energy_J", 2 * branches),
                            from.state("lost_J", 1)};
  from.check_all_taken();
  return {std::move(body), state, std::move(from.arrays)};
}

BoundChain bind_chain(py::kwargs given) {
  Arguments from(std::move(given));
  ChainParts parts;
  parts.bending_N_m3 = from.copied("bending_N_m3");
  const size_t bends = parts.bending_N_m3.size(), rows = bends + 2, size = 3 * rows;
  parts.mass_kg = from.copied("mass_kg", rows);
  parts.held = from.copied<int>("held");
  parts.free = from.copied<int>("free");
  parts.across = from.copied("across", 3);
  parts.share = from.copied("share", rows * parts.held.size());
  parts.first = from.number<int>("first");
  parts.rest_m = from.number<double>("rest_m");
  parts.c10_Pa = from.number<double>("c10_Pa");
  parts.c01_Pa = from.number<double>("c01_Pa");
  parts.area_m2 = from.copied("area_m2");
  parts.curvature_1_m2 = from.copied("curvature_1_m2", 3 * bends);
  parts.at_clamp = from.copied<int>("at_clamp");
  parts.along = from.copied("along", 3);
  if (parts.at_clamp.size() != bends || parts.first + parts.area_m2.size() >= rows)
    throw py::value_error("at_clamp, area_m2: springs, bends and rows do not fit together");
  const auto ratio = from.copied("ratio");
  const size_t branches = ratio.size(), strains = parts.strains();
  Chain body(std::move(parts), Branches(ratio, from.copied("time_s", branches)));
  const ChainState state = {from.state("position_m", size),     from.state("velocity_m_per_s", size),
                            from.state("internal_N", size),     from.state("strain", strains),
                            from.state("stress", strains * branches),
                            from.state("energy_J", branches),   from.state("lost_J", 1)};
  from.check_all_taken();
  return {std::move(body), state, std::move(from.arrays)};
}

// Binds what all bodies can do.
template <class BoundBody>
py::class_<BoundBody> add_body(py::module_ &module, const char *name, BoundBody (*bind)(py::kwargs)) {
  const auto array = [](const char *of_array) { return py::arg(of_array).noconvert(); };
  return py::class_<BoundBody>(module, name)
      .def(py::init(bind))
      .def("rest", &BoundBody::rest)
      .def("advance", &BoundBody::advance, py::kw_only(), array("start_m"), array("start_m_per_s"),
           array("end_m"), array("end_m_per_s"), array("outside_N"), py::arg("length_s"),
           py::arg("steps"), array("impulse_N_s"));
}

}  // namespace

}  // namespace flipflow

PYBIND11_MODULE(_kernel, module) {
  using namespace flipflow;
  module.attr("LANES") = kLanes;
  add_body(module, "Chain", bind_chain);
  add_body(module, "Sheet", bind_sheet).def("membrane_J", [](const BoundSheet &sheet) {
    return sheet.body.membrane_J(sheet.state.position_m);
  });
}

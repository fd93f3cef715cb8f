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

using Doubles = py::array_t<double, py::array::c_style>;
using Ints = py::array_t<int, py::array::c_style>;

// An argument that is given by its name and never converted.
py::arg array(const char *name) { return py::arg(name).noconvert(); }

// The data of an array of `size` numbers.
const double *of(const Doubles &array, py::ssize_t size, const char *name) {
  if (array.size() != size)
    throw py::value_error(std::string(name) + ": " + std::to_string(size) + " numbers wanted, got " +
                          std::to_string(array.size()));
  return array.data();
}

double *into(Doubles &array, py::ssize_t size, const char *name) {
  of(array, size, name);
  return array.mutable_data();
}

template <class Array>
std::vector<typename Array::value_type> copied(const Array &array) {
  return {array.data(), array.data() + array.size()};
}

// A body and the state that it works on: pointers into `arrays`, which Python owns and which are kept
// alive here.
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

// Binds what all bodies can do.
template <class BoundBody>
void add_motion(py::class_<BoundBody> &bound) {
  bound.def("rest", &BoundBody::rest)
      .def("advance", &BoundBody::advance, py::kw_only(), array("start_m"), array("start_m_per_s"),
           array("end_m"), array("end_m_per_s"), array("outside_N"), py::arg("length_s"),
           py::arg("steps"), array("impulse_N_s"));
}

using BoundSheet = Bound<Sheet, SheetState>;

Sheet sheet(const Doubles &along_m, const Doubles &across_m, double c10_N_per_m, double c01_N_per_m,
            const Doubles &solid, const Doubles &rest, const Doubles &strain_entries,
            const Ints &offset, const Doubles &entry, const Doubles &flat_m,
            const Doubles &mobility_1_kg, const Ints &held, const Doubles &ratio,
            const Doubles &time_s) {
  const CellGrid grid = {copied(along_m), copied(across_m)};
  const py::ssize_t cells = grid.cells(), nodes = grid.nodes();
  of(solid, cells, "solid");
  of(rest, rest.size() ? 6 * cells : 0, "rest");
  of(strain_entries, 5 * cells, "strain_entries");
  of(entry, offset.size() * nodes, "entry");
  of(flat_m, 3 * nodes, "flat_m");
  of(mobility_1_kg, nodes, "mobility_1_kg");
  of(time_s, ratio.size(), "time_s");
  const MembraneLaw law = {c10_N_per_m, c01_N_per_m, copied(solid), copied(rest),
                           copied(strain_entries)};
  Diagonals matrix(copied(offset), entry.data(), static_cast<int>(nodes));
  return Sheet(Membrane(grid, law), Bending(std::move(matrix), copied(flat_m)),
               Branches(copied(ratio), copied(time_s)), mobility_1_kg.data(),
               static_cast<int>(nodes), copied(held));
}

void add_sheet(py::module_ &module) {
  module.attr("LANES") = kLanes;
  py::class_<BoundSheet> bound(module, "Sheet");
  bound.def(
      py::init([](const Doubles &along_m, const Doubles &across_m, double c10_N_per_m,
                  double c01_N_per_m, const Doubles &solid, const Doubles &rest,
                  const Doubles &strain_entries, const Ints &offset, const Doubles &entry,
                  const Doubles &flat_m, const Doubles &mobility_1_kg, const Ints &held,
                  const Doubles &ratio, const Doubles &time_s, Doubles position_m,
                  Doubles velocity_m_per_s, Doubles internal_N, Doubles strain,
                  Doubles strain_stress, Doubles elastic_N, Doubles bending_stress_N,
                  Doubles energy_J, Doubles lost_J) {
        Sheet body = sheet(along_m, across_m, c10_N_per_m, c01_N_per_m, solid, rest, strain_entries,
                           offset, entry, flat_m, mobility_1_kg, held, ratio, time_s);
        const py::ssize_t size = body.size(), points = 9 * body.groups() * kLanes;
        const py::ssize_t branches = body.branches();
        const SheetState state = {into(position_m, size, "position_m"),
                                  into(velocity_m_per_s, size, "velocity_m_per_s"),
                                  into(internal_N, size, "internal_N"),
                                  into(strain, 3 * points, "strain"),
                                  into(strain_stress, 3 * points * branches, "strain_stress"),
                                  into(elastic_N, size, "elastic_N"),
                                  into(bending_stress_N, size * branches, "bending_stress_N"),
                                  into(energy_J, 2 * branches, "energy_J"),
                                  into(lost_J, 1, "lost_J")};
        return BoundSheet{std::move(body), state,
                          {position_m, velocity_m_per_s, internal_N, strain, strain_stress,
                           elastic_N, bending_stress_N, energy_J, lost_J}};
      }),
      py::kw_only(), array("along_m"), array("across_m"), py::arg("c10_N_per_m"),
      py::arg("c01_N_per_m"), array("solid"), array("rest"), array("strain_entries"),
      array("offset"), array("entry"), array("flat_m"), array("mobility_1_kg"), array("held"),
      array("ratio"), array("time_s"), array("position_m"), array("velocity_m_per_s"),
      array("internal_N"), array("strain"), array("strain_stress"), array("elastic_N"),
      array("bending_stress_N"), array("energy_J"), array("lost_J"));
  bound.def("membrane_J", [](const BoundSheet &sheet) {
    return sheet.body.membrane_J(sheet.state.position_m);
  });
  add_motion(bound);
}

using BoundChain = Bound<Chain, ChainState>;

Chain chain(int first, double rest_m, double c10_Pa, double c01_Pa, const Doubles &area_m2,
            const Doubles &bending_N_m3, const Doubles &curvature_1_m2, const Ints &at_clamp,
            const Doubles &along, const Doubles &mass_kg, const Ints &held, const Ints &free,
            const Doubles &across, const Doubles &share, const Doubles &ratio,
            const Doubles &time_s) {
  of(curvature_1_m2, 3 * bending_N_m3.size(), "curvature_1_m2");
  of(along, 3, "along");
  of(mass_kg, bending_N_m3.size() + 2, "mass_kg");
  of(across, 3, "across");
  of(share, mass_kg.size() * held.size(), "share");
  of(time_s, ratio.size(), "time_s");
  if (at_clamp.size() != bending_N_m3.size() || first + area_m2.size() >= mass_kg.size())
    throw py::value_error("at_clamp, area_m2: springs, bends and rows do not fit together");
  const ChainLinks links = {first, rest_m, c10_Pa, c01_Pa, copied(area_m2), copied(bending_N_m3),
                            copied(curvature_1_m2), copied(at_clamp), copied(along)};
  const ChainRows rows = {copied(mass_kg), copied(held), copied(free), copied(across),
                          copied(share)};
  return Chain(ChainForce(links), rows, Branches(copied(ratio), copied(time_s)));
}

void add_chain(py::module_ &module) {
  py::class_<BoundChain> bound(module, "Chain");
  bound.def(
      py::init([](int first, double rest_m, double c10_Pa, double c01_Pa, const Doubles &area_m2,
                  const Doubles &bending_N_m3, const Doubles &curvature_1_m2, const Ints &at_clamp,
                  const Doubles &along, const Doubles &mass_kg, const Ints &held, const Ints &free,
                  const Doubles &across, const Doubles &share, const Doubles &ratio,
                  const Doubles &time_s, Doubles position_m, Doubles velocity_m_per_s,
                  Doubles internal_N, Doubles strain, Doubles stress, Doubles energy_J,
                  Doubles lost_J) {
        Chain body = chain(first, rest_m, c10_Pa, c01_Pa, area_m2, bending_N_m3, curvature_1_m2,
                           at_clamp, along, mass_kg, held, free, across, share, ratio, time_s);
        const py::ssize_t size = body.size(), branches = body.branches();
        const ChainState state = {into(position_m, size, "position_m"),
                                  into(velocity_m_per_s, size, "velocity_m_per_s"),
                                  into(internal_N, size, "internal_N"),
                                  into(strain, body.strains(), "strain"),
                                  into(stress, body.strains() * branches, "stress"),
                                  into(energy_J, branches, "energy_J"),
                                  into(lost_J, 1, "lost_J")};
        return BoundChain{std::move(body), state,
                          {position_m, velocity_m_per_s, internal_N, strain, stress, energy_J,
                           lost_J}};
      }),
      py::kw_only(), py::arg("first"), py::arg("rest_m"), py::arg("c10_Pa"), py::arg("c01_Pa"),
      array("area_m2"), array("bending_N_m3"), array("curvature_1_m2"), array("at_clamp"),
      array("along"), array("mass_kg"), array("held"), array("free"), array("across"),
      array("share"), array("ratio"), array("time_s"), array("position_m"),
      array("velocity_m_per_s"), array("internal_N"), array("strain"), array("stress"),
      array("energy_J"), array("lost_J"));
  add_motion(bound);
}

}  // namespace

}  // namespace flipflow

PYBIND11_MODULE(_kernel, module) {
  flipflow::add_chain(module);
  flipflow::add_sheet(module);
}

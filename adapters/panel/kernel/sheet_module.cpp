#include "bound.h"
#include "modules.h"
#include "sheet.h"

namespace flipflow {

SheetState state_of(const Sheet &sheet, std::vector<Doubles> &arrays) {
  const py::ssize_t size = sheet.size(), points = 9 * sheet.groups() * kLanes;
  const py::ssize_t branches = sheet.branches();
  const auto at = [&](size_t k, py::ssize_t wanted, const char *name) {
    return into(arrays.at(k), wanted, name);
  };
  return {at(0, size, "position_m"),
          at(1, size, "velocity_m_per_s"),
          at(2, size, "internal_N"),
          at(3, 3 * points, "strain"),
          at(4, 3 * points * branches, "strain_stress"),
          at(5, size, "elastic_N"),
          at(6, size * branches, "bending_stress_N"),
          at(7, 2 * branches, "energy_J"),
          at(8, 1, "lost_J")};
}

namespace {

using BoundSheet = Bound<Sheet, SheetState>;

Sheet sheet(const Doubles &along_m, const Doubles &across_m, double c10_N_per_m, double c01_N_per_m,
            const Doubles &solid, const Doubles &rest, const Doubles &strain, const Ints &offset,
            const Doubles &entry, const Doubles &flat_m, const Doubles &mobility_1_kg,
            const Ints &held, const Doubles &ratio, const Doubles &time_s) {
  const CellGrid grid = {copied(along_m), copied(across_m)};
  const py::ssize_t cells = grid.cells(), nodes = grid.nodes();
  of(solid, cells, "solid");
  of(rest, rest.size() ? 6 * cells : 0, "rest");
  of(strain, 5 * cells, "strain");
  of(entry, offset.size() * nodes, "entry");
  of(flat_m, 3 * nodes, "flat_m");
  of(mobility_1_kg, nodes, "mobility_1_kg");
  of(time_s, ratio.size(), "time_s");
  const MembraneLaw law = {c10_N_per_m, c01_N_per_m, copied(solid), copied(rest), copied(strain)};
  Diagonals matrix(copied(offset), entry.data(), static_cast<int>(nodes));
  return Sheet(Membrane(grid, law), Bending(std::move(matrix), copied(flat_m)),
               Branches(copied(ratio), copied(time_s)), mobility_1_kg.data(),
               static_cast<int>(nodes), copied(held));
}

}  // namespace

void add_sheet(py::module_ &module) {
  module.attr("LANES") = kLanes;
  py::class_<BoundSheet> bound(module, "Sheet");
  bound.def(py::init([](const Doubles &along_m, const Doubles &across_m, double c10_N_per_m,
                       double c01_N_per_m, const Doubles &solid, const Doubles &rest,
                       const Doubles &strain, const Ints &offset, const Doubles &entry,
                       const Doubles &flat_m, const Doubles &mobility_1_kg, const Ints &held,
                       const Doubles &ratio, const Doubles &time_s, std::vector<Doubles> state) {
             return BoundSheet(
                 sheet(along_m, across_m, c10_N_per_m, c01_N_per_m, solid, rest, strain, offset, entry,
                       flat_m, mobility_1_kg, held, ratio, time_s),
                 std::move(state));
           }),
           py::kw_only(), py::arg("along_m"), py::arg("across_m"), py::arg("c10_N_per_m"),
           py::arg("c01_N_per_m"), py::arg("solid"), py::arg("rest"), py::arg("strain"),
           py::arg("offset"), py::arg("entry"), py::arg("flat_m"), py::arg("mobility_1_kg"),
           py::arg("held"), py::arg("ratio"), py::arg("time_s"), py::arg("state").noconvert())
      .def("membrane_J", [](const BoundSheet &sheet) {
        return sheet.body().membrane_J(sheet.state().position_m);
      });
  add_motion(bound);
}

}  // namespace flipflow

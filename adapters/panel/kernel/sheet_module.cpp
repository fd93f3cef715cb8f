#include "arrays.h"
#include "modules.h"
#include "sheet.h"

namespace flipflow {

namespace {

// Keeps the arrays of the state alive and of the right size.
class BoundSheet {
 public:
  BoundSheet(Sheet sheet, std::vector<Doubles> arrays)
      : sheet_(std::move(sheet)), arrays_(std::move(arrays)) {
    const py::ssize_t size = sheet_.size(), points = 9 * sheet_.groups() * kLanes;
    const py::ssize_t branches = sheet_.branches();
    const auto at = [&](size_t k, py::ssize_t wanted, const char *name) {
      return into(arrays_.at(k), wanted, name);
    };
    state_ = {at(0, size, "position_m"),
              at(1, size, "velocity_m_s"),
              at(2, size, "internal_N"),
              at(3, 3 * points, "strain"),
              at(4, 3 * points * branches, "strain_stress"),
              at(5, size, "elastic_N"),
              at(6, size * branches, "bending_stress_N"),
              at(7, 2 * branches, "energy_J"),
              at(8, 1, "lost_J")};
  }

  void rest() { sheet_.rest(state_); }

  double membrane_J() const { return sheet_.membrane_J(state_.position_m); }

  double advance(const Doubles &start_m, const Doubles &start_m_s, const Doubles &end_m,
                 const Doubles &end_m_s, const Doubles &outside_N, double length_s, int steps,
                 Doubles impulse_N_s) {
    const py::ssize_t held = 3 * sheet_.held();
    const HeldPath path = path_of(start_m, start_m_s, end_m, end_m_s, length_s, held);
    const double *force_N = of(outside_N, sheet_.size(), "outside_N");
    double *impulse = into(impulse_N_s, held, "impulse_N_s");
    py::gil_scoped_release others_may_run;
    return sheet_.advance(state_, path, force_N, steps, impulse);
  }

 private:
  Sheet sheet_;
  std::vector<Doubles> arrays_;
  SheetState state_;
};

Sheet sheet(const Doubles &along_m, const Doubles &across_m, double c10_N_m, double c01_N_m,
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
  const MembraneLaw law = {c10_N_m, c01_N_m, copied(solid), copied(rest), copied(strain)};
  Diagonals matrix(copied(offset), entry.data(), static_cast<int>(nodes));
  return Sheet(Membrane(grid, law), Bending(std::move(matrix), copied(flat_m)),
               Branches(copied(ratio), copied(time_s)), mobility_1_kg.data(),
               static_cast<int>(nodes), copied(held));
}

}  // namespace

void add_sheet(py::module_ &module) {
  module.attr("LANES") = kLanes;
  py::class_<BoundSheet>(module, "Sheet")
      .def(py::init([](const Doubles &along_m, const Doubles &across_m, double c10_N_m,
                       double c01_N_m, const Doubles &solid, const Doubles &rest,
                       const Doubles &strain, const Ints &offset, const Doubles &entry,
                       const Doubles &flat_m, const Doubles &mobility_1_kg, const Ints &held,
                       const Doubles &ratio, const Doubles &time_s, std::vector<Doubles> state) {
             return BoundSheet(
                 sheet(along_m, across_m, c10_N_m, c01_N_m, solid, rest, strain, offset, entry,
                       flat_m, mobility_1_kg, held, ratio, time_s),
                 std::move(state));
           }),
           py::kw_only(), py::arg("along_m"), py::arg("across_m"), py::arg("c10_N_m"),
           py::arg("c01_N_m"), py::arg("solid"), py::arg("rest"), py::arg("strain"),
           py::arg("offset"), py::arg("entry"), py::arg("flat_m"), py::arg("mobility_1_kg"),
           py::arg("held"), py::arg("ratio"), py::arg("time_s"), py::arg("state").noconvert())
      .def("rest", &BoundSheet::rest)
      .def("membrane_J", &BoundSheet::membrane_J)
      .def("advance", &BoundSheet::advance, py::arg("start_m").noconvert(),
           py::arg("start_m_s").noconvert(), py::arg("end_m").noconvert(),
           py::arg("end_m_s").noconvert(), py::arg("outside_N").noconvert(), py::arg("length_s"),
           py::arg("steps"), py::arg("impulse_N_s").noconvert());
}

}  // namespace flipflow

// adapters.panel._kernel: the explicit loops of sheet and strip, bound to Python.

#include <pybind11/stl.h>

#include "../../kernel_arguments.h"
#include "chain.h"
#include "sheet.h"

namespace flipflow {

namespace {

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
    const double *force_N = of(outside_N, 3 * body.points(), "outside_N");
    double *impulse = into(impulse_N_s, held, "impulse_N_s");
    py::gil_scoped_release others_may_run;
    return body.advance(state, path, force_N, steps, impulse);
  }
};

using BoundSheet = Bound<Sheet, SheetState>;
using BoundChain = Bound<Chain, ChainState>;

// Moves panels of one kind to the end of an interval, between clamps that reach the motion given,
// under loads on their surface points; the arrays have one panel after the other.  Returns what `pass`
// of each body says of it.
template <class BoundBody>
auto advance_together(const std::vector<BoundBody *> &panels, const Doubles &clamps_m,
                      const Doubles &clamps_m_per_s, const Doubles &load_N, double length_s,
                      const std::vector<int> &steps, Doubles surface_m, Doubles surface_m_per_s,
                      Doubles reaction_N) {
  py::ssize_t held = 0, size = 0;
  for (const BoundBody *panel : panels)
    held += 3 * panel->body.clamp_points(), size += 3 * panel->body.surface_points();
  const double *end_m = of(clamps_m, held, "clamps_m");
  const double *end_m_per_s = of(clamps_m_per_s, held, "clamps_m_per_s");
  const double *given_N = of(load_N, size, "load_N");
  PanelSurface surface = {into(surface_m, size, "surface_m"),
                          into(surface_m_per_s, size, "surface_m_per_s")};
  double *given_back_N = into(reaction_N, held, "reaction_N");
  if (steps.size() != panels.size()) throw py::value_error("steps: one number for each panel wanted");
  py::gil_scoped_release others_may_run;
  std::vector<decltype(panels[0]->body.pass(panels[0]->state, {}, surface, given_back_N))> found;
  for (size_t n = 0; n < panels.size(); ++n) {
    auto &body = panels[n]->body;
    const PanelInterval now = {end_m, end_m_per_s, given_N, length_s, steps[n]};
    found.push_back(body.pass(panels[n]->state, now, surface, given_back_N));
    const int of_clamps = 3 * body.clamp_points(), of_surface = 3 * body.surface_points();
    end_m += of_clamps, end_m_per_s += of_clamps, given_back_N += of_clamps;
    given_N += of_surface, surface.position_m += of_surface, surface.velocity_m_per_s += of_surface;
  }
  return found;
}

void check_node(int node, size_t nodes, const std::string &name) {
  if (node < 0 || static_cast<size_t>(node) >= nodes)
    throw py::value_error(name + ": no node has the number " + std::to_string(node));
}

BoundSheet bind_sheet(py::kwargs given) {
  Arguments from(std::move(given));
  const CellGrid grid = {from.copied("along_m"), from.copied("across_m")};
  const NodePlaces places(grid);
  const size_t cells = grid.cells(), nodes = grid.nodes(), size = 3 * places.size();
  const auto ratio = from.copied("ratio");
  const size_t branches = ratio.size(), strains = places.groups() * 9 * 3 * kLanes;
  const MembraneLaw law = {from.number<double>("c10_N_per_m"), from.number<double>("c01_N_per_m"),
                           from.copied("solid", cells), from.copied("rest"),
                           from.copied("strain_entries", 5 * cells)};
  if (!law.rest.empty() && law.rest.size() != 6 * cells)
    throw py::value_error("rest: six numbers of each cell wanted, or none");
  const auto row = from.copied<int>("row"), column = from.copied<int>("column");
  if (row.size() != column.size()) throw py::value_error("row, column: not equally many");
  for (const int node : row) check_node(node, nodes, "row");
  for (const int node : column) check_node(node, nodes, "column");
  const MatrixEntries bending = {row, column, from.copied("entry", row.size())};
  SheetNodes of_nodes = {from.copied("mobility_1_kg", nodes), from.copied("mass_kg", nodes),
                         from.copied("weight_N", 3 * nodes), from.copied("flat_m", 3 * nodes),
                         from.copied<int>("held"), from.copied<int>("joined")};
  for (const int node : of_nodes.held) check_node(node, nodes, "held");
  for (const int node : of_nodes.joined) check_node(node, nodes, "joined");
  if (of_nodes.joined.size() % 2) throw py::value_error("joined: pairs of nodes wanted");
  Sheet body(grid, law, bending, Branches(ratio, from.copied("time_s", branches)), std::move(of_nodes));
  const SheetState state = {from.state("position_m", size),
                            from.state("velocity_m_per_s", size),
                            from.state("internal_N", size),
                            from.state("strain", strains),
                            from.state("strain_stress", strains * branches),
                            from.state("elastic_N", size),
                            from.state("bending_stress_N", size * branches),
                            from.state("energy_J", 2 * branches),
                            from.state("lost_J", 1),
                            from.state("received_J", 2)};
  from.check_all_taken();
  return {std::move(body), state, std::move(from.arrays)};
}

// Of a sheet of so many cells: the places of its nodes, the number of all places, and the shape of its
// Gauss points, which is (groups of cells, points of each, cells of a group).
py::tuple sheet_places(int along, int across) {
  const CellGrid grid = {std::vector<double>(along), std::vector<double>(across)};
  const NodePlaces places(grid);
  std::vector<int> of_nodes(grid.nodes());
  for (int node = 0; node < grid.nodes(); ++node) of_nodes[node] = places.of_node(node);
  return py::make_tuple(of_nodes, places.size(), py::make_tuple(places.groups(), 9, kLanes));
}

BoundChain bind_chain(py::kwargs given) {
  Arguments from(std::move(given));
  ChainParts parts;
  parts.bending_N_m3 = from.copied("bending_N_m3");
  const size_t bends = parts.bending_N_m3.size(), rows = bends + 2, size = 3 * rows;
  parts.mass_kg = from.copied("mass_kg", rows);
  parts.weight_N = from.copied("weight_N", size);
  parts.held = from.copied<int>("held");
  parts.free = from.copied<int>("free");
  parts.across = from.copied("across", 3);
  parts.share = from.copied("share", rows * parts.held.size());
  parts.first = from.number<int>("first");
  parts.rest_m = from.number<double>("rest_m");
  parts.c10_Pa = from.number<double>("c10_Pa");
  parts.c01_Pa = from.number<double>("c01_Pa");
  parts.sheared_Pa = from.number<double>("sheared_Pa");
  parts.area_m2 = from.copied("area_m2");
  parts.branch_N_per_m = from.copied("branch_N_per_m", parts.area_m2.size());
  parts.curvature_1_m2 = from.copied("curvature_1_m2", 3 * bends);
  parts.at_clamp = from.copied<int>("at_clamp");
  parts.along = from.copied("along", 3 * bends);
  parts.gap_m = from.copied("gap_m", rows - 1);
  parts.moulded_N_m = from.copied("moulded_N_m", bends);
  if (parts.at_clamp.size() != bends || parts.first + parts.area_m2.size() >= rows)
    throw py::value_error("at_clamp, area_m2: springs, bends and rows do not fit together");
  const auto ratio = from.copied("ratio");
  const size_t branches = ratio.size(), strains = parts.strains(), held = 3 * parts.held.size();
  Chain body(std::move(parts), Branches(ratio, from.copied("time_s", branches)));
  const ChainState state = {from.state("position_m", size),
                            from.state("velocity_m_per_s", size),
                            from.state("internal_N", size),
                            from.state("strain", strains),
                            from.state("stress", strains * branches),
                            from.state("energy_J", branches),
                            from.state("lost_J", 1),
                            from.state("clamp_half_m", held),
                            from.state("received_J", 2)};
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

// Binds the call that advances several bodies of one kind.
template <class BoundBody>
void add_joint_advance(py::module_ &module) {
  const auto array = [](const char *name) { return py::arg(name).noconvert(); };
  module.def("advance_together", &advance_together<BoundBody>, py::arg("panels"), py::kw_only(),
             array("clamps_m"), array("clamps_m_per_s"), array("load_N"), py::arg("length_s"),
             py::arg("steps"), array("surface_m"), array("surface_m_per_s"), array("reaction_N"));
}

}  // namespace

}  // namespace flipflow

PYBIND11_MODULE(_kernel, module) {
  using namespace flipflow;
  module.def("sheet_places", sheet_places, py::arg("along"), py::arg("across"));
  add_body(module, "Chain", bind_chain);
  add_body(module, "Sheet", bind_sheet).def("membrane_J", [](const BoundSheet &sheet) {
    return sheet.body.membrane_J(sheet.state.position_m);
  });
  add_joint_advance<BoundChain>(module);
  add_joint_advance<BoundSheet>(module);
}

#pragma once

#include <vector>

#include "lanes.h"
#include "maxwell.h"

namespace flipflow {

// A rectangular grid of biquadratic cells; nodes and cells are numbered with y running fastest.
struct CellGrid {
  std::vector<double> along_m, across_m;  // lengths of the cells in each direction

  int cells() const { return static_cast<int>(along_m.size() * across_m.size()); }
  int nodes_across() const { return 2 * static_cast<int>(across_m.size()) + 1; }
  int nodes() const { return (2 * static_cast<int>(along_m.size()) + 1) * nodes_across(); }
};

// What a cell is made of, in N/m: Mooney-Rivlin constants times thickness, of which a cell has the
// share `solid` (cells); on top the quadratic law `rest` (cells, 6: 11, 22, 33, 12, 13, 23) in the
// strain (C - 1/C) / 4, if any cell has it; `strain` (cells, 5) makes the scaled strain of the
// branches from E: (s0 E11 + s1 E22, s2 E11 + s3 E22, s4 2 E12).
struct MembraneLaw {
  double c10_N_per_m, c01_N_per_m;
  std::vector<double> solid, rest, strain;
};

// Several cells side by side.  The last group is filled up with copies of no area.
struct alignas(kLanes * sizeof(double)) CellGroup {
  double per_s2[kLanes], per_sy[kLanes], per_y2[kLanes];  // 1 / (products of two cell lengths)
  double area[kLanes], solid[kLanes], rest[6][kLanes], strain[5][kLanes];
  int corner[kLanes];  // lowest node
};

// What the loops over the cells need; see Membrane::step.  `cross_J` (branches, kLanes) and `square_J`
// (kLanes) are added to.
struct MembranePass {
  const CellGroup *group;
  int groups, nodes_across;
  double c10_N_per_m, c01_N_per_m;
  bool perforated;
  const Branches *branches = nullptr;
  const double *position_m = nullptr;
  double *strain = nullptr, *stress = nullptr, *force_N = nullptr;
  double *cross_J = nullptr, *square_J = nullptr;
};

// Force and energy of the membrane (adapters/panel/finite_element/sheet_forms.py, perforated_sheet.py).
class Membrane {
 public:
  Membrane(const CellGrid &grid, const MembraneLaw &law);

  int groups() const { return static_cast<int>(groups_.size()); }

  // Adds the force at `position_m` to `force_N`, both (nodes, 3), and carries the scaled strain
  // (groups, 9, 3, kLanes) and the branches' stresses (groups, 9, branches, 3, kLanes) there.
  StepWork step(const Branches &branches, const double *position_m, double *strain,
                double *stress, double *force_N) const;

  double energy_J(const double *position_m) const;

 private:
  MembranePass pass() const;

  std::vector<CellGroup> groups_;
  double c10_N_per_m_, c01_N_per_m_;
  int nodes_across_;
  bool perforated_;
};

}  // namespace flipflow

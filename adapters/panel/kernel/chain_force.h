#pragma once

#include <vector>

#include "maxwell.h"

namespace flipflow {

// Rows joined by axial springs and bending springs: what adapters/panel/strip/chain.py describes.
struct ChainLinks {
  int first;                                 // row where the springs begin
  double rest_m, c10_Pa, c01_Pa;             // of every spring
  std::vector<double> area_m2;               // (springs)
  std::vector<double> bending_N_m3;          // (bends)
  std::vector<double> curvature_1_m2;        // (bends, 3): of rows k, k + 1, k + 2 in bend k
  std::vector<int> at_clamp;                 // (bends): does the bend count across `along` only?
  std::vector<double> along;                 // (3) unit vector

  int springs() const { return static_cast<int>(area_m2.size()); }
  int bends() const { return static_cast<int>(bending_N_m3.size()); }
  int strains() const { return springs() + 3 * bends(); }
};

// Force of springs, bending springs and the branches on both.
class ChainForce {
 public:
  explicit ChainForce(ChainLinks links);

  int strains() const { return links_.strains(); }

  // Adds the force at `position_m` to `force_N`, both (rows, 3), and carries `strain`, the springs'
  // lengths, then the curvatures (bends, 3), and the branches' stresses (branches, strains) there.
  StepWork step(const Branches &branches, const double *position_m, double *strain, double *stress,
                double *force_N);

 private:
  void find_strain(const double *position_m);
  StepWork find_overstress(const Branches &branches, double *strain, double *stress);

  ChainLinks links_;
  std::vector<double> stiffness_, strain_, over_;  // (strains)
  std::vector<double> direction_;                  // (springs, 3)
};

}  // namespace flipflow

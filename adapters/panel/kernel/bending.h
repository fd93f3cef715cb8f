#pragma once

#include <vector>

#include "maxwell.h"

namespace flipflow {

// A matrix (nodes, nodes) times a field of vectors (nodes, 3), by diagonals: in the grid's
// numbering its entries stand on a few dozen of them, so that rows side by side need values side by
// side and nothing is looked up.
class Diagonals {
 public:
  // `offset` is column minus row; `entry` (offsets, nodes) by row, zero where there is none.
  Diagonals(std::vector<int> offset, const double *entry, int nodes);

  int nodes() const { return nodes_; }

  // product = matrix * (position - flat), all (nodes, 3).
  void multiply(const double *position, const double *flat, double *product);

 private:
  int nodes_, padded_, margin_;
  std::vector<int> offset_;
  std::vector<double> entry_;   // (blocks of kLanes rows, offsets, kLanes)
  std::vector<double> column_;  // (3, padded nodes with zeros around)
  std::vector<double> result_;  // (3, padded nodes)
};

// Force of a constant stiffness matrix, with Maxwell branches on the nodes' displacement.
class Bending {
 public:
  Bending(Diagonals matrix, std::vector<double> flat_m)
      : matrix_(std::move(matrix)),
        flat_m_(std::move(flat_m)),
        product_(flat_m_.size()),
        moved_(flat_m_.size()) {}

  // Adds the force at `position_m` to `force_N`, and carries the elastic force (nodes, 3) and the
  // branches' stresses (branches, nodes, 3) there from `before_m`.
  StepWork step(const Branches &branches, const double *before_m, const double *position_m,
                double *elastic_N, double *stress_N, double *force_N);

 private:
  Diagonals matrix_;
  std::vector<double> flat_m_, product_, moved_;
};

}  // namespace flipflow

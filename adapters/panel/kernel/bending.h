#pragma once

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "lanes.h"
#include "maxwell.h"

namespace flipflow {

// A matrix (nodes, nodes) times a field of vectors (nodes, 3), by diagonals: in the grid's
// numbering its entries stand on a few dozen of them, so that rows side by side need values side by
// side and nothing is looked up.
class Diagonals {
 public:
  // `offset` is column minus row; `entry` (offsets, nodes) by row, zero where there is none.
  Diagonals(std::vector<int> offset, const std::vector<double> &entry, int nodes)
      : nodes_(nodes),
        padded_((nodes + kLanes - 1) / kLanes * kLanes),
        offset_(std::move(offset)),
        entry_(offset_.size() * padded_),
        result_(3 * padded_) {
    for (const int o : offset_) margin_ = std::max(margin_, std::abs(o));
    column_.resize(3 * (padded_ + 2 * margin_));
    for (size_t k = 0; k < offset_.size(); ++k)
      for (int row = 0; row < nodes; ++row)
        entry_[(row / kLanes * offset_.size() + k) * kLanes + row % kLanes] =
            entry[k * nodes + row];
  }

  // product = matrix * (position - flat), all (nodes, 3).
  void multiply(const double *position, const double *flat, double *product) {
    double *const column[3] = {component(0), component(1), component(2)};
    for (int node = 0; node < nodes_; ++node)
      for (int c = 0; c < 3; ++c) column[c][node] = position[3 * node + c] - flat[3 * node + c];
    static const auto multiply_here = fitting(multiply_v4, multiply_v3, multiply_any);
    multiply_here(*this);
    for (int node = 0; node < nodes_; ++node)
      for (int c = 0; c < 3; ++c) product[3 * node + c] = result_[c * padded_ + node];
  }

 private:
  double *component(int c) { return &column_[c * (padded_ + 2 * margin_) + margin_]; }

  FLIPFLOW_V4 static void multiply_v4(Diagonals &d) { d.multiply_rows<Eight>(); }
  FLIPFLOW_V3 static void multiply_v3(Diagonals &d) { d.multiply_rows<Four>(); }
  static void multiply_any(Diagonals &d) { d.multiply_rows<Two>(); }

  template <class V>
  FLIPFLOW_INLINE void multiply_rows() {
    const size_t entries = offset_.size() * kLanes;
    const double *const column[3] = {component(0), component(1), component(2)};
    for (int row = 0; row < padded_; row += kWidth<V>) {
      const double *entry = entry_.data() + row / kLanes * entries + row % kLanes;
      V x{}, y{}, z{};
      for (const int to_column : offset_) {
        const V a = load<V>(entry);
        x += a * load<V>(column[0] + row + to_column);
        y += a * load<V>(column[1] + row + to_column);
        z += a * load<V>(column[2] + row + to_column);
        entry += kLanes;
      }
      store(result_.data() + row, x);
      store(result_.data() + padded_ + row, y);
      store(result_.data() + 2 * padded_ + row, z);
    }
  }

  int nodes_, padded_, margin_ = 0;
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
                double *elastic_N, double *stress_N, double *force_N) {
    const int size = static_cast<int>(product_.size());
    matrix_.multiply(position_m, flat_m_.data(), product_.data());
    for (int i = 0; i < size; ++i) moved_[i] = position_m[i] - before_m[i];
    StepWork work(branches.count());
    work.square_J = add_elastic(size, moved_.data(), elastic_N, product_.data(), force_N);
    for (int b = 0; b < branches.count(); ++b, stress_N += size)
      work.cross_J[b] =
          add_branch(size, branches.ratio()[b], branches.decay()[b], branches.gain()[b],
                     moved_.data(), product_.data(), stress_N, force_N);
    return work;
  }

 private:
  // What the elastic force changes by stands in `change` afterwards.
  FLIPFLOW_CLONES
  static double add_elastic(int size, const double *moved_m, double *elastic_N, double *change,
                            double *force_N) {
    double square_J = 0.0;
#pragma omp simd reduction(+ : square_J)
    for (int i = 0; i < size; ++i) {
      const double now = change[i];
      change[i] = now - elastic_N[i];
      elastic_N[i] = now;
      force_N[i] += now;
      square_J += change[i] * moved_m[i];
    }
    return square_J;
  }

  FLIPFLOW_CLONES
  static double add_branch(int size, double ratio, double decay, double gain, const double *moved_m,
                           const double *change, double *stress_N, double *force_N) {
    double cross_J = 0.0;
#pragma omp simd reduction(+ : cross_J)
    for (int i = 0; i < size; ++i) {
      cross_J += stress_N[i] * moved_m[i];
      stress_N[i] = decay * stress_N[i] + gain * change[i];
      force_N[i] += ratio * stress_N[i];
    }
    return cross_J;
  }

  Diagonals matrix_;
  std::vector<double> flat_m_, product_, moved_;
};

}  // namespace flipflow

#include "bending.h"

#include <algorithm>
#include <cstdlib>

#include "lanes.h"

namespace flipflow {

namespace {

struct Product {
  int blocks, padded;
  const std::vector<int> &offset;
  const double *entry, *column[3];
  double *result;
};

template <class V>
FLIPFLOW_INLINE void multiply_rows(const Product &p) {
  const size_t entries = p.offset.size() * kLanes;
  for (int row = 0; row < p.blocks * kLanes; row += kWidth<V>) {
    const double *entry = p.entry + row / kLanes * entries + row % kLanes;
    V x{}, y{}, z{};
    for (const int to_column : p.offset) {
      const V a = load<V>(entry);
      x += a * load<V>(p.column[0] + row + to_column);
      y += a * load<V>(p.column[1] + row + to_column);
      z += a * load<V>(p.column[2] + row + to_column);
      entry += kLanes;
    }
    store(p.result + row, x);
    store(p.result + p.padded + row, y);
    store(p.result + 2 * p.padded + row, z);
  }
}

FLIPFLOW_V4 void multiply_v4(const Product &p) { multiply_rows<Eight>(p); }
FLIPFLOW_V3 void multiply_v3(const Product &p) { multiply_rows<Four>(p); }
void multiply_any(const Product &p) { multiply_rows<Two>(p); }
auto *const multiply_here = fitting(multiply_v4, multiply_v3, multiply_any);

// What the elastic force changes by stands in `change` afterwards.
FLIPFLOW_CLONES
double add_elastic(int size, const double *moved_m, double *elastic_N, double *change,
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
double add_branch(int size, double ratio, double decay, double gain, const double *moved_m,
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

}  // namespace

Diagonals::Diagonals(std::vector<int> offset, const double *entry, int nodes)
    : nodes_(nodes), padded_((nodes + kLanes - 1) / kLanes * kLanes), margin_(0),
      offset_(std::move(offset)), entry_(offset_.size() * padded_), result_(3 * padded_) {
  for (const int o : offset_) margin_ = std::max(margin_, std::abs(o));
  column_.resize(3 * (padded_ + 2 * margin_));
  for (size_t k = 0; k < offset_.size(); ++k)
    for (int row = 0; row < nodes; ++row)
      entry_[(row / kLanes * offset_.size() + k) * kLanes + row % kLanes] =
          entry[k * nodes + row];
}

void Diagonals::multiply(const double *position, const double *flat, double *product) {
  const int length = padded_ + 2 * margin_;
  double *const column[3] = {&column_[margin_], &column_[length + margin_],
                             &column_[2 * length + margin_]};
  for (int node = 0; node < nodes_; ++node)
    for (int c = 0; c < 3; ++c) column[c][node] = position[3 * node + c] - flat[3 * node + c];
  multiply_here({padded_ / kLanes, padded_, offset_, entry_.data(),
                 {column[0], column[1], column[2]}, result_.data()});
  for (int node = 0; node < nodes_; ++node)
    for (int c = 0; c < 3; ++c) product[3 * node + c] = result_[c * padded_ + node];
}

StepWork Bending::step(const Branches &branches, const double *before_m, const double *position_m,
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

}  // namespace flipflow

#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "lanes.h"
#include "maxwell.h"
#include "membrane.h"
#include "node_places.h"

namespace flipflow {

// A matrix (nodes, nodes): `entry` in the row of a node and the column of another.
struct MatrixEntries {
  std::vector<int> row, column;
  std::vector<double> entry;
};

// A matrix times a field of vectors, both by places (node_places.h).  All nodes of a place see the others
// at the same few dozen distances, so that places side by side need values side by side, and the nodes
// of a place need the same ones.  Where the grid repeats itself so do the entries; groups of places that
// are alike but for rounding share them, so that all stay near the processor.
class StiffnessRows {
 public:
  StiffnessRows(const NodePlaces &places, const MatrixEntries &matrix) {
    double largest = 0.0;
    for (const double entry : matrix.entry) largest = std::max(largest, std::abs(entry));
    const double rounding = 1e-14 * largest;
    std::map<int, std::vector<double>> by_distance;  // (places of a row, kinds)
    for (size_t i = 0; i < matrix.entry.size(); ++i) {
      if (std::abs(matrix.entry[i]) < rounding) continue;
      const int row = places.of_node(matrix.row[i]) - places.margin(), place = row % places.row();
      const int distance = places.of_node(matrix.column[i]) - places.margin() - place;
      if (distance < -places.margin() || distance > 3 * places.row() + places.margin() - kLanes)
        throw std::invalid_argument("row, column: an entry of nodes too far from each other");
      auto &entries = by_distance[distance];
      entries.resize(4 * places.row());
      entries[4 * place + row / places.row()] += matrix.entry[i];
    }
    for (const auto &[distance, entries] : by_distance) distances_[kinds_of(entries)].push_back(distance);
    std::vector<double> packed;
    for (int place = 0; place < places.row(); place += kLanes) {
      const auto block = block_at(by_distance, place);
      block_.push_back(alike(packed, block, rounding));
      if (block_.back() == packed.size()) packed.insert(packed.end(), block.begin(), block.end());
    }
    entry_ = Numbers(packed.size());
    std::copy(packed.begin(), packed.end(), entry_.data());
  }

  // The product's components for the nodes of each kind at `place` and behind it; `values` are the three
  // components of those of the first kind there.
  template <class V>
  FLIPFLOW_INLINE void multiply(int place, const double *const values[3], V product[4][3]) const {
    const double *entry = entry_.data() + block_[place / kLanes] + place % kLanes;
    for (int kind = 0; kind < 4; ++kind)
      for (int c = 0; c < 3; ++c) product[kind][c] = V{};
    multiply_all<V>(entry, values, product, std::make_integer_sequence<int, kSets>());
  }

 private:
  using ByDistance = std::map<int, std::vector<double>>;
  static constexpr int kSets = 16;  // of kinds, by their bits

  static int kinds_of(const std::vector<double> &entries) {
    int set = 0;
    for (size_t i = 0; i < entries.size(); ++i)
      if (entries[i] != 0.0) set |= 1 << (i % 4);
    return set;
  }

  template <class V, int... set>
  FLIPFLOW_INLINE void multiply_all(const double *entry, const double *const values[3], V product[4][3],
                                    std::integer_sequence<int, set...>) const {
    (multiply_set<V, set>(entry, values, product), ...);
  }

  // Adds what nodes of these kinds see at the distances that none of the others sees.
  template <class V, int set>
  FLIPFLOW_INLINE void multiply_set(const double *&entry, const double *const values[3],
                                    V product[4][3]) const {
    for (const int distance : distances_[set]) {
      const V x = load<V>(values[0] + distance), y = load<V>(values[1] + distance),
              z = load<V>(values[2] + distance);
      for (int kind = 0; kind < 4; ++kind) {
        if (!(set >> kind & 1)) continue;
        V a = load<V>(entry);
        keep(a);
        product[kind][0] += a * x;
        product[kind][1] += a * y;
        product[kind][2] += a * z;
        entry += kLanes;
      }
    }
  }

  // The entries of a group of places, in the order in which `multiply` takes them.
  std::vector<double> block_at(const ByDistance &by_distance, int place) const {
    std::vector<double> block;
    for (int set = 0; set < kSets; ++set)
      for (const int distance : distances_[set])
        for (int kind = 0; kind < 4; ++kind)
          if (set >> kind & 1)
            for (int lane = 0; lane < kLanes; ++lane)
              block.push_back(by_distance.at(distance)[4 * (place + lane) + kind]);
    return block;
  }

  // Where a block like this one begins, or the end.
  static size_t alike(const std::vector<double> &packed, const std::vector<double> &block,
                      double rounding) {
    const auto near = [rounding](double a, double b) { return std::abs(a - b) < rounding; };
    size_t at = 0;
    while (at < packed.size() && !std::equal(block.begin(), block.end(), packed.begin() + at, near))
      at += block.size();
    return at;
  }

  // From a place in the row of the first kind, by the set of kinds of nodes that see so far.
  std::vector<int> distances_[kSets];
  std::vector<size_t> block_;  // where the entries of each group of places begin
  Numbers entry_;
};

// Where nodes have come to, how they moved there in a step (which only branches want to know), and the forces
// that answer: by places, (3, places) each, `bending_stress_N` (branches, 3, places).
struct NodeStep {
  const double *bent_m, *moved_m;
  double *elastic_N, *bending_stress_N, *internal_N;
};

// Force of a constant stiffness matrix, with Maxwell branches on the nodes' displacement.
class Bending {
  // Copies of what the loop reads, so that the compiler need not read it again after each store.
  struct Local {
    const NodePlaces places;
    const int branches;
    const double *const ratio, *const decay, *const gain;
    const CellForces cells;
    const NodeStep step;
  };

 public:
  Bending(const NodePlaces &places, const MatrixEntries &matrix) : places_(places), matrix_(places, matrix) {}

  // Fills in the internal force, which is that of bending and what the membrane's cells do, and carries
  // the elastic force and the branches' stresses on.
  template <class V>
  FLIPFLOW_INLINE void step(const Branches &branches, const Membrane &membrane, const NodeStep &step,
                            StepWork &work) const {
    const Local my = {places_, branches.count(), branches.ratio(), branches.decay(), branches.gain(),
                      membrane.forces(), step};
    my.branches ? step_all<V, true>(my, work) : step_all<V, false>(my, work);
  }

 private:
  template <class V, bool relaxes>
  FLIPFLOW_INLINE void step_all(const Local &my, StepWork &work) const {
    const int size = places_.size();
    V square{};
    for (int place = 0; place < places_.row(); place += kWidth<V>) {
      const double *const first_m = my.step.bent_m + my.places.row_start(0) + place;
      const double *const bent_m[3] = {first_m, first_m + size, first_m + 2 * size};
      V elastic[4][3];
      matrix_.multiply(place, bent_m, elastic);
      double *const lane_J = work.cross_J.data() + place % kLanes;
      carry<V, 0, relaxes>(my, place, elastic[0], lane_J, square);
      carry<V, 1, relaxes>(my, place, elastic[1], lane_J, square);
      carry<V, 2, relaxes>(my, place, elastic[2], lane_J, square);
      carry<V, 3, relaxes>(my, place, elastic[3], lane_J, square);
    }
    add_to(work.square_J, square);
  }

  // A step of nodes of a kind whose elastic force is now `elastic`.
  template <class V, int kind, bool relaxes>
  static FLIPFLOW_INLINE void carry(const Local &my, int place, const V elastic[3], double *cross_J, V &square) {
    for (int c = 0; c < 3; ++c) {
      const int at = c * my.places.size() + my.places.row_start(kind) + place;
      V force = elastic[c] + my.cells.on<V, kind>(c, place), change, moved;
      if (relaxes) {
        change = elastic[c] - load<V>(my.step.elastic_N + at);
        moved = load<V>(my.step.moved_m + at);
        square += change * moved;
      }
      store(my.step.elastic_N + at, elastic[c]);
      for (int b = 0; relaxes && b < my.branches; ++b) {
        double *const stress = my.step.bending_stress_N + 3 * b * my.places.size() + at;
        const V old = load<V>(stress), next = my.decay[b] * old + my.gain[b] * change;
        add_to(cross_J + b * kLanes, old * moved);
        force += my.ratio[b] * next;
        store(stress, next);
      }
      store(my.step.internal_N + at, force);
    }
  }

  NodePlaces places_;
  StiffnessRows matrix_;
};

}  // namespace flipflow

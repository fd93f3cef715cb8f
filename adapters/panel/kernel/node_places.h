#pragma once

#include <algorithm>
#include <vector>

#include "lanes.h"

namespace flipflow {

// A rectangular grid of biquadratic cells; nodes and cells are numbered with y running fastest.
struct CellGrid {
  std::vector<double> along_m, across_m;  // lengths of the cells in each direction

  int along() const { return static_cast<int>(along_m.size()); }
  int across() const { return static_cast<int>(across_m.size()); }
  int cells() const { return along() * across(); }
  int nodes_across() const { return 2 * across() + 1; }
  int nodes() const { return (2 * along() + 1) * nodes_across(); }
};

// Where values of nodes stand in memory: those of cells side by side stand side by side, too.
//
// Corners of cells, middles of their edges along and across, and their centres are four kinds of
// nodes, which have a row of places each.  A cell has the same place in all four rows for its
// lowest corner, the middles of the two edges there, and its centre.  The direction with more cells
// runs fastest; each line of cells has one place more than cells, for the nodes at its end, so that
// what stands there is no cell.  `margin` places before and behind may be read.
class NodePlaces {
 public:
  explicit NodePlaces(const CellGrid &grid)
      : along_fastest_(grid.along() > grid.across()),
        across_(grid.across()),
        nodes_across_(grid.nodes_across()),
        line_(std::max(grid.along(), grid.across()) + 1),
        cell_places_(line_ * std::min(grid.along(), grid.across())),
        row_(whole_groups(line_ * (std::min(grid.along(), grid.across()) + 1))),
        margin_(whole_groups(2 * line_ + 2 + kLanes)) {}

  int size() const { return 2 * margin_ + 4 * row_; }
  int row() const { return row_; }
  int row_start(int kind) const { return margin_ + kind * row_; }
  int margin() const { return margin_; }
  // Groups of places that have cells.
  int groups() const { return whole_groups(cell_places_) / kLanes; }

  int of_node(int node) const { return of(node / nodes_across_, node % nodes_across_); }
  int of_cell(int cell) const { return of(2 * (cell / across_), 2 * (cell % across_)) - margin_; }

  // Of node `k` of a cell: its kind, and how far its place in that row is from the cell's own.
  int kind(int k) const { return (of(k / 3, k % 3) - margin_) / row_; }
  int shift(int k) const { return (of(k / 3, k % 3) - margin_) % row_; }

 private:
  static int whole_groups(int places) { return (places + kLanes - 1) / kLanes * kLanes; }

  // Of the node in line `s` along and `y` across.
  int of(int s, int y) const {
    const int fast = along_fastest_ ? s : y, slow = along_fastest_ ? y : s;
    return margin_ + (2 * (slow % 2) + fast % 2) * row_ + slow / 2 * line_ + fast / 2;
  }

  bool along_fastest_;
  int across_, nodes_across_, line_, cell_places_, row_, margin_;
};

// Numbers that start where the widest registers like it.
class Numbers {
 public:
  explicit Numbers(size_t count = 0) : groups_((count + kLanes - 1) / kLanes) {}
  double *data() { return groups_.data()->value; }
  const double *data() const { return groups_.data()->value; }

 private:
  struct alignas(kLanes * sizeof(double)) Group {
    double value[kLanes] = {};
  };
  std::vector<Group> groups_;
};

}  // namespace flipflow

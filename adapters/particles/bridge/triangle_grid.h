#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "../../vec3.h"

namespace flipflow {

// The lowest and the highest corner of the box around a triangle.
struct TriangleBox {
  Vec3 low, high;

  static TriangleBox of(Vec3 a, Vec3 b, Vec3 c) {
    return {{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::min({a.z, b.z, c.z})},
            {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}), std::max({a.z, b.z, c.z})}};
  }

  // Is a place farther than `reach_m` from the box along any axis?
  bool apart(Vec3 place, double reach_m) const {
    return place.z + reach_m < low.z || place.z - reach_m > high.z || place.x + reach_m < low.x ||
           place.x - reach_m > high.x || place.y + reach_m < low.y || place.y - reach_m > high.y;
  }
};

// Which triangles may lie within `reach` of a place: a uniform grid over the surface's bounding
// box; each cell lists the triangles whose bounding box, grown by `reach`, meets the cell.
class TriangleGrid {
 public:
  // `numbers`: the triangles; `boxes_m`: the boxes around all triangles, by their numbers.
  void build(const std::vector<int> &numbers, const std::vector<TriangleBox> &boxes_m, double reach_m) {
    std::fill_n(count_, 3, 0);
    if (numbers.empty()) return;
    lay_out(numbers, boxes_m, reach_m);
    first_.assign(static_cast<size_t>(count_[0]) * count_[1] * count_[2] + 1, 0);
    std::vector<Box> boxes(numbers.size());
    for (size_t t = 0; t < numbers.size(); ++t) {
      boxes[t] = cells(boxes_m[numbers[t]], reach_m);
      each_cell(boxes[t], [&](int cell) { ++first_[cell]; });
    }
    int end = 0;
    for (int &first : first_) first = end += first;  // now one past each cell's last
    triangle_.resize(end);
    for (size_t t = numbers.size(); t-- > 0;)
      each_cell(boxes[t], [&](int cell) { triangle_[--first_[cell]] = numbers[t]; });
  }

  // Range of triangle numbers for the cell that holds `p` (empty outside of the grid).
  std::array<const int *, 2> near(Vec3 p) const {
    int cell = 0;
    for (int k = 2; k >= 0; --k) {
      const double x = ((&p.x)[k] - low_[k]) * per_m_[k];
      if (!(x >= 0 && x < count_[k])) return {nullptr, nullptr};
      cell = cell * count_[k] + static_cast<int>(x);
    }
    return {triangle_.data() + first_[cell], triangle_.data() + first_[cell + 1]};
  }

 private:
  using Box = std::array<std::array<int, 3>, 2>;

  void lay_out(const std::vector<int> &numbers, const std::vector<TriangleBox> &boxes_m, double reach_m) {
    double size[3], cells = 1.0;
    for (int k = 0; k < 3; ++k) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (const int t : numbers) {
        low = std::min(low, (&boxes_m[t].low.x)[k]);
        high = std::max(high, (&boxes_m[t].high.x)[k]);
      }
      low_[k] = low - reach_m;
      size[k] = high - low + 2 * reach_m;
      cells *= size[k] / (2 * reach_m);
    }
    // cells of twice the reach, or larger where that would be far more cells than triangles
    const double most = 4096.0 + 8.0 * static_cast<double>(numbers.size());
    const double cell = 2 * reach_m * std::max(1.0, std::cbrt(cells / most));
    for (int k = 0; k < 3; ++k) {
      count_[k] = std::max(1, static_cast<int>(size[k] / cell));
      per_m_[k] = count_[k] / size[k];
    }
  }

  Box cells(const TriangleBox &around, double reach_m) const {
    Box box;
    for (int k = 0; k < 3; ++k) {
      const double low = (&around.low.x)[k] - reach_m, high = (&around.high.x)[k] + reach_m;
      const auto cell = [&](double x) {
        return std::clamp(static_cast<int>((x - low_[k]) * per_m_[k]), 0, count_[k] - 1);
      };
      box[0][k] = cell(low);
      box[1][k] = cell(high);
    }
    return box;
  }

  template <class Visit>
  void each_cell(const Box &box, Visit visit) const {
    for (int z = box[0][2]; z <= box[1][2]; ++z)
      for (int y = box[0][1]; y <= box[1][1]; ++y)
        for (int x = box[0][0]; x <= box[1][0]; ++x) visit((z * count_[1] + y) * count_[0] + x);
  }

  double low_[3], per_m_[3];
  int count_[3] = {0, 0, 0};
  std::vector<int> first_, triangle_;
};

}  // namespace flipflow

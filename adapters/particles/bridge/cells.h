#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "../../vec3.h"

namespace flipflow {

// Spheres sorted into cells.  Copies of them lie in memory in the order of their cells, so that those near a
// place are among a few short rows of copies.
class Cells {
 public:
  bool empty() const { return number_.empty(); }
  double largest_radius_m() const { return largest_radius_m_; }

  // The spheres with the given numbers, among which looks will reach `usual_m`.
  void sort(const std::vector<int> &numbers, const double *const *position_m, const double *radius_m,
            double usual_m) {
    const int count = static_cast<int>(numbers.size());
    lay_out(numbers, position_m, usual_m);
    largest_radius_m_ = 0.0;
    cell_.resize(count);
    number_.resize(count);
    copies_.resize(count);
    first_.assign(static_cast<size_t>(count_[0]) * count_[1] * count_[2] + 1, 0);
    for (int k = 0; k < count; ++k) {
      ++first_[cell_[k] = cell_at(position_m[numbers[k]])];
      largest_radius_m_ = std::max(largest_radius_m_, radius_m[numbers[k]]);
    }
    int end = 0;
    for (int &first : first_) first = end += first;  // now one past each cell's last
    for (int k = count; k-- > 0;) {
      const int copy = --first_[cell_[k]], i = numbers[k];
      number_[copy] = i;
      copies_[copy] = {from(position_m[i]), radius_m[i]};
    }
  }

  // Writes to `found` the numbers above `above` of the spheres that are, less `skin_m`, no farther from a sphere
  // than `factor` times both radii, and returns one past the last.  There is room for all.  There is no branch:
  // that would depend on what no processor foresees.
  int *find(Vec3 here_m, double radius_m, double factor, double skin_m, int above, int *found) const {
    const double farthest_m = ((radius_m + largest_radius_m_) * factor + skin_m) * (1.0 + 1e-9);  // rounded up
    const double here[3] = {here_m.x, here_m.y, here_m.z};
    int low[3], high[3];
    for (int d = 0; d < 3; ++d) {
      low[d] = along(here[d] - farthest_m, d);
      high[d] = along(here[d] + farthest_m, d);
    }
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y) {
        const int *row = &first_[(z * count_[1] + y) * count_[0]];
        for (int copy = row[low[0]]; copy < row[high[0] + 1]; ++copy) {
          const Vec3 apart_m = here_m - copies_[copy].position_m;
          const double reach_m = (radius_m + copies_[copy].radius_m) * factor + skin_m;
          *found = number_[copy];
          found += (number_[copy] > above) & (dot(apart_m, apart_m) <= reach_m * reach_m);
        }
      }
    return found;
  }

 private:
  struct Copy {
    Vec3 position_m;
    double radius_m;
  };

  static constexpr double kCellsPerSphere = 64.0;  // at most: all are cleared for every list
  // As many cells are as long as a usual look.  They are short along x, in which they follow each other in memory:
  // short cells there make short rows, elsewhere they would make many.
  static constexpr double kPerLook[3] = {4.0, 1.0, 1.0};

  // The cells cover all spheres.
  void lay_out(const std::vector<int> &numbers, const double *const *position_m, double usual_m) {
    double size_m[3];
    for (int d = 0; d < 3; ++d) {
      double high_m = -INFINITY;
      low_m_[d] = INFINITY;
      for (const int i : numbers) {
        low_m_[d] = std::min(low_m_[d], position_m[i][d]);
        high_m = std::max(high_m, position_m[i][d]);
      }
      size_m[d] = std::isfinite(high_m - low_m_[d]) ? high_m - low_m_[d] : 0.0;  // who is nowhere is found elsewhere
      cell_m_[d] = usual_m / kPerLook[d];
    }
    const auto cells = [&](int d) { return std::floor(size_m[d] / cell_m_[d]) + 1.0; };
    while (cells(0) * cells(1) * cells(2) > kCellsPerSphere * numbers.size() + 1.0)
      for (double &cell_m : cell_m_) cell_m *= 1.25;
    for (int d = 0; d < 3; ++d) count_[d] = static_cast<int>(cells(d));
  }

  // The first cell for places below all, and for what is no number; the last one for those above.
  int along(double place_m, int d) const {
    return static_cast<int>(std::min(std::max(0.0, (place_m - low_m_[d]) / cell_m_[d]), count_[d] - 1.0));
  }

  int cell_at(const double *place_m) const {
    return (along(place_m[2], 2) * count_[1] + along(place_m[1], 1)) * count_[0] + along(place_m[0], 0);
  }

  double low_m_[3], cell_m_[3], largest_radius_m_ = 0.0;
  int count_[3];
  std::vector<int> cell_, first_, number_;  // each sphere's cell, each cell's first copy, each copy's number
  std::vector<Copy> copies_;
};

}  // namespace flipflow

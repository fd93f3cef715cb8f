#pragma once

#include <array>
#include <vector>

#include "surface_path.h"

namespace flipflow {

using Triangle = std::array<int, 3>;

// Which triangles may lie within `reach` of a place: a uniform grid over the surface's bounding
// box; each cell lists the triangles whose bounding box, grown by `reach`, meets the cell.
class TriangleGrid {
 public:
  void build(const SurfacePath &surface, const std::vector<Triangle> &triangles, double reach_m);

  // Range of triangle numbers for the cell that holds `p` (empty outside of the grid).
  std::array<const int *, 2> near(Vec3 p) const;

 private:
  using Box = std::array<std::array<int, 3>, 2>;

  void lay_out(const std::vector<double> &position_m, size_t triangles, double reach_m);
  Box cells(const SurfacePath &surface, const Triangle &t, double reach_m) const;
  template <class Visit>
  void each_cell(const Box &box, Visit visit) const;

  double low_[3], per_m_[3];
  int count_[3] = {0, 0, 0};
  std::vector<int> first_, triangle_;
};

}  // namespace flipflow

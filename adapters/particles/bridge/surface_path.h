#pragma once

#include <vector>

#include "vec3.h"

namespace flipflow {

// Points that move smoothly from start to end of a sync interval: cubic Hermite in position and
// velocity, the same formula as orchestrator/hermite.py.
class SurfacePath {
 public:
  explicit SurfacePath(std::vector<double> position_m);

  int points() const { return static_cast<int>(position_.size()) / 3; }

  // The points are somewhere else, between two paths.
  void place(const std::vector<double> &position_m) { position_ = position_m; }

  // Arrays of 3 * points values.  The points go to the start; returns the longest such jump, m.
  double begin(const double *start_m, const double *start_m_s, const double *end_m,
             const double *end_m_s, double length_s);

  // All points to `fraction` (0 ... 1) of the interval.
  void move(double fraction);

  Vec3 position(int point) const { return from(&position_[3 * point]); }
  Vec3 velocity(int point) const;
  const std::vector<double> &start_velocity() const { return start_v_; }
  const std::vector<double> &positions() const { return position_; }

  // No point goes faster than this within the interval.
  double fastest_m_s() const { return fastest_; }

 private:
  std::vector<double> position_, start_x_, start_v_, end_x_, end_v_;
  double length_ = 1.0, fraction_ = 0.0, fastest_ = 0.0;
};

}  // namespace flipflow

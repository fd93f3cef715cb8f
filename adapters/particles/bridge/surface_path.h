#pragma once

#include <vector>

#include "vec3.h"

namespace flipflow {

// Points that move smoothly from start to end of a sync interval: cubic Hermite in position and
// velocity, the same formula as orchestrator/ports/hermite.py.
class SurfacePath {
 public:
  explicit SurfacePath(std::vector<double> position_m);

  int points() const { return static_cast<int>(position_.size()) / 3; }

  // The points are somewhere else, between two paths.
  void place(const std::vector<double> &position_m) { position_ = position_m; }

  // Arrays of 3 * points values.  The points go to the start; returns the longest such jump, m.
  double begin(const double *start_m, const double *start_m_per_s, const double *end_m,
             const double *end_m_per_s, double length_s);

  // All points to `fraction` (0 ... 1) of the interval; half-way there they were at `half_way`.
  void move(double fraction, double half_way);

  Vec3 position(int point) const { return from(&position_[3 * point]); }
  // Where the point was before the last move; for the first move of a path, where the last path left
  // it.
  Vec3 position_before(int point) const { return from(&before_[3 * point]); }
  Vec3 velocity(int point) const { return velocity(point, now_); }
  Vec3 velocity_half_way(int point) const { return velocity(point, half_way_); }
  const std::vector<double> &start_velocity() const { return start_v_; }
  const std::vector<double> &positions() const { return position_; }

  // No point goes faster than this within the interval.
  double fastest_m_per_s() const { return fastest_; }

  // No point is farther than this from where it was before the last move, which took `step_s`.
  double farthest_moved_m(double step_s) const {
    return fastest_ * step_s + (moves_ == 1 ? jump_ : 0.0);
  }

 private:
  struct Rate {  // what displacement, start and end velocity count for in a velocity
    double x = 0.0, v0 = 1.0, v1 = 0.0;
  };

  Rate rate(double fraction) const;
  Vec3 velocity(int point, const Rate &rate) const;

  std::vector<double> position_, before_, start_x_, start_v_, end_x_, end_v_;
  double length_ = 1.0, fastest_ = 0.0, jump_ = 0.0;
  int moves_ = 0;  // since the path's start, 2 for more
  Rate now_, half_way_;
};

}  // namespace flipflow

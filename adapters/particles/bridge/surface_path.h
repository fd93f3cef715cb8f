#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "../../vec3.h"
#include "triangle.h"

namespace flipflow {

// A vertex of a rigid surface: always the same mean of four points that follow one another (RigidVertices in
// orchestrator/ports/geometry.py).  No weight is negative.
struct RigidVertex {
  int first;
  double weight[4];
};

// Points that carry a place, with their weights, which sum to one.
struct Footing {
  int point[4];
  double weight[4];
};

// Points that move smoothly from start to end of a sync interval: cubic Hermite in position and
// velocity, the same formula as HermitePath in orchestrator/ports/interface_records.py.
//
// The points come first among the vertices of triangles, and those of rigid surfaces follow.  They are
// computed where they are asked for, so that however many of them cost nothing while nobody is near.
class SurfacePath {
 public:
  explicit SurfacePath(std::vector<double> position_m, std::vector<RigidVertex> rigid = {})
      : position_(std::move(position_m)),
        rigid_(std::move(rigid)),
        before_(position_),
        start_x_(position_),
        start_v_(position_.size(), 0.0),
        end_x_(position_),
        end_v_(position_.size(), 0.0),
        now_(start_v_),
        half_way_(start_v_) {}

  int points() const { return static_cast<int>(position_.size()) / 3; }
  int vertices() const { return points() + static_cast<int>(rigid_.size()); }
  bool is_rigid(int vertex) const { return vertex >= points(); }
  const RigidVertex &rigid(int vertex) const { return rigid_[vertex - points()]; }

  // The points are somewhere else, between two paths.
  void place(const std::vector<double> &position_m) { position_ = position_m; }

  bool is_at(const double *points_m) const {
    return std::equal(position_.begin(), position_.end(), points_m);
  }

  // Arrays of 3 * points values.  The points go to the start; returns the longest such jump, m.
  double begin(const double *start_m, const double *start_m_per_s, const double *end_m,
               const double *end_m_per_s, double length_s) {
    const size_t n = position_.size();
    start_x_.assign(start_m, start_m + n);
    start_v_.assign(start_m_per_s, start_m_per_s + n);
    end_x_.assign(end_m, end_m + n);
    end_v_.assign(end_m_per_s, end_m_per_s + n);
    length_ = length_s;
    // The velocity is a quadratic Bezier curve; it stays in the hull of its three control values:
    // both end velocities and (3 (x1 - x0) / h - v0 - v1) in the middle.
    double fastest2 = 0.0, jump2 = 0.0;
    for (size_t i = 0; i < n; i += 3) {
      const Vec3 v0 = from(&start_v_[i]), v1 = from(&end_v_[i]);
      const Vec3 middle = (3.0 / length_) * (from(&end_x_[i]) - from(&start_x_[i])) - v0 - v1;
      fastest2 = std::max({fastest2, dot(v0, v0), dot(v1, v1), dot(middle, middle)});
      const Vec3 jump = from(&start_x_[i]) - from(&position_[i]);
      jump2 = std::max(jump2, dot(jump, jump));
    }
    fastest_ = std::sqrt(fastest2);
    now_ = half_way_ = start_v_;
    before_.swap(position_);
    position_ = start_x_;
    moves_ = 0;
    jump_ = std::sqrt(jump2);
    return jump_;
  }

  // All points to `fraction` (0 ... 1) of the interval; half-way there they were at `half_way`.
  void move(double fraction, double half_way) {
    set_velocity(now_, fraction);
    set_velocity(half_way_, half_way);
    if (moves_ < 2) ++moves_;
    if (fastest_ == 0.0) {
      if (jump_ > 0.0 && moves_ == 2) before_ = position_;
      return;
    }
    if (moves_ == 2) before_.swap(position_);
    const double t = fraction, h = length_, r = 1 - t;
    const double x0 = (1 + 2 * t) * r * r, v0 = t * r * r * h;
    const double x1 = t * t * (3 - 2 * t), v1 = -t * t * r * h;
    const size_t n = position_.size();
    for (size_t i = 0; i < n; ++i)
      position_[i] = x0 * start_x_[i] + v0 * start_v_[i] + x1 * end_x_[i] + v1 * end_v_[i];
  }

  Vec3 position(int vertex) const { return at(position_, vertex); }
  // How far a point jumped to the start of the path, before its first move.
  Vec3 jump_m(int point) const { return from(&position_[3 * point]) - from(&before_[3 * point]); }

  // Where the vertex was before the last move; for the first move of a path, where the last path left
  // it.
  Vec3 position_before(int vertex) const { return at(before_, vertex); }
  Vec3 velocity(int vertex) const { return at(now_, vertex); }
  Vec3 velocity_half_way(int vertex) const { return at(half_way_, vertex); }

  // Hands a force on a vertex on to the points that carry it: `add(point, force)`.
  template <class Add>
  void hand_on(int vertex, Vec3 force, Add add) const {
    if (!is_rigid(vertex)) return add(vertex, force);
    const RigidVertex &of = rigid(vertex);
    for (int k = 0; k < 4; ++k) add(of.first + k, of.weight[k] * force);
  }
  const std::vector<double> &start_velocity() const { return start_v_; }
  const std::vector<double> &positions() const { return position_; }

  // The points that carry a place of a triangle, given by the weights of its corners.
  Footing footing(const Triangle &corner, const double *weight) const {
    Footing found = {{corner[0], corner[1], corner[2], corner[2]}, {weight[0], weight[1], weight[2], 0.0}};
    if (!is_rigid(corner[0])) return found;
    for (int k = 0; k < 4; ++k) {
      found.point[k] = rigid(corner[0]).first + k;
      found.weight[k] = 0.0;
      for (int c = 0; c < 3; ++c) found.weight[k] += weight[c] * rigid(corner[c]).weight[k];
    }
    return found;
  }

  // No point, and so no vertex, goes faster than this within the interval.
  double fastest_m_per_s() const { return fastest_; }

  // No point is farther than this from where it was before the last move, which took `step_s`.
  double farthest_moved_m(double step_s) const {
    return fastest_ * step_s + (moves_ == 1 ? jump_ : 0.0);
  }

 private:
  Vec3 at(const std::vector<double> &points, int vertex) const {
    if (!is_rigid(vertex)) return from(&points[3 * vertex]);
    const RigidVertex &of = rigid(vertex);
    const double *p = &points[3 * of.first], *w = of.weight;
    const auto mean = [&](int c) { return w[0] * p[c] + w[1] * p[3 + c] + w[2] * p[6 + c] + w[3] * p[9 + c]; };
    return {mean(0), mean(1), mean(2)};
  }

  // The velocities at `t` (0 ... 1) of the interval: of all points at once, since a point has many contacts.
  void set_velocity(std::vector<double> &m_per_s, double t) const {
    const double x = 6 * t * (1 - t) / length_, v0 = (1 - t) * (1 - 3 * t), v1 = t * (3 * t - 2);
    for (size_t i = 0; i < m_per_s.size(); ++i)
      m_per_s[i] = x * (end_x_[i] - start_x_[i]) + v0 * start_v_[i] + v1 * end_v_[i];
  }

  std::vector<double> position_;
  std::vector<RigidVertex> rigid_;
  std::vector<double> before_, start_x_, start_v_, end_x_, end_v_;
  std::vector<double> now_, half_way_;  // velocities
  double length_ = 1.0, fastest_ = 0.0, jump_ = 0.0;
  int moves_ = 0;  // since the path's start, 2 for more
};

}  // namespace flipflow

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
// The points come first among the vertices of triangles, and those of rigid surfaces follow.  Both are
// computed where they are asked for, so that however many of them cost next to nothing while nobody is near:
// within an interval `position_` has the places that were asked for since the last move, and `move_of_` says
// which these are.
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
        move_of_(position_.size() / 3, 0) {}

  int points() const { return static_cast<int>(position_.size()) / 3; }
  int vertices() const { return points() + static_cast<int>(rigid_.size()); }
  bool is_rigid(int vertex) const { return vertex >= points(); }
  const RigidVertex &rigid(int vertex) const { return rigid_[vertex - points()]; }

  // The points are somewhere else, between two paths.
  void place(const std::vector<double> &position_m) {
    position_ = position_m;
    stand();
  }

  bool is_at(const double *points_m) const {
    const std::vector<double> &now = positions();
    return std::equal(now.begin(), now.end(), points_m);
  }

  // Arrays of 3 * points values.  The points go to the start; returns the longest such jump, m.
  double begin(const double *start_m, const double *start_m_per_s, const double *end_m,
               const double *end_m_per_s, double length_s) {
    const size_t n = positions().size();
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
    now_ = half_way_ = velocity_at(0.0);
    before_.swap(position_);
    position_ = start_x_;
    stand();
    moves_ = 0;
    jump_ = std::sqrt(jump2);
    return jump_;
  }

  // All points to `fraction` (0 ... 1) of the interval; half-way there they were at `half_way`.
  void move(double fraction, double half_way) {
    now_ = velocity_at(fraction);
    half_way_ = velocity_at(half_way);
    if (moves_ < 2) ++moves_;
    if (fastest_ == 0.0) {
      if (jump_ > 0.0 && moves_ == 2) before_ = position_;
      return;
    }
    place_before_ = place_;
    place_ = place_at(fraction);
    ++move_;
  }

  Vec3 position(int vertex) const {
    return at(vertex, [this](int point) { return point_now(point); });
  }
  // How far a point jumped to the start of the path, before its first move.
  Vec3 jump_m(int point) const { return from(&position_[3 * point]) - from(&before_[3 * point]); }

  // Where the vertex was before the last move; for the first move of a path, where the last path left
  // it.
  Vec3 position_before(int vertex) const {
    const bool on_path = moves_ == 2 && fastest_ > 0.0;
    return at(vertex, [&](int point) { return on_path ? place(point, place_before_) : from(&before_[3 * point]); });
  }
  Vec3 velocity(int vertex) const {
    return at(vertex, [this](int point) { return velocity(point, now_); });
  }
  Vec3 velocity_half_way(int vertex) const {
    return at(vertex, [this](int point) { return velocity(point, half_way_); });
  }

  // Hands a force on a vertex on to the points that carry it: `add(point, force)`.
  template <class Add>
  void hand_on(int vertex, Vec3 force, Add add) const {
    if (!is_rigid(vertex)) return add(vertex, force);
    const RigidVertex &of = rigid(vertex);
    for (int k = 0; k < 4; ++k) add(of.first + k, of.weight[k] * force);
  }
  const std::vector<double> &start_velocity() const { return start_v_; }
  const std::vector<double> &positions() const {
    for (int p = 0; p < points(); ++p) point_now(p);
    return position_;
  }

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
  struct Weights {  // of place and velocity at the start and at the end
    double x0, v0, x1, v1;
  };
  struct Rates {  // of the way from start to end, and of the velocities there
    double way, v0, v1;
  };

  Weights place_at(double t) const {
    const double h = length_, r = 1 - t;
    return {(1 + 2 * t) * r * r, t * r * r * h, t * t * (3 - 2 * t), -t * t * r * h};
  }
  Rates velocity_at(double t) const {
    return {6 * t * (1 - t) / length_, (1 - t) * (1 - 3 * t), t * (3 * t - 2)};
  }

  Vec3 place(int point, const Weights &of) const {
    const size_t p = 3 * static_cast<size_t>(point);
    return of.x0 * from(&start_x_[p]) + of.v0 * from(&start_v_[p]) + of.x1 * from(&end_x_[p]) +
           of.v1 * from(&end_v_[p]);
  }
  Vec3 velocity(int point, const Rates &of) const {
    const size_t p = 3 * static_cast<size_t>(point);
    return of.way * (from(&end_x_[p]) - from(&start_x_[p])) + of.v0 * from(&start_v_[p]) +
           of.v1 * from(&end_v_[p]);
  }

  Vec3 point_now(int point) const {
    double *known = &position_[3 * static_cast<size_t>(point)];
    if (move_of_[point] != move_) {
      put(known, place(point, place_));
      move_of_[point] = move_;
    }
    return from(known);
  }

  // All points are where `position_` says.
  void stand() {
    move_ = 0;
    std::fill(move_of_.begin(), move_of_.end(), 0);
  }

  template <class OfPoint>
  Vec3 at(int vertex, OfPoint of_point) const {
    if (!is_rigid(vertex)) return of_point(vertex);
    const RigidVertex &of = rigid(vertex);
    Vec3 mean = {0, 0, 0};
    for (int k = 0; k < 4; ++k) mean = mean + of.weight[k] * of_point(of.first + k);
    return mean;
  }

  std::vector<RigidVertex> rigid_;
  mutable std::vector<double> position_;
  std::vector<double> before_, start_x_, start_v_, end_x_, end_v_;
  mutable std::vector<int> move_of_;  // the move after which a point was computed
  int move_ = 0;                      // since the points stood
  Weights place_{}, place_before_{};
  Rates now_{}, half_way_{};
  double length_ = 1.0, fastest_ = 0.0, jump_ = 0.0;
  int moves_ = 0;  // since the path's start, 2 for more
};

}  // namespace flipflow

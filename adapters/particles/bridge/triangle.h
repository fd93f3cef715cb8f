#pragma once

#include <array>

#include "../../vec3.h"

namespace flipflow {

using Triangle = std::array<int, 3>;  // numbers of its points

// Bits of the corners that carry a closest point: 1, 2, 4 a corner, 3, 6, 5 an edge, 7 the face.
using Feature = int;

constexpr Feature kFirstEdge = 3;    // from the first corner to the second
constexpr Feature kClosingEdge = 5;  // from the first corner to the third
constexpr Feature kSecondEdge = 6;   // from the second corner to the third
constexpr Feature kFace = 7;

struct ClosestPoint {
  double weight[3];  // barycentric, sum 1
  Feature feature;
};

// Closest point of triangle a b c to p.  Christer Ericson, Real-Time Collision Detection,
// Morgan Kaufmann 2005, section 5.1.5.
inline ClosestPoint closest_point(Vec3 p, Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = dot(ab, ap), d2 = dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return {{1, 0, 0}, 1};
  const Vec3 bp = p - b;
  const double d3 = dot(ab, bp), d4 = dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return {{0, 1, 0}, 2};
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return {{1 - t, t, 0}, kFirstEdge};
  }
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {{0, 0, 1}, 4};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return {{1 - t, 0, t}, kClosingEdge};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {{0, 1 - t, t}, kSecondEdge};
  }
  const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
  return {{1 - v - w, v, w}, kFace};
}

// How a triangle turns, and how it takes up a couple, by its three corners at d_k from their
// centroid.  Its spin is that of the rigid body of three equal masses there with the same angular
// momentum, J^-1 sum d_k x v_k with J = sum (|d_k|^2 1 - d_k d_k^T).  A couple C becomes the forces
// (J^-1 C) x d_k: their sum is zero, their moment is C, and their power is C . spin.  A triangle
// without area takes up no couple and counts as not turning.
class TriangleSpin {
 public:
  TriangleSpin(Vec3 a, Vec3 b, Vec3 c) {
    const Vec3 centroid = (1.0 / 3.0) * (a + b + c);
    arm_[0] = a - centroid;
    arm_[1] = b - centroid;
    arm_[2] = c - centroid;
    double xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;
    for (const Vec3 &d : arm_) {
      xx += d.y * d.y + d.z * d.z;
      yy += d.z * d.z + d.x * d.x;
      zz += d.x * d.x + d.y * d.y;
      xy -= d.x * d.y;
      yz -= d.y * d.z;
      zx -= d.z * d.x;
    }
    const Vec3 first = {yy * zz - yz * yz, yz * zx - xy * zz, xy * yz - yy * zx};
    const double determinant = xx * first.x + xy * first.y + zx * first.z, trace = xx + yy + zz;
    const bool takes_couples = determinant > kThinnest * trace * trace * trace;
    const double per_determinant = takes_couples ? 1.0 / determinant : 0.0;
    rows_[0] = per_determinant * first;
    rows_[1] = per_determinant * Vec3{first.y, xx * zz - zx * zx, zx * xy - xx * yz};
    rows_[2] = per_determinant * Vec3{first.z, zx * xy - xx * yz, xx * yy - xy * xy};
  }

  Vec3 spin(Vec3 velocity_a, Vec3 velocity_b, Vec3 velocity_c) const {
    return solved(cross(arm_[0], velocity_a) + cross(arm_[1], velocity_b) +
                  cross(arm_[2], velocity_c));
  }

  // What the corners' forces are made of: force k is cross(solved(couple), arm(k)).
  Vec3 solved(Vec3 couple) const {
    return {dot(rows_[0], couple), dot(rows_[1], couple), dot(rows_[2], couple)};
  }
  Vec3 arm(int corner) const { return arm_[corner]; }

 private:
  static constexpr double kThinnest = 1e-12;  // some millionth as wide as it is long

  Vec3 arm_[3], rows_[3];
};

// Three points that move evenly from `before` to `now`.
struct MovingTriangle {
  Vec3 before[3], now[3];
};

// Point and triangle at a fraction of the way; the corners are relative to the point.
struct PlacedTriangle {
  Vec3 a, b, c, normal;

  PlacedTriangle(Vec3 before, Vec3 now, const MovingTriangle &triangle, double fraction) {
    const Vec3 point = before + fraction * (now - before);
    const auto corner = [&](int k) {
      return triangle.before[k] + fraction * (triangle.now[k] - triangle.before[k]) - point;
    };
    a = corner(0);
    b = corner(1);
    c = corner(2);
    normal = cross(b - a, c - a);
  }

  bool in_front() const { return dot(a, normal) < 0.0; }

  bool inside() const {
    constexpr double kRounding = 1e-9;  // of a barycentric weight: neighbours leave no gap
    const double least = -kRounding * dot(normal, normal);
    return dot(cross(a, b), normal) >= least && dot(cross(b, c), normal) >= least &&
           dot(cross(c, a), normal) >= least;
  }
};

// Does a point that moves evenly from `before` to `now` go through the triangle on its way: does it
// end on the other side of the triangle's plane, and was it inside of the triangle when it changed
// sides?  A point in the plane counts to its back; one on an edge goes through both triangles there.
inline bool goes_through(Vec3 before, Vec3 now, const MovingTriangle &triangle) {
  const bool was_in_front = PlacedTriangle(before, now, triangle, 0.0).in_front();
  if (PlacedTriangle(before, now, triangle, 1.0).in_front() == was_in_front) return false;
  constexpr int kHalvings = 50;  // of the way: to rounding
  double low = 0.0, high = 1.0;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (PlacedTriangle(before, now, triangle, middle).in_front() == was_in_front ? low : high) = middle;
  }
  return PlacedTriangle(before, now, triangle, high).inside();
}

}  // namespace flipflow

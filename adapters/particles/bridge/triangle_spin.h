#pragma once

#include "vec3.h"

namespace flipflow {

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

}  // namespace flipflow

#pragma once

#include "vec3.h"

namespace flipflow {

// Bits of the corners that carry a closest point: 1, 2, 4 a corner, 3, 6, 5 an edge, 7 the face.
using Feature = int;

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
    return {{1 - t, t, 0}, 3};
  }
  const Vec3 cp = p - c;
  const double d5 = dot(ab, cp), d6 = dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return {{0, 0, 1}, 4};
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return {{1 - t, 0, t}, 5};
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return {{0, 1 - t, t}, 6};
  }
  const double v = vb / (va + vb + vc), w = vc / (va + vb + vc);
  return {{1 - v - w, v, w}, 7};
}

}  // namespace flipflow

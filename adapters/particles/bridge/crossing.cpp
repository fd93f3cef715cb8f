#include "crossing.h"

namespace flipflow {

namespace {

constexpr int kHalvings = 50;          // of the way: to rounding
constexpr double kRounding = 1e-9;     // of a barycentric weight: neighbours leave no gap between them

// Point and triangle at a fraction of the way; the corners are relative to the point.
struct Placed {
  Vec3 a, b, c, normal;

  Placed(Vec3 before, Vec3 now, const MovingTriangle &triangle, double fraction) {
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
    const double least = -kRounding * dot(normal, normal);
    return dot(cross(a, b), normal) >= least && dot(cross(b, c), normal) >= least &&
           dot(cross(c, a), normal) >= least;
  }
};

}  // namespace

bool goes_through(Vec3 before, Vec3 now, const MovingTriangle &triangle) {
  const bool was_in_front = Placed(before, now, triangle, 0.0).in_front();
  if (Placed(before, now, triangle, 1.0).in_front() == was_in_front) return false;
  double low = 0.0, high = 1.0;
  for (int k = 0; k < kHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (Placed(before, now, triangle, middle).in_front() == was_in_front ? low : high) = middle;
  }
  return Placed(before, now, triangle, high).inside();
}

}  // namespace flipflow

#include "smooth_patches.h"

#include <algorithm>

namespace flipflow {

namespace {

constexpr double kCosMerged = 0.96592582628906829;    // cos 15 degrees
constexpr double kCosSeparate = 0.70710678118654752;  // cos 45 degrees

// Does `triangle` contain the edge or corner on which `touch` lies?
bool shares_feature(const Touch &touch, const std::vector<Triangle> &triangles, int triangle) {
  const Triangle &own = triangles[touch.triangle], &other = triangles[triangle];
  for (int k = 0; k < 3; ++k)
    if (touch.at.feature >> k & 1 && std::find(other.begin(), other.end(), own[k]) == other.end())
      return false;
  return true;
}

// A triangle is convex, so the distance grows from its closest point in every direction.  A
// place on an edge or corner is therefore a minimum over the surface only if no triangle at that
// edge or corner comes nearer; one that comes as near has the same place.
bool is_minimum(size_t k, const std::vector<Touch> &by_distance,
                const std::vector<Triangle> &triangles) {
  if (by_distance[k].at.feature == 7) return true;
  for (size_t nearer = 0; nearer < k; ++nearer)
    if (shares_feature(by_distance[k], triangles, by_distance[nearer].triangle)) return false;
  return true;
}

// 0 for nearly parallel normals, 1 for clearly different ones, C1 between.
double separation(const Touch &a, const Touch &b) {
  const double cosine = dot(a.away, b.away) / std::sqrt(a.distance2 * b.distance2);
  const double t = std::clamp((kCosMerged - cosine) / (kCosMerged - kCosSeparate), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

}  // namespace

void one_per_smooth_patch(std::vector<Touch> &touches, const std::vector<Triangle> &triangles) {
  std::sort(touches.begin(), touches.end(),
            [](const Touch &a, const Touch &b) { return a.distance2 < b.distance2; });
  for (size_t k = 0; k < touches.size(); ++k) {
    double weight = is_minimum(k, touches, triangles) ? 1.0 : 0.0;
    for (size_t deeper = 0; deeper < k && weight > 0; ++deeper)
      if (touches[deeper].weight > 0)
        weight = std::min(weight, separation(touches[deeper], touches[k]));
    touches[k].weight = weight;
  }
  touches.erase(std::remove_if(touches.begin(), touches.end(),
                               [](const Touch &touch) { return touch.weight <= 0; }),
                touches.end());
}

}  // namespace flipflow

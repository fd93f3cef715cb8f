#include "smooth_patches.h"

#include <algorithm>

namespace flipflow {

namespace {

constexpr double kCosSmooth = 0.96592582628906829;  // cos 15 degrees
constexpr double kCosSharp = 0.70710678118654752;   // cos 45 degrees
constexpr double kLog4 = 1.3862943611198906;
constexpr double kSharpest = 1e7;           // largest power in the p-norm, for folds of 0.04 degrees
constexpr double kLeastLogRatio = -600;     // the logarithm of a ratio that counts as zero
constexpr double kEnergyPower = 2.5;        // of the depth, in a contact's elastic energy (Hertz)
constexpr double kHalfWeight = 0.5;         // the weight of each of two contacts with equal shares
constexpr double kNegligible = 1e-12;       // a weight that disappears in rounding
constexpr double kLeastWeightSum = 1e-300;  // the least sum of weights by which others are divided

// The smooth step from 0 to 1 over t = 0 ... 1; its derivative is 6 t (1 - t).
double smooth_step(double t) { return t * t * (3 - 2 * t); }

// Returns whether `triangle` contains the edge or corner on which `touch` lies.
bool shares_feature(const Touch &touch, const std::vector<Triangle> &triangles, int triangle) {
  const Triangle &own = triangles[touch.triangle], &other = triangles[triangle];
  for (int k = 0; k < 3; ++k)
    if (touch.at.feature >> k & 1 && std::find(other.begin(), other.end(), own[k]) == other.end())
      return false;
  return true;
}

// Returns whether the distance to the surface is a minimum at the k-th place.  A triangle is
// convex, so the distance grows from its closest point in every direction.  A place on an edge or
// corner is therefore a minimum over the surface only if no triangle at that edge or corner comes
// nearer.  A triangle that comes as near has the same place.
bool is_minimum(size_t k, const std::vector<Touch> &by_distance,
                const std::vector<Triangle> &triangles) {
  if (by_distance[k].at.feature == kFace) return true;
  for (size_t nearer = 0; nearer < k; ++nearer)
    if (shares_feature(by_distance[k], triangles, by_distance[nearer].triangle)) return false;
  return true;
}

struct Separation {
  double s;      // 0 (one contact) ... 1 (two contacts)
  double slope;  // -ds / d(cosine of the angle between the normals)
};

// Returns how far two contacts with these normals are apart.  Below 15 degrees
// s = -log2 cos(angle / 2), so that two contacts in the middle of a valley have together the force
// of one contact.  From 15 to 45 degrees s grows to 1 with a smooth step.
Separation separation(Vec3 normal, Vec3 other) {
  const Vec3 between = normal - other;
  const double half_sine2 = std::min(0.25 * dot(between, between), 0.5 * (1 - kCosSharp));
  const double even = -std::log1p(-half_sine2) / kLog4;
  const double range = kCosSmooth - kCosSharp;
  const double t = std::clamp((kCosSmooth - 1 + 2 * half_sine2) / range, 0.0, 1.0);
  const double left = 1 - smooth_step(t);
  const double slope =
      left / ((1 - half_sine2) * 2 * kLog4) + (1 - even) * 6 * t * (1 - t) / range;
  return {1 - (1 - even) * left, slope};
}

Vec3 normal(const Touch &touch) { return (1 / std::sqrt(touch.distance2)) * touch.away; }

// Returns log (U_other / U_nearer)^(1/s) with U = depth^2.5.  A place beyond contact does not
// count.
double log_ratio(const Touch &nearer, const Touch &other, double s) {
  if (other.depth_m <= 0) return kLeastLogRatio;
  const double power = std::min(1 / s, kSharpest);
  return std::max(kLeastLogRatio, kEnergyPower * power * std::log(other.depth_m / nearer.depth_m));
}

// All pairs of a particle's places, and the shares of the force in each pair.  Two places i, j have
// the potential (U_i^(1/s) + U_j^(1/s))^s, so that the weight of i is
// (1 + (U_j / U_i)^(1/s))^(s - 1).
class Pairs {
 public:
  explicit Pairs(const std::vector<Touch> &touches)
      : count_(touches.size()),
        weight_(count_ * count_, 1),
        lost_(count_ * count_, 0),
        push_(count_ * count_, 0) {
    for (size_t i = 0; i < count_; ++i)
      for (size_t j = i + 1; j < count_; ++j) {
        const Separation apart = separation(normal(touches[i]), normal(touches[j]));
        const double log_y = log_ratio(touches[i], touches[j], apart.s);
        const double y = std::exp(log_y), entropy = std::log1p(y) - y / (1 + y) * log_y;
        set(i, j, (apart.s - 1) * std::log1p(y));
        set(j, i, (apart.s - 1) * std::log1p(1 / y));
        push_[i * count_ + j] = push_[j * count_ + i] = entropy * apart.slope;
      }
  }

  // The weight of i if j were the only other place.
  double weight(size_t i, size_t j) const { return weight_[i * count_ + j]; }
  double lost(size_t i, size_t j) const { return lost_[i * count_ + j]; }  // 1 - weight
  // The force by the turning of both normals if both places together have an energy of one.
  double push(size_t i, size_t j) const { return push_[i * count_ + j]; }

  // The share of j that counts for i: it is less if a third place has more of j's force than j.
  double influence(size_t i, size_t j) const {
    double share = 1;
    for (size_t k = 0; k < count_; ++k)
      if (k != i && k != j && weight(j, k) < kHalfWeight)
        share *= 4 * weight(j, k) * (1 - weight(j, k));
    return share;
  }

 private:
  void set(size_t i, size_t j, double log_weight) {
    weight_[i * count_ + j] = std::exp(log_weight);
    lost_[i * count_ + j] = -std::expm1(log_weight);
  }

  size_t count_;
  std::vector<double> weight_, lost_, push_;
};

// Sets the weights of all places.  The weight that i loses to j is a part of j's weight, so that
// the weights that each contact sees add up to one.
void set_weights(std::vector<Touch> &touches, const Pairs &pairs) {
  std::vector<double> first(touches.size(), 1.0);
  for (size_t i = 0; i < touches.size(); ++i)
    for (size_t j = 0; j < touches.size(); ++j)
      if (j != i) first[i] *= 1 - pairs.influence(i, j) * pairs.lost(i, j);
  for (size_t i = 0; i < touches.size(); ++i) {
    double seen = first[i];
    for (size_t j = 0; j < touches.size(); ++j)
      if (j != i) seen += pairs.lost(i, j) / pairs.weight(j, i) * first[j];
    touches[i].weight = first[i] / std::max(seen, kLeastWeightSum);
  }
}

// Returns the gradient, by the particle's centre, of the touch's normal . `toward`.  It is zero on
// a face, and the normal does not turn along an edge.
Vec3 turn(const Touch &touch, Vec3 toward, const SurfacePath &surface, const Triangle &corner) {
  const int feature = touch.at.feature;
  const Vec3 n = normal(touch);
  Vec3 free = toward - dot(toward, n) * n;
  if (feature == kFirstEdge || feature == kClosingEdge || feature == kSecondEdge) {
    const int first = feature == kSecondEdge ? 1 : 0, last = feature == kFirstEdge ? 1 : 2;
    const Vec3 along = surface.position(corner[last]) - surface.position(corner[first]);
    free = free - (dot(free, along) / dot(along, along)) * along;
  }
  return (1 / std::sqrt(touch.distance2)) * free;
}

// Sets the forces of the turning normals.  Where a normal turns, s changes along the way:
// -dU/ds grad s is a force, too, and dU/ds is U times the entropy of the two shares of U.
void set_turning(std::vector<Touch> &touches, const Pairs &pairs, const SurfacePath &surface,
                 const std::vector<Triangle> &triangles) {
  const auto energy = [&](const Touch &touch) {
    return touch.weight * std::pow(std::max(touch.depth_m, 0.0), kEnergyPower);
  };
  for (size_t i = 0; i < touches.size(); ++i) {
    Touch &touch = touches[i];
    if (touch.at.feature == kFace) continue;
    Vec3 toward = {0, 0, 0};
    for (size_t j = 0; j < touches.size(); ++j) {
      if (j == i) continue;
      const double both = (energy(touch) + energy(touches[j])) * pairs.push(i, j);
      toward = toward + both * pairs.influence(i, j) * pairs.influence(j, i) * normal(touches[j]);
    }
    touch.turning = turn(touch, toward, surface, triangles[touch.triangle]);
  }
}

}  // namespace

void keep_minima(std::vector<Touch> &touches, const std::vector<Triangle> &triangles) {
  std::sort(touches.begin(), touches.end(),
            [](const Touch &a, const Touch &b) { return a.distance2 < b.distance2; });
  for (size_t k = 0; k < touches.size(); ++k)
    touches[k].weight = is_minimum(k, touches, triangles) ? 1 : 0;
  touches.erase(std::remove_if(touches.begin(), touches.end(),
                               [](const Touch &touch) { return touch.weight == 0; }),
                touches.end());
}

void share_smooth_patches(std::vector<Touch> &touches, const SurfacePath &surface,
                          const std::vector<Triangle> &triangles) {
  if (touches.size() < 2) return;
  const Pairs pairs(touches);
  set_weights(touches, pairs);
  set_turning(touches, pairs, surface, triangles);
  touches.erase(
      std::remove_if(touches.begin(), touches.end(),
                     [](const Touch &touch) { return touch.weight < kNegligible; }),
      touches.end());
}

}  // namespace flipflow

#include "contact_search.h"

#include <algorithm>

#include "crossing.h"

namespace flipflow {

void ContactSearch::set(std::vector<Triangle> triangles, double largest_reach_m) {
  triangles_ = std::move(triangles);
  joined_ = triangles_;
  largest_reach_ = largest_reach_m;
  no_grid_ = true;
}

void ContactSearch::repeat(double period_m, std::vector<Triangle> joined) {
  period_ = period_m;
  joined_ = std::move(joined);
}

void ContactSearch::surface_moved(double distance_m) {
  since_grid_ += distance_m;
  since_search_ += distance_m;
}

void ContactSearch::search(const SurfacePath &surface, const Spheres &spheres, double factor,
                           double skin_m, bool neighbours_listed_now) {
  if (no_grid_ || since_grid_ > 0.5 * skin_m) {
    grid_.build(surface, triangles_, largest_reach_ * factor + 2.0 * skin_m);
    no_grid_ = false;
    since_grid_ = 0.0;
  }
  const double margin = neighbours_listed_now ? skin_m : 1.5 * skin_m;
  near_.clear();
  candidates_.clear();
  for (int i = 0; i < spheres.count; ++i)
    list(surface, i, from(spheres.position_m[i]), spheres.radius_m[i] * factor + margin);
  since_search_ = 0.0;
}

void ContactSearch::list(const SurfacePath &surface, int sphere, Vec3 position_m, double reach_m) {
  const auto first = candidates_.size();
  look(surface, position_m, 0, reach_m);
  if (period_ > 0) {
    look(surface, image(position_m, -1), -1, reach_m);
    look(surface, image(position_m, 1), 1, reach_m);
  }
  if (candidates_.size() == first) return;
  std::sort(candidates_.begin() + first, candidates_.end(),
            [](const Candidate &a, const Candidate &b) { return a.distance_m < b.distance_m; });
  const int end = static_cast<int>(candidates_.size());
  near_.push_back({sphere, static_cast<int>(first), end, position_m});
}

void ContactSearch::look(const SurfacePath &surface, Vec3 position_m, int image, double reach_m) {
  const auto cell = grid_.near(position_m);
  for (const int *t = cell[0]; t != cell[1]; ++t) {
    const double distance2 = nearest_place(surface, position_m, *t).distance2;
    if (distance2 < reach_m * reach_m) candidates_.push_back({*t, image, std::sqrt(distance2)});
  }
}

Touch ContactSearch::nearest_place(const SurfacePath &surface, Vec3 position_m,
                                   int triangle) const {
  const Triangle &corner = triangles_[triangle];
  const Vec3 a = surface.position(corner[0]), b = surface.position(corner[1]),
             c = surface.position(corner[2]);
  const auto at = closest_point(position_m, a, b, c);
  const Vec3 away = position_m - (at.weight[0] * a + at.weight[1] * b + at.weight[2] * c);
  return {triangle, at, away, dot(away, away)};
}

double ContactSearch::find_touches(const SurfacePath &surface, const Near &near, Vec3 position_m,
                                   double reach_m, std::vector<Touch> &touches) const {
  // no candidate has come nearer by more than this since its distance was taken
  const double approach = norm(position_m - near.position_m) + since_search_;
  double nearest2 = reach_m * reach_m;
  touches.clear();
  for (int k = near.first; k < near.end; ++k) {
    if (candidates_[k].distance_m - approach >= reach_m) break;
    const Touch touch = nearest_place(surface, image(position_m, candidates_[k].image),
                                      candidates_[k].triangle);
    nearest2 = std::min(nearest2, touch.distance2);
    if (touch.distance2 < reach_m * reach_m && touch.distance2 > 0) touches.push_back(touch);
  }
  if (touches.size() > 1) keep_minima(touches, joined_);
  return nearest2;
}

bool ContactSearch::crossed(const SurfacePath &surface, int triangle, Vec3 before_m,
                            Vec3 now_m) const {
  MovingTriangle moving;
  for (int k = 0; k < 3; ++k) {
    moving.before[k] = surface.position_before(triangles_[triangle][k]);
    moving.now[k] = surface.position(triangles_[triangle][k]);
  }
  return goes_through(before_m, now_m, moving);
}

bool ContactSearch::crossed(const SurfacePath &surface, const Near &near, Vec3 before_m,
                            Vec3 now_m) const {
  for (int k = near.first; k < near.end; ++k) {
    const int periods = candidates_[k].image;
    if (crossed(surface, candidates_[k].triangle, image(before_m, periods), image(now_m, periods)))
      return true;
  }
  return false;
}

bool ContactSearch::crossed_any(const SurfacePath &surface, Vec3 before_m, Vec3 now_m) const {
  const int most = period_ > 0 ? 1 : 0;
  for (int periods = -most; periods <= most; ++periods)
    for (size_t t = 0; t < triangles_.size(); ++t)
      if (crossed(surface, static_cast<int>(t), image(before_m, periods), image(now_m, periods)))
        return true;
  return false;
}

void ContactSearch::share(const SurfacePath &surface, std::vector<Touch> &touches) const {
  share_smooth_patches(touches, surface, triangles_);
}

void ContactSearch::save(SavedState &saved) const {
  auto &near = saved.wholes["near"], &candidate = saved.wholes["candidate"];
  auto &position = saved.reals["near_m"], &distance = saved.reals["candidate_m"];
  for (const Near &one : near_) {
    near.insert(near.end(), {one.sphere, one.first, one.end});
    position.insert(position.end(), {one.position_m.x, one.position_m.y, one.position_m.z});
  }
  for (const Candidate &one : candidates_) {
    candidate.insert(candidate.end(), {one.triangle, one.image});
    distance.push_back(one.distance_m);
  }
  saved.reals["since_search_m"] = {since_search_};
}

void ContactSearch::restore(const SavedState &saved) {
  const auto &near = saved.whole("near"), &candidate = saved.whole("candidate");
  const auto &position = saved.real("near_m"), &distance = saved.real("candidate_m");
  const auto number = [](std::int64_t value) { return static_cast<int>(value); };
  near_.clear();
  candidates_.clear();
  for (size_t k = 0; k < near.size(); k += 3)
    near_.push_back({number(near[k]), number(near[k + 1]), number(near[k + 2]), from(&position[k])});
  for (size_t k = 0; k < distance.size(); ++k)
    candidates_.push_back({number(candidate[2 * k]), number(candidate[2 * k + 1]), distance[k]});
  since_search_ = saved.real("since_search_m")[0];
  no_grid_ = true;
}

bool ContactSearch::reached(const SurfacePath &surface, Vec3 place, double reach_m) const {
  const int most = period_ > 0 ? 1 : 0;
  for (int periods = -most; periods <= most; ++periods)
    for (size_t t = 0; t < triangles_.size(); ++t) {
      const Touch touch = nearest_place(surface, image(place, periods), static_cast<int>(t));
      if (touch.distance2 < reach_m * reach_m) return true;
    }
  return false;
}

}  // namespace flipflow

#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "saved_state.h"
#include "smooth_patches.h"
#include "surface_path.h"
#include "triangle_grid.h"

namespace flipflow {

struct Spheres {
  const double *const *position_m;
  const double *radius_m;
  int count;
};

// Finds where spheres touch the moving triangles.  A search lists for every sphere the triangles
// it may touch for a while, as Verlet lists do; the touches of a step come from that list.
//
// A list is good while sphere and surface together move less than its margin.  Neighbours are listed
// anew when a particle moved half a skin against the bed (BedMotion in fix_surface.cpp); this search
// lets surface and bed move another half against each other.
class ContactSearch {
 public:
  struct Near {  // a sphere with candidates first ... end
    int sphere, first, end;
    Vec3 position_m;  // at the search
  };

  void set(std::vector<Triangle> triangles, double largest_reach_m) {
    triangles_ = std::move(triangles);
    joined_ = triangles_;
    largest_reach_ = largest_reach_m;
    no_grid_ = true;
  }

  // The surface goes on after `period_m` along y.  `joined` are the triangles again, with one number
  // for points that are one period apart and the same place.
  void repeat(double period_m, std::vector<Triangle> joined) {
    period_ = period_m;
    joined_ = std::move(joined);
  }

  const Triangle &triangle(int number) const { return triangles_[number]; }

  void surface_moved(double distance_m) {
    since_grid_ += distance_m;
    since_search_ += distance_m;
  }

  // How far the bed as a whole is from where it was when neighbours were last listed.
  void bed_moved(Vec3 way_m) { bed_ = way_m; }

  bool stale(double skin_m) const { return since_search_ + norm(bed_ - bed_at_search_) > 0.5 * skin_m; }

  // A sphere reaches `factor` times its radius.  `neighbours_listed_now`: has LIGGGHTS, too, just
  // listed neighbours?  If not, a sphere may now be half a skin off and go to the other side.
  void search(const SurfacePath &surface, const Spheres &spheres, double factor, double skin_m,
              bool neighbours_listed_now) {
    if (no_grid_ || since_grid_ > 0.5 * skin_m) {
      grid_reach_ = largest_reach_ * factor + 2.0 * skin_m;
      grid_.build(surface, triangles_, grid_reach_);
      no_grid_ = false;
      since_grid_ = 0.0;
    }
    const double margin = neighbours_listed_now ? skin_m : 1.5 * skin_m;
    find_boxes(surface);
    near_.clear();
    candidates_.clear();
    for (int i = 0; i < spheres.count; ++i)
      list(surface, i, from(spheres.position_m[i]), spheres.radius_m[i] * factor + margin);
    since_search_ = 0.0;
    bed_at_search_ = bed_;
  }

  // Does any triangle come nearer to a place than `reach_m`?  Looks at all of them where the grid does not
  // tell.
  bool reached(const SurfacePath &surface, Vec3 place, double reach_m) const {
    const auto nearer = [&](int triangle, int periods) {
      return nearest_place(surface, image(place, periods), triangle).distance2 < reach_m * reach_m;
    };
    if (no_grid_ || reach_m + since_grid_ > grid_reach_) return any_image(nearer);
    const int most = period_ > 0 ? 1 : 0;
    for (int periods = -most; periods <= most; ++periods) {
      const auto cell = grid_.near(image(place, periods));
      if (std::any_of(cell[0], cell[1], [&](int triangle) { return nearer(triangle, periods); }))
        return true;
    }
    return false;
  }

  const std::vector<Near> &near() const { return near_; }

  void save(SavedState &saved) const {
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
    saved.reals["bed_at_search_m"] = {bed_at_search_.x, bed_at_search_.y, bed_at_search_.z};
  }

  // A new grid is made at the next search: any that holds finds the same triangles.
  void restore(const SavedState &saved) {
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
    bed_at_search_ = from(saved.real("bed_at_search_m").data());
    no_grid_ = true;
  }

  // Asks memory for the candidates of a sphere, which are soon wanted.
  void fetch(const Near &near) const { __builtin_prefetch(candidates_.data() + near.first); }

  // The places nearest to a sphere at `position_m`, nearest first, up to `reach_m` away.  Returns the
  // squared distance of the nearest one, or reach_m^2 where there is none.
  double find_touches(const SurfacePath &surface, const Near &near, Vec3 position_m,
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

  // Did a centre that moved evenly from `before_m` to `now_m` since the surface's last move go through
  // one of the sphere's candidates, or through any triangle of the surface?
  bool crossed(const SurfacePath &surface, const Near &near, Vec3 before_m, Vec3 now_m) const {
    for (int k = near.first; k < near.end; ++k) {
      const int periods = candidates_[k].image;
      if (crossed(surface, candidates_[k].triangle, image(before_m, periods), image(now_m, periods)))
        return true;
    }
    return false;
  }

  bool crossed_any(const SurfacePath &surface, Vec3 before_m, Vec3 now_m) const {
    return any_image([&](int triangle, int periods) {
      return crossed(surface, triangle, image(before_m, periods), image(now_m, periods));
    });
  }

  // Makes contacts of those that count, whose depths are set.
  void share(const SurfacePath &surface, std::vector<Touch> &touches) const {
    share_smooth_patches(touches, surface, triangles_);
  }

 private:
  struct Candidate {
    int triangle, image;  // of the sphere: this many periods away
    double distance_m;    // at the search
  };

  Vec3 image(Vec3 position_m, int periods) const {
    return {position_m.x, position_m.y + periods * period_, position_m.z};
  }

  // Does `is_true(triangle, periods)` hold for any triangle and image?
  template <class IsTrue>
  bool any_image(IsTrue is_true) const {
    const int most = period_ > 0 ? 1 : 0;
    for (int periods = -most; periods <= most; ++periods)
      for (size_t t = 0; t < triangles_.size(); ++t)
        if (is_true(static_cast<int>(t), periods)) return true;
    return false;
  }

  bool crossed(const SurfacePath &surface, int triangle, Vec3 before_m, Vec3 now_m) const {
    MovingTriangle moving;
    for (int k = 0; k < 3; ++k) {
      moving.before[k] = surface.position_before(triangles_[triangle][k]);
      moving.now[k] = surface.position(triangles_[triangle][k]);
    }
    return goes_through(before_m, now_m, moving);
  }

  Touch nearest_place(const SurfacePath &surface, Vec3 position_m, int triangle) const {
    const Triangle &corner = triangles_[triangle];
    const Vec3 a = surface.position(corner[0]), b = surface.position(corner[1]),
               c = surface.position(corner[2]);
    const auto at = closest_point(position_m, a, b, c);
    const Vec3 away = position_m - (at.weight[0] * a + at.weight[1] * b + at.weight[2] * c);
    return {triangle, at, away, dot(away, away)};
  }

  // Is a place farther than `reach_m` from the triangle's bounding box along any axis?
  bool boxes_apart(Vec3 position_m, int triangle, double reach_m) const {
    const auto &[low, high] = boxes_m_[triangle];
    const auto apart = [reach_m](double x, double low_m, double high_m) {
      return x + reach_m < low_m || x - reach_m > high_m;
    };
    return apart(position_m.z, low.z, high.z) || apart(position_m.x, low.x, high.x) ||
           apart(position_m.y, low.y, high.y);
  }

  void find_boxes(const SurfacePath &surface) {
    boxes_m_.clear();
    for (const Triangle &corner : triangles_) {
      const Vec3 a = surface.position(corner[0]), b = surface.position(corner[1]),
                 c = surface.position(corner[2]);
      boxes_m_.push_back({{std::min({a.x, b.x, c.x}), std::min({a.y, b.y, c.y}), std::min({a.z, b.z, c.z})},
                          {std::max({a.x, b.x, c.x}), std::max({a.y, b.y, c.y}), std::max({a.z, b.z, c.z})}});
    }
  }

  void list(const SurfacePath &surface, int sphere, Vec3 position_m, double reach_m) {
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

  void look(const SurfacePath &surface, Vec3 position_m, int image, double reach_m) {
    const auto cell = grid_.near(position_m);
    for (const int *t = cell[0]; t != cell[1]; ++t) {
      if (boxes_apart(position_m, *t, reach_m)) continue;
      const double distance2 = nearest_place(surface, position_m, *t).distance2;
      if (distance2 < reach_m * reach_m) candidates_.push_back({*t, image, std::sqrt(distance2)});
    }
  }

  std::vector<Triangle> triangles_, joined_;
  std::vector<std::pair<Vec3, Vec3>> boxes_m_;  // around each triangle at the search: lowest, highest corner
  double period_ = 0.0;
  double largest_reach_ = 0.0;
  TriangleGrid grid_;
  double grid_reach_ = 0.0;  // how near its cells know of triangles
  bool no_grid_ = true;
  double since_grid_ = 0.0, since_search_ = 0.0;  // how far the surface may have moved, m
  Vec3 bed_ = {0, 0, 0}, bed_at_search_ = {0, 0, 0};
  std::vector<Near> near_;
  std::vector<Candidate> candidates_;  // of each sphere, nearest first
};

}  // namespace flipflow

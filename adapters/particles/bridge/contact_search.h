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

// A rigid surface, whose triangles are listed once, where they are in its own axes: those of the edges between
// the four points that carry it, which are equally long and at right angles.
struct RigidSurface {
  int first;  // of the four points
  double edge_m;
  std::vector<int> triangles;
  TriangleGrid grid;

  Vec3 place(const RigidVertex &vertex) const {
    return edge_m * Vec3{vertex.weight[1], vertex.weight[2], vertex.weight[3]};
  }
};

// Where a rigid surface is: takes places of the world to its own axes.  On a path the edges lengthen and turn
// against each other a little; `stretch` is the most by which that lengthens a distance in its own axes.
class RigidPlace {
 public:
  RigidPlace(const SurfacePath &surface, const RigidSurface &of) : origin_(surface.position(of.first)) {
    Vec3 edge[3];
    for (int k = 0; k < 3; ++k) edge[k] = surface.position(of.first + 1 + k) - origin_;
    const double per_volume = of.edge_m / dot(edge[0], cross(edge[1], edge[2]));
    for (int k = 0; k < 3; ++k) row_[k] = per_volume * cross(edge[(k + 1) % 3], edge[(k + 2) % 3]);
    double off2 = 0.0;  // squared sum of rows x rows' - 1
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double off = dot(row_[i], row_[j]) - (i == j);
        off2 += off * off;
      }
    stretch_ = std::sqrt(1.0 + std::sqrt(off2));
  }

  double stretch() const { return stretch_; }
  Vec3 own(Vec3 world) const {
    const Vec3 from = world - origin_;
    return {dot(row_[0], from), dot(row_[1], from), dot(row_[2], from)};
  }

 private:
  Vec3 origin_, row_[3];
  double stretch_;
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

  void set(const SurfacePath &surface, std::vector<Triangle> triangles, double largest_reach_m) {
    triangles_ = std::move(triangles);
    joined_ = triangles_;
    largest_reach_ = largest_reach_m;
    no_grid_ = true;
    rigid_reach_ = 0.0;
    boxes_m_.resize(triangles_.size());
    moving_.clear();
    rigid_.clear();
    for (size_t t = 0; t < triangles_.size(); ++t) {
      const Triangle &corner = triangles_[t];
      if (!surface.is_rigid(corner[0])) {
        moving_.push_back(static_cast<int>(t));
        continue;
      }
      RigidSurface &body = rigid_surface(surface, surface.rigid(corner[0]).first);
      const auto place = [&](int k) { return body.place(surface.rigid(corner[k])); };
      body.triangles.push_back(static_cast<int>(t));
      boxes_m_[t] = TriangleBox::of(place(0), place(1), place(2));
    }
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
    find_boxes(surface);
    if (no_grid_ || since_grid_ > 0.5 * skin_m) {
      grid_reach_ = largest_reach_ * factor + 2.0 * skin_m;
      grid_.build(moving_, boxes_m_, grid_reach_);
      no_grid_ = false;
      since_grid_ = 0.0;
    }
    if (rigid_reach_ != grid_reach_)
      for (RigidSurface &body : rigid_) body.grid.build(body.triangles, boxes_m_, grid_reach_);
    rigid_reach_ = grid_reach_;
    const std::vector<RigidPlace> placed = places(surface);
    const double margin = neighbours_listed_now ? skin_m : 1.5 * skin_m;
    near_.clear();
    candidates_.clear();
    for (int i = 0; i < spheres.count; ++i)
      list(surface, placed, i, from(spheres.position_m[i]), spheres.radius_m[i] * factor + margin);
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
    const std::vector<RigidPlace> placed = places(surface);
    bool found = false;
    for (int periods = -most; periods <= most && !found; ++periods)
      each_near(placed, image(place, periods), reach_m,
                [&](int triangle, Vec3, double) { found = found || nearer(triangle, periods); });
    return found;
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
    saved.reals["bed_m"] = {bed_.x, bed_.y, bed_.z};
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
    bed_ = from(saved.real("bed_m").data());
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

  RigidSurface &rigid_surface(const SurfacePath &surface, int first) {
    for (RigidSurface &body : rigid_)
      if (body.first == first) return body;
    const double edge_m = norm(surface.position(first + 1) - surface.position(first));
    rigid_.push_back({first, edge_m, {}, {}});
    return rigid_.back();
  }

  std::vector<RigidPlace> places(const SurfacePath &surface) const {
    std::vector<RigidPlace> placed;
    placed.reserve(rigid_.size());
    for (const RigidSurface &body : rigid_) placed.emplace_back(surface, body);
    return placed;
  }

  // Visits the triangles that may lie within `reach_m` of a place: `visit(triangle, place, reach)`, with place
  // and reach in the axes of the triangle's box.
  template <class Visit>
  void each_near(const std::vector<RigidPlace> &placed, Vec3 place_m, double reach_m, Visit visit) const {
    const auto cell = grid_.near(place_m);
    for (const int *t = cell[0]; t != cell[1]; ++t) visit(*t, place_m, reach_m);
    for (size_t b = 0; b < rigid_.size(); ++b) {
      const Vec3 own_m = placed[b].own(place_m);
      const double reach = placed[b].stretch() * reach_m;
      if (reach > grid_reach_) {  // an interval in which it turns by far more than machines do
        for (const int t : rigid_[b].triangles) visit(t, own_m, reach);
        continue;
      }
      const auto near = rigid_[b].grid.near(own_m);
      for (const int *t = near[0]; t != near[1]; ++t) visit(*t, own_m, reach);
    }
  }

  // The boxes around the triangles that move by themselves, where they are now.
  void find_boxes(const SurfacePath &surface) {
    for (const int t : moving_) {
      const Triangle &corner = triangles_[t];
      boxes_m_[t] = TriangleBox::of(surface.position(corner[0]), surface.position(corner[1]),
                                    surface.position(corner[2]));
    }
  }

  void list(const SurfacePath &surface, const std::vector<RigidPlace> &placed, int sphere, Vec3 position_m,
            double reach_m) {
    const auto first = candidates_.size();
    look(surface, placed, position_m, 0, reach_m);
    if (period_ > 0) {
      look(surface, placed, image(position_m, -1), -1, reach_m);
      look(surface, placed, image(position_m, 1), 1, reach_m);
    }
    if (candidates_.size() == first) return;
    std::sort(candidates_.begin() + first, candidates_.end(),
              [](const Candidate &a, const Candidate &b) { return a.distance_m < b.distance_m; });
    const int end = static_cast<int>(candidates_.size());
    near_.push_back({sphere, static_cast<int>(first), end, position_m});
  }

  void look(const SurfacePath &surface, const std::vector<RigidPlace> &placed, Vec3 position_m, int image,
            double reach_m) {
    each_near(placed, position_m, reach_m, [&](int triangle, Vec3 place_m, double reach) {
      if (boxes_m_[triangle].apart(place_m, reach)) return;
      const double distance2 = nearest_place(surface, position_m, triangle).distance2;
      if (distance2 < reach_m * reach_m) candidates_.push_back({triangle, image, std::sqrt(distance2)});
    });
  }

  std::vector<Triangle> triangles_, joined_;
  std::vector<int> moving_;  // triangles that are not of a rigid surface
  std::vector<RigidSurface> rigid_;
  std::vector<TriangleBox> boxes_m_;  // at the search; in its own axes of a rigid surface
  double period_ = 0.0;
  double largest_reach_ = 0.0;
  TriangleGrid grid_;
  double grid_reach_ = 0.0, rigid_reach_ = 0.0;  // how near cells know of triangles
  bool no_grid_ = true;
  double since_grid_ = 0.0, since_search_ = 0.0;  // how far the surface may have moved, m
  Vec3 bed_ = {0, 0, 0}, bed_at_search_ = {0, 0, 0};
  std::vector<Near> near_;
  std::vector<Candidate> candidates_;  // of each sphere, nearest first
};

}  // namespace flipflow

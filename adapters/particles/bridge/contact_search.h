#pragma once

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
// A list is good while sphere and surface together move less than its margin.  LIGGGHTS lets a
// particle move half a skin from where it was when its neighbours were last listed, this search
// lets the surface move another half.
class ContactSearch {
 public:
  struct Near {  // a sphere with candidates first ... end
    int sphere, first, end;
    Vec3 position_m;  // at the search
  };

  void set(std::vector<Triangle> triangles, double largest_reach_m);

  // The surface goes on after `period_m` along y.  `joined` are the triangles again, with one number
  // for points that are one period apart and the same place.
  void repeat(double period_m, std::vector<Triangle> joined);
  const Triangle &triangle(int number) const { return triangles_[number]; }

  void surface_moved(double distance_m);
  bool stale(double skin_m) const { return since_search_ > 0.5 * skin_m; }

  // A sphere reaches `factor` times its radius.  `neighbours_listed_now`: has LIGGGHTS, too, just
  // listed neighbours?  If not, a sphere may now be half a skin off and go to the other side.
  void search(const SurfacePath &surface, const Spheres &spheres, double factor, double skin_m,
              bool neighbours_listed_now);

  // Does any triangle come nearer to a place than `reach_m`?  Looks at all of them.
  bool reached(const SurfacePath &surface, Vec3 place, double reach_m) const;

  const std::vector<Near> &near() const { return near_; }

  void save(SavedState &saved) const;
  // A new grid is made at the next search: any that holds finds the same triangles.
  void restore(const SavedState &saved);

  // The places nearest to a sphere at `position_m`, nearest first, up to `reach_m` away.  Returns the
  // squared distance of the nearest one, or reach_m^2 where there is none.
  double find_touches(const SurfacePath &surface, const Near &near, Vec3 position_m, double reach_m,
                      std::vector<Touch> &touches) const;

  // Did a centre that moved evenly from `before_m` to `now_m` since the surface's last move go through
  // one of the sphere's candidates, or through any triangle of the surface?
  bool crossed(const SurfacePath &surface, const Near &near, Vec3 before_m, Vec3 now_m) const;
  bool crossed_any(const SurfacePath &surface, Vec3 before_m, Vec3 now_m) const;

  // Makes contacts of those that count, whose depths are set.
  void share(const SurfacePath &surface, std::vector<Touch> &touches) const;

 private:
  struct Candidate {
    int triangle, image;  // of the sphere: this many periods away
    double distance_m;    // at the search
  };

  Vec3 image(Vec3 position_m, int periods) const {
    return {position_m.x, position_m.y + periods * period_, position_m.z};
  }
  bool crossed(const SurfacePath &surface, int triangle, Vec3 before_m, Vec3 now_m) const;
  Touch nearest_place(const SurfacePath &surface, Vec3 position_m, int triangle) const;
  void list(const SurfacePath &surface, int sphere, Vec3 position_m, double reach_m);
  void look(const SurfacePath &surface, Vec3 position_m, int image, double reach_m);

  std::vector<Triangle> triangles_, joined_;
  double period_ = 0.0;
  double largest_reach_ = 0.0;
  TriangleGrid grid_;
  bool no_grid_ = true;
  double since_grid_ = 0.0, since_search_ = 0.0;  // how far the surface may have moved, m
  std::vector<Near> near_;
  std::vector<Candidate> candidates_;  // of each sphere, nearest first
};

}  // namespace flipflow

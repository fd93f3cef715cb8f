#pragma once

#include <vector>

#include "saved_state.h"
#include "surface_path.h"
#include "triangle_grid.h"

namespace flipflow {

// Impulse of this rank's particles on each surface point, and the surface's work on them.
//
// Velocity Verlet gives a particle half a step of the force at the interval's start, a whole one
// of each force inside and half a one of the force at the end.  The sums here do the same, so
// that the impulse is the particles' change of momentum to rounding, and the moment of the impulses
// their change of angular momentum.
class SurfaceLoad {
 public:
  void set(int points);

  // The surface jumps from where it is to `start_m`, against the present forces.
  void jump(const SurfacePath &surface, const double *start_m);
  void begin(const SurfacePath &surface, double step_s);
  void next_evaluation(bool last);
  // Forces on the corners of a triangle, which is where it is in `surface`.
  void add(const SurfacePath &surface, const Triangle &corner, const Vec3 *force, double step_s);
  void end_evaluation(double step_s);  // after which there are `step_s` to the next one
  void end(double step_s);

  void save(SavedState &saved) const;
  void restore(const SavedState &saved);

  const std::vector<double> &impulse_N_s() const { return impulse_; }  // begin ... end
  const std::vector<double> &force_N() const { return force_; }        // last evaluation
  double work_J() const { return work_; }                              // since t = 0
  // Of the impulses on the points, about the world's origin, since t = 0.
  Vec3 angular_impulse_N_m_s() const { return angular_impulse_; }

 private:
  std::vector<double> impulse_, force_;
  double work_ = 0.0, power_ = 0.0;
  Vec3 angular_impulse_ = {0, 0, 0}, moment_ = {0, 0, 0};  // moment: of the last evaluation
  bool last_ = false;
};

}  // namespace flipflow

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
// that the impulse is the particles' change of momentum to rounding.
class SurfaceLoad {
 public:
  void set(int points);

  // The surface jumps from where it is to `start_m`, against the present forces.
  void jump(const SurfacePath &surface, const double *start_m);
  void begin(const SurfacePath &surface, double step_s);
  void next_evaluation(bool last);
  void add(const Triangle &corner, const double *weight, Vec3 force_on_particle, Vec3 velocity,
           double step_s);
  void end(double step_s);

  void save(SavedState &saved) const;
  void restore(const SavedState &saved);

  const std::vector<double> &impulse_N_s() const { return impulse_; }  // begin ... end
  const std::vector<double> &force_N() const { return force_; }        // last evaluation
  double work_J() const { return work_; }                              // since t = 0

 private:
  std::vector<double> impulse_, force_;
  double work_ = 0.0, power_ = 0.0;
  bool last_ = false;
};

}  // namespace flipflow

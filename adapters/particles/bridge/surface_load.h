#pragma once

#include <algorithm>
#include <vector>

#include "saved_state.h"
#include "surface_path.h"
#include "triangle.h"

namespace flipflow {

// Impulse of this rank's particles on each surface point, and the surface's work on them.  What acts on a rigid
// surface goes to the four points that carry it, with the same sum, moment and power.
//
// Velocity Verlet gives a particle half a step of the force at the interval's start, a whole one
// of each force inside and half a one of the force at the end.  The sums here do the same, so
// that the impulse is the particles' change of momentum to rounding, and the moment of the impulses
// their change of angular momentum.
class SurfaceLoad {
 public:
  void set(int points) {
    force_.assign(3 * points, 0.0);
    impulse_ = force_;
  }

  // The surface jumps from where it is to `start_m`: against the mean of the forces before and after.
  void jump(const SurfacePath &surface, const double *start_m) {
    for (int p = 0; p < surface.points(); ++p)
      work_ -= 0.5 * dot(from(&force_[3 * p]), from(&start_m[3 * p]) - surface.position(p));
  }

  void begin(const SurfacePath &surface, double step_s) {
    const double half = 0.5 * step_s;
    angular_impulse_ = angular_impulse_ + half * moment_;
    for (int p = 0; p < surface.points(); ++p) work_ -= 0.5 * dot(from(&force_[3 * p]), surface.jump_m(p));
    for (size_t k = 0; k < impulse_.size(); ++k) {
      impulse_[k] = half * force_[k];
      work_ -= half * force_[k] * surface.start_velocity()[k];
    }
  }

  void next_evaluation(bool last) {
    last_ = last;
    power_ = 0.0;
    moment_ = {0, 0, 0};
    if (last) std::fill(force_.begin(), force_.end(), 0.0);
  }

  // Forces on the corners of a triangle, which is where it is in `surface`.
  void add(const SurfacePath &surface, const Triangle &corner, const Vec3 *force, double step_s) {
    for (int k = 0; k < 3; ++k) {
      const int p = corner[k];
      power_ -= dot(force[k], surface.velocity(p));
      moment_ = moment_ + cross(surface.position(p), force[k]);
      surface.hand_on(p, force[k], [&](int point, Vec3 part) {
        add_to(&impulse_[3 * point], step_s * part);
        if (last_) add_to(&force_[3 * point], part);
      });
    }
  }

  // after which there are `step_s` to the next one
  void end_evaluation(double step_s) {
    work_ += step_s * power_;
    angular_impulse_ = angular_impulse_ + step_s * moment_;
  }

  void end(double step_s) {
    const double half = 0.5 * step_s;
    for (size_t k = 0; k < impulse_.size(); ++k) impulse_[k] -= half * force_[k];
    work_ -= half * power_;
    angular_impulse_ = angular_impulse_ - half * moment_;
  }

  void save(SavedState &saved) const {
    saved.reals["surface_force_N"] = force_;
    saved.reals["surface_work_J"] = {work_};
    for (Vec3 of : {angular_impulse_, moment_})
      for (double part : {of.x, of.y, of.z}) saved.reals["surface_moments"].push_back(part);
  }

  void restore(const SavedState &saved) {
    force_ = saved.real("surface_force_N");
    work_ = saved.real("surface_work_J")[0];
    const double *moments = saved.real("surface_moments").data();
    angular_impulse_ = from(moments);
    moment_ = from(moments + 3);
  }

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

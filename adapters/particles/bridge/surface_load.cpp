#include "surface_load.h"

#include <algorithm>

namespace flipflow {

void SurfaceLoad::set(int points) {
  force_.assign(3 * points, 0.0);
  impulse_ = force_;
}

void SurfaceLoad::jump(const SurfacePath &surface, const double *start_m) {
  for (int p = 0; p < surface.points(); ++p)
    work_ -= dot(from(&force_[3 * p]), from(&start_m[3 * p]) - surface.position(p));
}

void SurfaceLoad::begin(const SurfacePath &surface, double step_s) {
  const double half = 0.5 * step_s;
  for (size_t k = 0; k < impulse_.size(); ++k) {
    impulse_[k] = half * force_[k];
    work_ -= half * force_[k] * surface.start_velocity()[k];
  }
}

void SurfaceLoad::next_evaluation(bool last) {
  last_ = last;
  power_ = 0.0;
  if (last) std::fill(force_.begin(), force_.end(), 0.0);
}

void SurfaceLoad::add(const Triangle &corner, const double *weight, Vec3 force_on_particle,
                      Vec3 velocity, double step_s) {
  const double power = dot(force_on_particle, velocity);
  work_ += step_s * power;
  power_ += power;
  for (int k = 0; k < 3; ++k) {
    const Vec3 share = -weight[k] * force_on_particle;
    add_to(&impulse_[3 * corner[k]], step_s * share);
    if (last_) add_to(&force_[3 * corner[k]], share);
  }
}

void SurfaceLoad::save(SavedState &saved) const {
  saved.reals["surface_force_N"] = force_;
  saved.reals["surface_work_J"] = {work_};
}

void SurfaceLoad::restore(const SavedState &saved) {
  force_ = saved.real("surface_force_N");
  work_ = saved.real("surface_work_J")[0];
}

void SurfaceLoad::end(double step_s) {
  const double half = 0.5 * step_s;
  for (size_t k = 0; k < impulse_.size(); ++k) impulse_[k] -= half * force_[k];
  work_ -= half * power_;
}

}  // namespace flipflow

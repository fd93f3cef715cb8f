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
  angular_impulse_ = angular_impulse_ + half * moment_;
  for (size_t k = 0; k < impulse_.size(); ++k) {
    impulse_[k] = half * force_[k];
    work_ -= half * force_[k] * surface.start_velocity()[k];
  }
}

void SurfaceLoad::next_evaluation(bool last) {
  last_ = last;
  power_ = 0.0;
  moment_ = {0, 0, 0};
  if (last) std::fill(force_.begin(), force_.end(), 0.0);
}

void SurfaceLoad::add(const SurfacePath &surface, const Triangle &corner, const Vec3 *force,
                      double step_s) {
  for (int k = 0; k < 3; ++k) {
    const int p = corner[k];
    power_ -= dot(force[k], surface.velocity(p));
    moment_ = moment_ + cross(surface.position(p), force[k]);
    add_to(&impulse_[3 * p], step_s * force[k]);
    if (last_) add_to(&force_[3 * p], force[k]);
  }
}

void SurfaceLoad::end_evaluation(double step_s) {
  work_ += step_s * power_;
  angular_impulse_ = angular_impulse_ + step_s * moment_;
}

void SurfaceLoad::save(SavedState &saved) const {
  saved.reals["surface_force_N"] = force_;
  saved.reals["surface_work_J"] = {work_};
  for (Vec3 of : {angular_impulse_, moment_})
    for (double part : {of.x, of.y, of.z}) saved.reals["surface_moments"].push_back(part);
}

void SurfaceLoad::restore(const SavedState &saved) {
  force_ = saved.real("surface_force_N");
  work_ = saved.real("surface_work_J")[0];
  const double *moments = saved.real("surface_moments").data();
  angular_impulse_ = from(moments);
  moment_ = from(moments + 3);
}

void SurfaceLoad::end(double step_s) {
  const double half = 0.5 * step_s;
  for (size_t k = 0; k < impulse_.size(); ++k) impulse_[k] -= half * force_[k];
  work_ -= half * power_;
  angular_impulse_ = angular_impulse_ - half * moment_;
}

}  // namespace flipflow

#pragma once

#include <vector>

#include "contact_interface.h"

#include "saved_state.h"
#include "triangle_grid.h"
#include "vec3.h"

namespace flipflow {

// Wear of the surface by what slides on it: worn volume = rate x force x distance slid
// (J. F. Archard, J. Appl. Phys. 24 (1953) 981-988), on the corners of the triangle.
//
// The force is the one that friction goes by.  Slid is what the tangential spring does not take
// up, so that a contact that sticks wears nothing however soft it is.
class Wear {
 public:
  using Contact = LIGGGHTS::ContactModels::SurfacesIntersectData;

  Wear() = default;
  // `rate_m3_per_N_m` (types x types); `spring`: where the tangential spring is in a contact's history,
  // -1 without one.
  Wear(std::vector<double> rate_m3_per_N_m, int types, int spring, int points)
      : rate_m3_per_N_m_(std::move(rate_m3_per_N_m)),
        types_(types),
        spring_(spring),
        worn_m3_(points, 0.0) {}

  Vec3 before(const double *history) const {
    return spring_ < 0 ? Vec3{0, 0, 0} : from(history + spring_);
  }
  // A touching contact after the contact model; types count from 1.
  void after(Vec3 spring_before_m, const Contact &contact, const double *history,
             const Triangle &corner, const double *corner_share, double share, double step_s);

  void save(SavedState &saved) const { saved.reals["worn_m3"] = worn_m3_; }
  void restore(const SavedState &saved) { worn_m3_ = saved.real("worn_m3"); }

  const std::vector<double> &worn_m3() const { return worn_m3_; }  // since t = 0, by point

 private:
  std::vector<double> rate_m3_per_N_m_;
  int types_ = 0, spring_ = -1;
  std::vector<double> worn_m3_;
};

// In its place where nothing wears: it leaves nothing to do in the compiled loop.
struct NoWear {
  template <class... Any>
  int before(Any &&...) const {
    return 0;
  }
  template <class... Any>
  void after(Any &&...) const {}
};

}  // namespace flipflow

#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "contact_interface.h"

#include "saved_state.h"
#include "triangle.h"

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
  // A touching contact after the contact model, which moved by its slip; types count from 1.
  void after(Vec3 spring_before_m, Vec3 slip_m_per_s, const Contact &contact, const double *history,
             const Triangle &corner, const double *corner_share, double share, double step_s) {
    if (step_s == 0.0) return;  // a first evaluation: no time has passed
    const Vec3 normal = from(contact.en);
    const Vec3 stretched_m = spring_before_m + step_s * slip_m_per_s;
    const Vec3 across_m = stretched_m - dot(stretched_m, normal) * normal;
    const double slid_m = norm(across_m - before(history));
    const double rate = rate_m3_per_N_m_[(contact.itype - 1) * types_ + contact.jtype - 1];
    const double worn = share * rate * std::abs(contact.Fn) * slid_m;
    for (int k = 0; k < 3; ++k) worn_m3_[corner[k]] += corner_share[k] * worn;
  }

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

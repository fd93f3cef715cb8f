#include "wear.h"

#include <cmath>

namespace flipflow {

void Wear::after(Vec3 spring_before_m, const Contact &contact, const double *history,
                 const Triangle &corner, const double *corner_share, double share, double step_s) {
  if (step_s == 0.0) return;  // a first evaluation: no time has passed
  const Vec3 slip_m_per_s = {contact.vtr1, contact.vtr2, contact.vtr3}, normal = from(contact.en);
  const Vec3 stretched_m = spring_before_m + step_s * slip_m_per_s;
  const Vec3 across_m = stretched_m - dot(stretched_m, normal) * normal;
  const double slid_m = norm(across_m - before(history));
  const double rate = rate_m3_per_N_m_[(contact.itype - 1) * types_ + contact.jtype - 1];
  const double worn = share * rate * std::abs(contact.Fn) * slid_m;
  for (int k = 0; k < 3; ++k) worn_m3_[corner[k]] += corner_share[k] * worn;
}

}  // namespace flipflow

#pragma once

#include "contact_models.h"

namespace flipflow {

// LIGGGHTS's rolling model `epsd2` keeps the couple of its spring as it was while the normal turns, so
// that a part along the normal appears which no rotation takes back.  On contacts that stick it
// spins particles up without end.  Here the couple stays across the normal, as the tangential
// spring does; it is three values of the contact's history.
inline void keep_across(double *couple, const double *normal) {
  const double along = couple[0] * normal[0] + couple[1] * normal[1] + couple[2] * normal[2];
  for (int k = 0; k < 3; ++k) couple[k] -= along * normal[k];
}

// One of LIGGGHTS's own contact models with `tangential history` and `rolling_friction epsd2`, cured.
template <class Model>
class RollingAcross : public Model {
 public:
  using Model::Model;

  void surfacesIntersect(LIGGGHTS::ContactModels::SurfacesIntersectData &pair,
                         LIGGGHTS::ContactModels::ForceData &on_i,
                         LIGGGHTS::ContactModels::ForceData &on_j) {
    keep_across(pair.contact_history + 3, pair.en);  // after the tangential spring
    Model::surfacesIntersect(pair, on_i, on_j);
  }
};

}  // namespace flipflow

#pragma once

#include <algorithm>

#include "contact_models.h"
#include "deepest_overlap.h"

namespace flipflow {

// A contact model that keeps the deepest overlap between particles of all steps.
template <class Model>
class WatchedContact : public Model {
 public:
  WatchedContact(LAMMPS_NS::LAMMPS *lmp, LIGGGHTS::IContactHistorySetup *history, bool is_wall,
                 int64_t hash)
      : Model(lmp, history, is_wall, hash), deepest_(deepest_between(*lmp)) {}

  void surfacesIntersect(LIGGGHTS::ContactModels::SurfacesIntersectData &pair,
                         LIGGGHTS::ContactModels::ForceData &on_i,
                         LIGGGHTS::ContactModels::ForceData &on_j) {
    Model::surfacesIntersect(pair, on_i, on_j);  // which sets the overlap of a pair
    if (!pair.is_wall) deepest_.add(pair.deltan, std::min(pair.radi, pair.radj));
  }

 private:
  DeepestOverlap &deepest_;
};

}  // namespace flipflow

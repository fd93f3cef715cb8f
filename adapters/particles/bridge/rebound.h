#pragma once

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "contact_models.h"
#include "lammps.h"

namespace flipflow {

// The restitution of a pair of materials over the normal speed with which two bodies first touch: linear
// between the points, constant beyond them.
struct Rebound {
  std::vector<double> speed_m_per_s, restitution;  // speeds grow

  double at(double approach_m_per_s) const {
    const size_t next = std::upper_bound(speed_m_per_s.begin(), speed_m_per_s.end(), approach_m_per_s) -
                        speed_m_per_s.begin();
    if (next == 0) return restitution.front();
    if (next == speed_m_per_s.size()) return restitution.back();
    const double share =
        (approach_m_per_s - speed_m_per_s[next - 1]) / (speed_m_per_s[next] - speed_m_per_s[next - 1]);
    return restitution[next - 1] + share * (restitution[next] - restitution[next - 1]);
  }

  // LIGGGHTS's `betaeff`, by which its damping gives this restitution.
  double damping(double approach_m_per_s) const {
    const double log_e = std::log(at(approach_m_per_s));
    return log_e / std::sqrt(log_e * log_e + M_PI * M_PI);
  }
};

// By atom types, from 1, in both orders; known before the input names a contact model.
using Rebounds = std::map<std::pair<int, int>, Rebound>;
inline std::map<const LAMMPS_NS::LAMMPS *, Rebounds> rebounds_of;

// A contact model whose restitution goes by the speed of approach.  That speed is the last value of the
// contact's history; a contact that is new has zero there.  Where no pair has a rebound of its own, there is
// no such value, and the model is the one that it is made of.
template <class Model>
class ReboundBySpeed : public Model {
  using Touching = LIGGGHTS::ContactModels::SurfacesIntersectData;
  using Close = LIGGGHTS::ContactModels::SurfacesCloseData;
  using Forces = LIGGGHTS::ContactModels::ForceData;

 public:
  ReboundBySpeed(LAMMPS_NS::LAMMPS *lmp, LIGGGHTS::IContactHistorySetup *history, bool is_wall, int64_t hash)
      : Model(lmp, history, is_wall, hash),
        rebounds_(rebounds_of[lmp]),
        approach_(rebounds_.empty() ? kNone : history->add_history_value("approach", "0")) {}

  void connectToProperties(PropertyRegistry &registry) {
    Model::connectToProperties(registry);
    if (approach_ != kNone) registry.connect("betaeff", damping_, "restitution over speed");
  }

  void surfacesIntersect(Touching &pair, Forces &on_i, Forces &on_j) {
    if (approach_ != kNone) {
      double &approach_m_per_s = pair.contact_history[approach_];
      if (approach_m_per_s == 0.0) approach_m_per_s = std::max(closing_m_per_s(pair), DBL_MIN);
      damp(pair, approach_m_per_s);
    }
    Model::surfacesIntersect(pair, on_i, on_j);
  }

  // A neck may hold a contact whose bodies do not overlap any more.
  void surfacesClose(Close &pair, Forces &on_i, Forces &on_j) {
    if (approach_ == kNone) return Model::surfacesClose(pair, on_i, on_j);
    const double approach_m_per_s = pair.contact_history[approach_];
    if (approach_m_per_s > 0.0) damp(pair, approach_m_per_s);
    Model::surfacesClose(pair, on_i, on_j);
    // the history of a pair that LIGGGHTS does not yet list as touching is not to be written to
    if (approach_m_per_s > 0.0 && !pair.has_force_update) pair.contact_history[approach_] = 0.0;
  }

 private:
  static constexpr int kNone = -1;

  static double closing_m_per_s(const Touching &pair) {
    double along = 0.0;
    for (int k = 0; k < 3; ++k) along += (pair.v_i[k] - pair.v_j[k]) * pair.en[k];
    return -along;
  }

  // The model takes its damping from LIGGGHTS's table by types.
  void damp(const Close &pair, double approach_m_per_s) const {
    const auto found = rebounds_.find({pair.itype, pair.jtype});
    if (found != rebounds_.end())
      damping_[pair.itype][pair.jtype] = found->second.damping(approach_m_per_s);
  }

  const Rebounds &rebounds_;
  int approach_;
  double **damping_ = nullptr;
};

}  // namespace flipflow

#pragma once

#include "jkr_normal.h"
#include "rolling_across.h"

namespace flipflow {

// A whole contact model for LIGGGHTS: ours in normal direction, with its own tangential and rolling
// models.  LIGGGHTS calls surfacesIntersect while spheres overlap and surfacesClose while they are
// near; a neck that holds makes the second into the first.
template <int tangential_model, int rolling_model>
class JkrContact : public LIGGGHTS::ContactModels::ContactModelBase {
  using Touching = JkrNormal::Touching;
  using Close = JkrNormal::Close;
  using Forces = JkrNormal::Forces;
  using History = LIGGGHTS::IContactHistorySetup;

 public:
  static constexpr int kModel = 40;  // its number among the normal models, unused by LIGGGHTS
  static constexpr int64_t kHash = kModel | tangential_model << 6 | rolling_model << 18;

  JkrContact(LAMMPS_NS::LAMMPS *lmp, History *history, bool is_wall, int64_t)
      : ContactModelBase(lmp, is_wall),
        atom_(*lmp->atom),
        normal_(history),
        surface_(lmp, history, this),
        tangential_(lmp, history, this),
        rolling_(lmp, history, this) {}

  int64_t hashcode() { return kHash; }
  double stressStrainExponent() { return 1.5; }
  void tally_pp(double, int, int, int) override {}
  void tally_pw(double, int, int, int) override {}

  void registerSettings(Settings &settings) {
    surface_.registerSettings(settings);
    tangential_.registerSettings(settings);
    rolling_.registerSettings(settings);
  }

  void postSettings(History *history) {
    surface_.postSettings(history, this);
    tangential_.postSettings(history, this);
    rolling_.postSettings(history, this);
  }

  void connectToProperties(PropertyRegistry &registry) {
    tangential_.connectToProperties(registry);
    rolling_.connectToProperties(registry);
    normal_.connect(registry);
  }

  void beginPass(Touching &, Forces &, Forces &) {}
  void endPass(Touching &, Forces &, Forces &) {}
  bool checkSurfaceIntersect(Touching &) { return true; }
  void endSurfacesIntersect(Touching &, LAMMPS_NS::TriMesh *, Forces &, Forces &) {}

  void surfacesIntersect(Touching &pair, Forces &on_i, Forces &on_j) {
    surface_.surfacesIntersect(pair, on_i, on_j);
    normal_.push(pair, on_i, on_j);
    tangential_.surfacesIntersect(pair, on_i, on_j);
    if (rolling_model == LIGGGHTS::ContactModels::ROLLING_EPSD2)
      keep_across(pair.contact_history + 4, pair.en);  // after the neck and the tangential spring
    rolling_.surfacesIntersect(pair, on_i, on_j);
  }

  void surfacesClose(Close &close, Forces &on_i, Forces &on_j) {
    const double distance = std::sqrt(close.rsq);
    if (!normal_.holds(close, close.radsum - distance)) {
      normal_.snap(close);
      tangential_.surfacesClose(close, on_i, on_j);
      rolling_.surfacesClose(close, on_i, on_j);
      return;
    }
    Touching &pair = static_cast<Touching &>(close);  // what pairs and walls really hand over
    if (!pair.is_wall) complete(pair, distance);
    surfacesIntersect(pair, on_i, on_j);
    pair.has_force_update = true;
  }

  bool contact_match(const std::string &, const std::string &) { return false; }

 private:
  // What LIGGGHTS fills in for overlapping pairs only.
  void complete(Touching &pair, double distance_m) const {
    const int i = pair.i, j = pair.j;
    pair.r = distance_m;
    pair.rinv = 1.0 / distance_m;
    for (int k = 0; k < 3; ++k) pair.en[k] = pair.delta[k] * pair.rinv;
    pair.mi = atom_.rmass[i];
    pair.mj = atom_.rmass[j];
    pair.meff = pair.mi * pair.mj / (pair.mi + pair.mj);
    pair.omega_i = atom_.omega[i];
    pair.omega_j = atom_.omega[j];
  }

  const LAMMPS_NS::Atom &atom_;
  JkrNormal normal_;  // first, so that the history begins with the neck
  LIGGGHTS::ContactModels::SurfaceModel<LIGGGHTS::ContactModels::SURFACE_DEFAULT> surface_;
  LIGGGHTS::ContactModels::TangentialModel<tangential_model> tangential_;
  LIGGGHTS::ContactModels::RollingModel<rolling_model> rolling_;
};

}  // namespace flipflow

#pragma once

#include "contact_models.h"
#include "global_properties.h"
#include "jkr.h"
#include "shared_contacts.h"
#include "step_end.h"
#include "update.h"

namespace flipflow {

// Normal force of an adhesive contact for LIGGGHTS, in place of its `hertz`, from which it differs
// by the neck alone: stiffness and damping are Hertz's with the neck's radius for the contact's.
//
// What friction and rolling resistance may reach is set by the force plus twice the pull-off force
// (C. Thornton, J. Phys. D 24 (1991) 1942-1946).
class JkrNormal {
 public:
  using Touching = LIGGGHTS::ContactModels::SurfacesIntersectData;
  using Close = LIGGGHTS::ContactModels::SurfacesCloseData;
  using Forces = LIGGGHTS::ContactModels::ForceData;

  // The history keeps the neck's radius in m, zero while there is no contact.
  explicit JkrNormal(LIGGGHTS::IContactHistorySetup *history)
      : neck_(history->add_history_value("neck", "0")) {}

  void connect(PropertyRegistry &registry) {
    const char *model = "model jkr";
    registry.registerProperty("Yeff", &MODEL_PARAMS::createYeff, model);
    registry.registerProperty("Geff", &MODEL_PARAMS::createGeff, model);
    registry.registerProperty("betaeff", &MODEL_PARAMS::createBetaEff, model);
    registry.registerProperty("workOfAdhesion", &create_work, model);
    registry.connect("Yeff", e_star_Pa_, model);
    registry.connect("Geff", g_star_Pa_, model);
    registry.connect("betaeff", damping_, model);
    registry.connect("workOfAdhesion", work_J_per_m2_, model);
  }

  bool holds(const Close &pair, double overlap_m) const {
    return pair.contact_history[neck_] > 0.0 && law(pair).holds(overlap_m);
  }

  void snap(Close &pair) const {
    // the history of a pair that LIGGGHTS does not yet list as touching is not to be written to
    if (pair.contact_history[neck_] > 0.0) pair.contact_history[neck_] = 0.0;
    if (pair.contact_flags) *pair.contact_flags &= ~LIGGGHTS::ContactModels::CONTACT_NORMAL_MODEL;
  }

  // Finds the neck of a contact that holds, and what its springs and dampers give.
  StepEnd::Law hold(Touching &pair, double overlap_m) const {
    const Jkr jkr = law(pair);
    const double neck = jkr.neck_m(overlap_m, pair.contact_history[neck_]);
    const double stiffness = 2.0 * jkr.e_star_Pa * neck;
    const double shear = 8.0 * g_star_Pa_[pair.itype][pair.jtype] * neck;
    const double factor = -2.0 * std::sqrt(5.0 / 6.0) * damping_[pair.itype][pair.jtype];
    pair.contact_history[neck_] = neck;
    if (pair.contact_flags) *pair.contact_flags |= LIGGGHTS::ContactModels::CONTACT_NORMAL_MODEL;
    return {jkr.force_N(neck), factor * std::sqrt(stiffness * pair.meff), shear,
            factor * std::sqrt(shear * pair.meff)};
  }

  void push(Touching &pair, const StepEnd::Law &held, Forces &on_i, Forces &on_j) const {
    pair.gamman = held.damping_N_s_per_m;
    pair.gammat = held.shear_damping_N_s_per_m;
    pair.kt = held.shear_N_per_m;
    const double elastic = held.elastic_N;
    const double force = elastic - pair.gamman * pair.vn, pull = 2.0 * law(pair).pull_off_N();
    for (int k = 0; k < 3; ++k) {
      on_i.delta_F[k] += force * pair.en[k];
      on_j.delta_F[k] -= force * pair.en[k];
    }
    // tangential and rolling models take their limits from Fn, `cdt` from kn * deltan
    pair.Fn = force + pull;
    pair.kn = pair.deltan == 0.0 ? 0.0 : (elastic + pull) / pair.deltan;
  }

 private:
  Jkr law(const Close &pair) const {
    const double i = pair.radi, j = pair.radj;
    return {e_star_Pa_[pair.itype][pair.jtype], work_J_per_m2_[pair.itype][pair.jtype],
            pair.is_wall ? i : i * j / (i + j)};
  }

  static MatrixProperty *create_work(PropertyRegistry &registry, const char *caller, bool) {
    return MODEL_PARAMS::createPerTypePairProperty(registry, "workOfAdhesion", caller);
  }

  int neck_;
  double **e_star_Pa_ = nullptr, **g_star_Pa_ = nullptr, **damping_ = nullptr,
         **work_J_per_m2_ = nullptr;
};

// LIGGGHTS's rolling model `epsd2` keeps the couple of its spring as it was while the normal turns, so
// that a part along the normal appears which no rotation takes back.  On contacts that stick it
// spins particles up without end.  Here the couple stays across the normal, as the tangential
// spring does; it is three values of the contact's history.
inline void keep_across(double *couple, const double *normal) {
  const double along = couple[0] * normal[0] + couple[1] * normal[1] + couple[2] * normal[2];
  for (int k = 0; k < 3; ++k) couple[k] -= along * normal[k];
}

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
        lmp_(*lmp),
        atom_(*lmp->atom),
        normal_(history),
        surface_(lmp, history, this),
        tangential_(lmp, history, this),
        rolling_(lmp, history, this),
        update_(*lmp->update),
        step_end_(history) {}

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
    const StepEnd::Law law = normal_.hold(pair, pair.is_wall ? pair.deltan : pair.radsum - pair.r);
    step_end_.apply(pair, law, kSpring, update_.dt, [&] {
      surface_.surfacesIntersect(pair, on_i, on_j);
      normal_.push(pair, law, on_i, on_j);
      tangential_.surfacesIntersect(pair, on_i, on_j);
      if (rolling_model == LIGGGHTS::ContactModels::ROLLING_EPSD2)
        keep_across(pair.contact_history + 4, pair.en);  // after the neck and the tangential spring
      rolling_.surfacesIntersect(pair, on_i, on_j);
    });
  }

  void surfacesClose(Close &close, Forces &on_i, Forces &on_j) {
    const double distance = std::sqrt(close.rsq);
    if (!normal_.holds(close, close.radsum - distance)) {
      normal_.snap(close);
      step_end_.forget(close);
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
    if (!bodies_of.count(&lmp_)) pair.meff = pair.mi * pair.mj / (pair.mi + pair.mj);  // else set by SpherePairs
    pair.omega_i = atom_.omega[i];
    pair.omega_j = atom_.omega[j];
  }

  static constexpr int kSpring = tangential_model == LIGGGHTS::ContactModels::TANGENTIAL_OFF ? -1 : 1;

  const LAMMPS_NS::LAMMPS &lmp_;
  const LAMMPS_NS::Atom &atom_;
  JkrNormal normal_;  // first, so that the history begins with the neck
  LIGGGHTS::ContactModels::SurfaceModel<LIGGGHTS::ContactModels::SURFACE_DEFAULT> surface_;
  LIGGGHTS::ContactModels::TangentialModel<tangential_model> tangential_;
  LIGGGHTS::ContactModels::RollingModel<rolling_model> rolling_;
  const LAMMPS_NS::Update &update_;
  StepEnd step_end_;
};

}  // namespace flipflow

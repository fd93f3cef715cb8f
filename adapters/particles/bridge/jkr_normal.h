#pragma once

#include "contact_models.h"
#include "global_properties.h"
#include "jkr.h"

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
    return pair.contact_history[neck_] > 0.0 && overlap_m >= law(pair).separation_m();
  }

  void snap(Close &pair) const {
    // the history of a pair that LIGGGHTS does not yet list as touching is not to be written to
    if (pair.contact_history[neck_] > 0.0) pair.contact_history[neck_] = 0.0;
    if (pair.contact_flags) *pair.contact_flags &= ~LIGGGHTS::ContactModels::CONTACT_NORMAL_MODEL;
  }

  void push(Touching &pair, Forces &on_i, Forces &on_j) const {
    const Jkr jkr = law(pair);
    const double neck = jkr.neck_m(pair.deltan), elastic = jkr.force_N(neck);
    const double stiffness = 2.0 * jkr.e_star_Pa * neck;
    const double shear = 8.0 * g_star_Pa_[pair.itype][pair.jtype] * neck;
    const double factor = -2.0 * std::sqrt(5.0 / 6.0) * damping_[pair.itype][pair.jtype];
    pair.contact_history[neck_] = neck;
    if (pair.contact_flags) *pair.contact_flags |= LIGGGHTS::ContactModels::CONTACT_NORMAL_MODEL;
    pair.gamman = factor * std::sqrt(stiffness * pair.meff);
    pair.gammat = factor * std::sqrt(shear * pair.meff);
    pair.kt = shear;
    const double force = elastic - pair.gamman * pair.vn, pull = 2.0 * jkr.pull_off_N();
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

}  // namespace flipflow

// Adds to LIGGGHTS's tables of contact models, for pairs and for walls: `model jkr`, and its own
// `model hertz` compiled for the combinations that flipflow uses (LIGGGHTS would call every part of
// them through a table), with rolling friction `epsd2` cured.  In both, dampers go by the velocities of the
// step's end, and restitution may go by speed.

#include <mpi.h>

#include <cmath>

#include "atom.h"
#include "comm.h"
#include "error.h"
#include "fix_insert_stream.h"
#include "fix_mesh_surface.h"
#include "force.h"
#include "memory.h"
#include "modify.h"
#include "neigh_list.h"
#include "neighbor.h"
#include "update.h"
#include "vector_liggghts.h"

#include "contact_models.h"
#include "fix_wall_gran_base.h"
#include "granular_pair_style.h"
#include "granular_wall.h"
#include "pair_gran_base.h"

#include "engine.h"
#include "jkr_contact.h"
#include "rebound.h"
#include "sphere_pairs.h"
#include "step_end.h"

namespace flipflow {

namespace {

using namespace LIGGGHTS;
using namespace LIGGGHTS::ContactModels;

// One of LIGGGHTS's own contact models with `model hertz`, with dampers by the velocities of the step's end and
// with `rolling_friction epsd2` cured.
template <class Style>
class HertzContact : public ContactModel<Style> {
  using Model = ContactModel<Style>;
  static constexpr int kSpring = Style::TANGENTIAL == TANGENTIAL_OFF ? -1 : 0;  // the history begins with it

 public:
  HertzContact(LAMMPS_NS::LAMMPS *lmp, IContactHistorySetup *history, bool is_wall, int64_t hash)
      : Model(lmp, history, is_wall, hash), update_(*lmp->update), step_end_(history) {}

  void connectToProperties(PropertyRegistry &registry) {
    Model::connectToProperties(registry);
    registry.connect("Yeff", e_star_Pa_, "step's end");
    registry.connect("Geff", g_star_Pa_, "step's end");
    registry.connect("betaeff", damping_, "step's end");
  }

  void surfacesIntersect(SurfacesIntersectData &pair, ForceData &on_i, ForceData &on_j) {
    if (Style::ROLLING == ROLLING_EPSD2) keep_across(pair.contact_history + 3, pair.en);  // after the spring
    step_end_.apply(pair, law(pair), kSpring, update_.dt, [&] { Model::surfacesIntersect(pair, on_i, on_j); });
  }

  void surfacesClose(SurfacesCloseData &pair, ForceData &on_i, ForceData &on_j) {
    step_end_.forget(pair);
    Model::surfacesClose(pair, on_i, on_j);
  }

 private:
  StepEnd::Law law(const SurfacesIntersectData &pair) const {
    const int i = pair.itype, j = pair.jtype;
    const double overlap_m = pair.is_wall ? pair.deltan : pair.radsum - pair.r;
    const double radius_m = pair.is_wall ? pair.radi : pair.radi * pair.radj / pair.radsum;
    const double neck_m = std::sqrt(radius_m * overlap_m);
    const double stiffness = 2.0 * e_star_Pa_[i][j] * neck_m, shear = 8.0 * g_star_Pa_[i][j] * neck_m;
    const double damping = -2.0 * std::sqrt(5.0 / 6.0) * damping_[i][j] * std::sqrt(pair.meff);
    return {2.0 / 3.0 * stiffness * overlap_m, damping * std::sqrt(stiffness), shear,
            damping * std::sqrt(shear)};
  }

  const LAMMPS_NS::Update &update_;
  StepEnd step_end_;
  double **e_star_Pa_ = nullptr, **g_star_Pa_ = nullptr, **damping_ = nullptr;
};

template <class Interface, class Style>
Interface *create(LAMMPS_NS::LAMMPS *lmp, typename Interface::ParentType *parent, int64_t hash) {
  return new Style(lmp, parent, hash);
}

template <class Contact, class Pairs, int64_t hash>
void add() {
  PairStyles::Factory::instance().addStyle("gran", hash, &create<PairStyles::IGranularPairStyle, Pairs>);
  Walls::Factory::instance().addStyle(
      "gran", hash, &create<Walls::IGranularWall, Walls::Granular<Contact>>);
}

template <int tangential, int cohesion, int rolling>
void add_hertz() {
  using Style = GranStyle<HERTZ, tangential, cohesion, rolling, SURFACE_DEFAULT>;
  using Contact = ReboundBySpeed<HertzContact<Style>>;
  add<Contact, SpherePairs<Contact>, Style::HASHCODE>();
}

template <int tangential, int rolling>
void add_all(bool as_packaged) {
  using Jkr = JkrContact<tangential, rolling>;
  using Sticky = ReboundBySpeed<Jkr>;
  if (as_packaged) return add<Sticky, PairStyles::Granular<Sticky>, Jkr::kHash>();
  add<Sticky, SpherePairs<Sticky>, Jkr::kHash>();
  add_hertz<tangential, COHESION_OFF, rolling>();
  add_hertz<tangential, COHESION_SJKR, rolling>();
}

}  // namespace

void register_contact_models(bool as_packaged) {
  ContactModels::Factory::instance().addNormalModel("jkr", JkrContact<0, 0>::kModel);
  add_all<TANGENTIAL_OFF, ROLLING_OFF>(as_packaged);
  add_all<TANGENTIAL_HISTORY, ROLLING_OFF>(as_packaged);
  add_all<TANGENTIAL_HISTORY, ROLLING_CDT>(as_packaged);
  add_all<TANGENTIAL_HISTORY, ROLLING_EPSD2>(as_packaged);
}

}  // namespace flipflow

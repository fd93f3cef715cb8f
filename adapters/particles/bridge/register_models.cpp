// Adds to LIGGGHTS's tables of contact models, for pairs and for walls: `model jkr`, and its own
// `model hertz` compiled for the combinations that flipflow uses (LIGGGHTS would call every part of
// them through a table), with rolling friction `epsd2` cured.  In both, restitution may go by speed.

#include <mpi.h>

#include <type_traits>

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

namespace flipflow {

namespace {

using namespace LIGGGHTS;
using namespace LIGGGHTS::ContactModels;

// One of LIGGGHTS's own contact models with `tangential history` and `rolling_friction epsd2`, cured.
template <class Model>
class RollingAcross : public Model {
 public:
  using Model::Model;

  void surfacesIntersect(SurfacesIntersectData &pair, ForceData &on_i, ForceData &on_j) {
    keep_across(pair.contact_history + 3, pair.en);  // after the tangential spring
    Model::surfacesIntersect(pair, on_i, on_j);
  }
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
  using Stock = ContactModel<Style>;
  constexpr bool cured = rolling == ROLLING_EPSD2;
  using Contact = ReboundBySpeed<std::conditional_t<cured, RollingAcross<Stock>, Stock>>;
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

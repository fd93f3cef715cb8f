// Adds to LIGGGHTS's tables of contact models, for pairs and for walls: `model jkr`, and its own
// `model hertz` compiled for the combinations that flipflow uses (LIGGGHTS would call every part of
// them through a table), with rolling friction `epsd2` cured.

#include <mpi.h>

#include <type_traits>
#include <vector>

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

// A contact model that keeps the deepest overlap between particles of all steps.
//
// Of pairs that are near it asks the model about those alone that touched: the others have nothing to
// forget, and to write zeros over their histories would fill the caches.  A large bed's histories do not
// stay there from step to step; as a step meets nearly the same contacts as the last one, those that come next
// are fetched ahead.
template <class Model>
class WatchedContact : public Model {
 public:
  WatchedContact(LAMMPS_NS::LAMMPS *lmp, IContactHistorySetup *history, bool is_wall, int64_t hash)
      : Model(lmp, history, is_wall, hash), deepest_(deepest_between[lmp]) {}

  void beginPass(SurfacesIntersectData &pair, ForceData &on_i, ForceData &on_j) {
    histories_.resize(met_);
    met_ = 0;
    Model::beginPass(pair, on_i, on_j);
  }

  void surfacesIntersect(SurfacesIntersectData &pair, ForceData &on_i, ForceData &on_j) {
    if (!pair.is_wall) meet(pair.contact_history);
    Model::surfacesIntersect(pair, on_i, on_j);  // which sets the overlap of a pair
    if (!pair.is_wall) deepest_.add(pair.deltan, std::min(pair.radi, pair.radj));
  }

  void surfacesClose(SurfacesCloseData &pair, ForceData &on_i, ForceData &on_j) {
    if (pair.contact_flags && *pair.contact_flags == 0) return;
    if (!pair.is_wall) meet(pair.contact_history);
    Model::surfacesClose(pair, on_i, on_j);
  }

 private:
  // Remembers a contact's history for the next step, and asks memory for one that comes soon.
  void meet(const double *history) {
    if (met_ + kAhead < histories_.size()) {
      const double *soon = histories_[met_ + kAhead];  // where there is none any more, nothing happens
      __builtin_prefetch(soon);
      __builtin_prefetch(soon + kValues - 1);
    }
    if (met_ == histories_.size()) histories_.push_back(history);
    histories_[met_++] = history;
  }

  static constexpr size_t kAhead = 16;  // contacts
  static constexpr int kValues = 7;  // of a history at most
  DeepestOverlap &deepest_;
  std::vector<const double *> histories_;  // of the last step's contacts, in their order
  size_t met_ = 0;
};

template <class Interface, class Style>
Interface *create(LAMMPS_NS::LAMMPS *lmp, typename Interface::ParentType *parent, int64_t hash) {
  return new Style(lmp, parent, hash);
}

template <class Contact, int64_t hash>
void add() {
  PairStyles::Factory::instance().addStyle(
      "gran", hash, &create<PairStyles::IGranularPairStyle, PairStyles::Granular<Contact>>);
  Walls::Factory::instance().addStyle(
      "gran", hash, &create<Walls::IGranularWall, Walls::Granular<Contact>>);
}

template <int tangential, int cohesion, int rolling>
void add_hertz() {
  using Style = GranStyle<HERTZ, tangential, cohesion, rolling, SURFACE_DEFAULT>;
  using Stock = ContactModel<Style>;
  constexpr bool cured = rolling == ROLLING_EPSD2;
  using Contact = std::conditional_t<cured, RollingAcross<Stock>, Stock>;
  add<WatchedContact<Contact>, Style::HASHCODE>();
}

template <int tangential, int rolling>
void add_all(bool as_packaged) {
  using Sticky = JkrContact<tangential, rolling>;
  if (as_packaged) return add<Sticky, Sticky::kHash>();
  add<WatchedContact<Sticky>, Sticky::kHash>();
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

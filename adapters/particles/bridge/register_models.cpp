// Adds `model jkr` to LIGGGHTS's tables of contact models, for pairs and for walls.

#include "register_models.h"

#include <mpi.h>

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

#include "jkr_contact.h"

namespace flipflow {

namespace {

using namespace LIGGGHTS;
using namespace LIGGGHTS::ContactModels;

template <class Interface, class Style>
Interface *create(LAMMPS_NS::LAMMPS *lmp, typename Interface::ParentType *parent, int64_t hash) {
  return new Style(lmp, parent, hash);
}

template <int tangential, int rolling>
void add() {
  using Contact = JkrContact<tangential, rolling>;
  PairStyles::Factory::instance().addStyle(
      "gran", Contact::kHash, &create<PairStyles::IGranularPairStyle, PairStyles::Granular<Contact>>);
  Walls::Factory::instance().addStyle(
      "gran", Contact::kHash, &create<Walls::IGranularWall, Walls::Granular<Contact>>);
}

}  // namespace

void register_contact_models() {
  static bool done = false;
  if (done) return;
  done = true;
  ContactModels::Factory::instance().addNormalModel("jkr", JkrContact<0, 0>::kModel);
  add<TANGENTIAL_OFF, ROLLING_OFF>();
  add<TANGENTIAL_HISTORY, ROLLING_OFF>();
  add<TANGENTIAL_HISTORY, ROLLING_CDT>();
  add<TANGENTIAL_HISTORY, ROLLING_EPSD2>();
}

}  // namespace flipflow
